"""Declared friction of a body that is geared to the motor: a diagnosis sees it in the motor's joint."""

import pytest

from symid import Axis, Body, CoulombFriction, Drive, Geared, Position, ViscousFriction, simulate
from symid.diagnosis import diagnose
from symid.simulation import plant_of, trapezoids, tuned_cascade

MOTOR = Body("motor", inertia="J")
TABLE = Body("table", mass=50.0, geared=Geared(to=MOTOR, ratio=0.0271))
AXIS = Axis(
    "rack",
    (MOTOR, TABLE, ViscousFriction(TABLE, "Fv"), CoulombFriction(TABLE, "Fs")),
    Drive("T", MOTOR, held=True, noise=0.01),
    (Position("q", MOTOR, noise=1e-6),),
)
TRUE = {"J": 0.01, "Fv": 300.0, "Fs": 60.0}


def test_parameters_of_friction_behind_a_gear() -> None:
    path = trapezoids(8.0, [6.0, 15.0], acceleration=150.0, jerk=6e3, dwell=0.1, sampling_period=1e-3)
    log = simulate(AXIS, TRUE, path, tuned_cascade(plant_of(AXIS, TRUE), "q")).log
    found = diagnose(AXIS, log, nominal={name: 1.15 * value for name, value in TRUE.items()})
    assert found.verdict == "parameters", found.sentence
    for change in found.parameters:
        assert change.reidentified == pytest.approx(TRUE[change.name], rel=0.01), change.name
