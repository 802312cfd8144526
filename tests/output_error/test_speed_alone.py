"""Output error from sensors of speed alone, which do not tell where a free axis is."""

from dataclasses import replace

import pytest

import symid
from symid import Axis, Body, CoulombFriction, Drive, Position, Preparation, Spring, Velocity, ViscousFriction
from symid.data import Log
from symid.simulation import chirp, plant_of, simulate, tuned_cascade

MOTOR, LOAD = Body("motor", mass="Mm"), Body("load", mass="Ml")
FRICTION = ViscousFriction(MOTOR, "Fv"), CoulombFriction(MOTOR, "Fs")
SPRING = Spring("belt", symid.Between(first=MOTOR, second=LOAD), stiffness="K", damping="C")
RIGID = {"Mm": 12.0, "Fv": 30.0, "Fs": 6.0}
FLEXIBLE = {**RIGID, "Ml": 7.0, "K": 9e4, "C": 40.0}


def without_position(axis: Axis, values: dict[str, float]) -> tuple[Axis, Log]:
    """The axis with its sensors of speed, and a log of a controller that sees its position."""
    reference = chirp(0.5, 30.0, 5.0, 0.2, sampling_period=1e-3, quantity="velocity")
    run = simulate(axis, values, reference, tuned_cascade(plant_of(axis, values), "q", bandwidth_hz=15.0)).log
    speeds = tuple(sensor for sensor in axis.sensors if isinstance(sensor, Velocity))
    kept = {name: run[name] for name in ("F", *(sensor.signal for sensor in speeds))}
    return replace(axis, sensors=speeds), Log.from_arrays(kept, sampling_period=run.sampling_period)


@pytest.mark.parametrize("flexible", [False, True])
def test_a_speed_alone_determines_what_a_position_does_but_the_place(flexible: bool) -> None:
    elements = (MOTOR, *FRICTION, *((LOAD, SPRING) if flexible else ()))
    sensors = Position("q", MOTOR), Velocity("v", MOTOR, noise=2e-5)
    declared = Axis("belt" if flexible else "slide", elements, Drive("F", MOTOR, noise=0.05), sensors)
    values = FLEXIBLE if flexible else RIGID
    axis, log = without_position(declared, values)
    found = symid.identify(axis, log, method="oe", preparation=Preparation(held=True))
    assert found.status == "ok", found.message
    deviations = dict(zip(found.physical_parameters, found.physical_deviations, strict=True))
    for name, value in found.physical_parameters.items():
        assert value == pytest.approx(values[name], abs=4 * deviations[name], rel=1e-3), name
        assert deviations[name] < 0.1 * abs(values[name]), name
