"""Friction behind a gear: forces of a slide are far larger than the torque of the motor that moves it."""

import math

import numpy as np
import pytest

from symid import (
    Axis,
    Between,
    Body,
    Cogging,
    CoulombFriction,
    Drive,
    Geared,
    Law,
    Position,
    Spring,
    ViscousFriction,
    load_axis,
    simulate,
)
from symid.data import Log
from symid.diagnosis import diagnose
from symid.diagnosis.effects import LIBRARY
from symid.diagnosis.fitting.state import first_state
from symid.diagnosis.prediction.data import Recording, data_of
from symid.diagnosis.prediction.drive_force import drive_force_of
from symid.diagnosis.prediction.joined_logs import joined
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


SCREW, SLIDE = Body("screw", inertia="J"), Body("slide", mass="M")
LEAD = 0.0127 / (2 * math.pi)
NUT = Spring("nut", Between(first=SCREW, second=SLIDE, ratio=LEAD), stiffness="K", damping="D")
ELEMENTS = (SCREW, ViscousFriction(SCREW, "Fv"), SLIDE, ViscousFriction(SLIDE, "Fw"), NUT)
SENSORS = (Position("q", SCREW, noise=2e-6), Position("z", SLIDE, noise=2e-8))
FEED = Axis("feed", ELEMENTS, Drive("T", SCREW, held=True, noise=0.01), SENSORS)
BY_CURRENT = Axis("feed", ELEMENTS, Drive("i", SCREW, gain="Kt", unit="A"), SENSORS)
VALUES = {"J": 3e-3, "Fv": 0.01, "M": 180.0, "Fw": 700.0, "K": 4e7, "D": 2e4}


@pytest.mark.parametrize(
    ("law", "named", "value"),
    [
        (CoulombFriction(SLIDE, "Fs"), "coulomb_friction", {"Fs": 250.0}),
        (Cogging(SLIDE, "As", "Ac", pitch=0.03), "cogging", {"As": 60.0, "Ac": 25.0}),
    ],
)
def test_the_law_of_a_slide_is_found_behind_its_screw(law: Law, named: str, value: dict[str, float]) -> None:
    machine, values = FEED.with_effect(law), VALUES | value
    path = trapezoids(100.0, [60.0, 100.0], acceleration=900.0, jerk=2e4, dwell=0.1, sampling_period=1e-3)
    log = simulate(machine, values, path, tuned_cascade(plant_of(machine, values), "q")).log
    library = [effect for effect in LIBRARY if effect.name in (named, "encoder_ripple", "stribeck_friction")]
    nominal = {name: 1.1 * value for name, value in VALUES.items()}
    found = diagnose(FEED, log, nominal=nominal, library=library)
    assert (found.effects[0].effect, found.effects[0].at) == (named, "slide"), found.sentence
    for name, true in value.items():
        assert found.effects[0].parameters[name].value == pytest.approx(true, rel=0.05)


DIRECT = {"Mm": 90.0, "Ms": 60.0, "Ks": 1e6, "Fvs": 1e2, "Fvm": 1e2, "Fsm": 3.0}


@pytest.mark.parametrize(
    ("axis", "values", "force"),
    [
        (FEED, VALUES, {"screw": 1.0, "slide": LEAD, "nut": LEAD}),
        (BY_CURRENT, VALUES | {"Kt": 0.5}, {"screw": 2.0, "slide": 2 * LEAD, "nut": 2 * LEAD}),
        (load_axis("direct_2m1s"), DIRECT, {"motor": 1.0, "structure": 1.0}),
    ],
)
def test_force_in_a_joint_as_the_drive_feels_it(
    axis: Axis, values: dict[str, float], force: dict[str, float]
) -> None:
    t = np.arange(4000) / 1000
    log = Log.from_arrays(
        {
            name: np.sin(20 * t)
            for name in (axis.only_drive.signal, *(sensor.signal for sensor in axis.sensors))
        },
        sampling_period=1e-3,
    )
    prediction = first_state(data_of(axis, (joined([log]), None), Recording({}, True)).record, values)[
        0
    ].prediction
    for name, joint in (prediction.joints | prediction.springs).items():
        assert drive_force_of(prediction, joint) == pytest.approx(force[name], rel=1e-6)
