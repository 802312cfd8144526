"""Instruments of an axis with an accelerometer under a held force, which jumps at each sample."""

from functools import cache

import pytest

from symid import Acceleration, Axis, Body, Drive, Log, Position, Spring, ViscousFriction, identify, simulate
from symid.simulation import chirp, plant_of, tuned_cascade

BASE = Body("base", mass="Mb")
MOTOR = Body("motor", mass="Mm", on=BASE)
AXIS = Axis(
    "on_feet",
    (BASE, Spring("feet", BASE, stiffness="K", damping="D"), MOTOR, ViscousFriction(MOTOR, "Fv")),
    Drive("F", MOTOR, held=True, noise=0.5),
    (Position("q", MOTOR, noise=2e-8), Acceleration("a", BASE, noise=1e-3)),
)
TRUE = {"Mb": 400.0, "K": 3e6, "D": 2500.0, "Mm": 40.0, "Fv": 100.0}


@cache
def logged() -> Log:
    reference = chirp(2.0, 40.0, 6.0, 0.15, sampling_period=1e-3, quantity="velocity")
    controller = tuned_cascade(plant_of(AXIS, TRUE), "q", bandwidth_hz=20.0)
    return simulate(AXIS, TRUE, reference, controller, seed=3).log


def test_the_log_is_completed_for_instruments_too() -> None:
    found = identify(AXIS, logged(), method="iv")
    assert found.status == "ok", found.message
    assert any("each step of the held force" in note for note in found.notes)
    for name, value in found.physical_parameters.items():  # D is lost without it
        assert value == pytest.approx(TRUE[name], rel=0.05), name
