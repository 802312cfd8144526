"""Diagnosis of logs with force sensors and scaled sensors, simulated with and without what the model lacks."""

from __future__ import annotations

import pytest
from axes.force_sensors import CELL, DRIVE, LOAD, LOAD_SCALE, MOTOR, MOTOR_SCALE, SHAFT, VALUES, celled

import symid
from symid import ActuatorDelay, Axis, CoulombFriction, Force, Position, StiffnessNonlinearity
from symid.diagnosis import Diagnosis, diagnose
from symid.diagnosis.in_motion.declared import explained_axis
from symid.errors import SettingError
from symid.simulation import chirp, plant_of, simulate, tuned_cascade

REFERENCE = chirp(0.5, 20.0, 2.5, 0.002, sampling_period=1e-3)
TRANSDUCER = Force("fd", DRIVE, noise=0.1)
SCALED = Position("ql", LOAD, gain="cq", offset="oq", noise=5e-8)


def diagnosed(
    axis: Axis, *effects: symid.Element, nominal: dict[str, float] | None = None, **values: float
) -> Diagnosis:
    machine, known = axis.with_effect(*effects) if effects else axis, VALUES | values
    log = simulate(machine, known, REFERENCE, tuned_cascade(plant_of(axis, known), "qm"), seed=3).log
    return diagnose(axis, log, nominal=nominal)


@pytest.mark.parametrize(
    "sensors",
    [(MOTOR_SCALE, CELL), (MOTOR_SCALE, LOAD_SCALE, CELL), (MOTOR_SCALE, TRANSDUCER), (MOTOR_SCALE, SCALED)],
)
def test_a_clean_log_shows_no_gap(sensors: tuple[symid.Sensor, ...]) -> None:
    found = diagnosed(celled(sensors), cq=1.02, oq=0.003)
    assert found.verdict == "no_gap", found.sentence


def test_friction_of_the_load_is_found_beside_a_load_cell() -> None:
    found = diagnosed(celled((MOTOR_SCALE, LOAD_SCALE, CELL)), CoulombFriction(LOAD, "Fsl"), Fsl=6.0)
    assert [(one.effect, one.at) for one in found.effects] == [("coulomb_friction", "load")]
    assert found.effects[0].parameters["Fs"].value == pytest.approx(6.0, rel=0.05)


def test_an_axis_is_written_with_the_scale_that_was_identified() -> None:
    found = diagnosed(celled((MOTOR_SCALE, SCALED)), CoulombFriction(LOAD, "Fsl"), Fsl=6.0, cq=1.02, oq=0.003)
    assert [(one.effect, one.at) for one in found.effects] == [("coulomb_friction", "load")]
    assert any(statement.startswith("ql is taken with gain 1.02") for statement in found.assumptions)
    written = explained_axis(found)
    assert written.axis.sensors[1] == SCALED
    assert written.axis.known == {"cq": pytest.approx(1.02, rel=1e-4), "oq": pytest.approx(0.003, rel=1e-3)}


def test_a_nominal_scale_that_the_log_contradicts_is_identified() -> None:
    wrong = VALUES | {"cq": 1.15, "oq": 0.0}
    found = diagnosed(
        celled((MOTOR_SCALE, SCALED)), CoulombFriction(LOAD, "Fsl"), nominal=wrong, Fsl=6.0, cq=1.02, oq=0.003
    )
    assert [(one.effect, one.at) for one in found.effects] == [("coulomb_friction", "load")]
    assert any(statement.startswith("ql is taken with gain 1.02") for statement in found.assumptions)


def test_a_delay_of_the_drive_is_one_of_the_drive_and_not_of_its_transducer() -> None:
    found = diagnosed(celled((MOTOR_SCALE, LOAD_SCALE, TRANSDUCER)), ActuatorDelay(2e-3))
    assert [(one.effect, one.at) for one in found.effects] == [("delay", "actuator")]


def test_a_gain_that_the_log_does_not_determine_is_asked_for() -> None:
    axis = celled((Position("qm", MOTOR, gain="cq", noise=1e-8),))
    with pytest.raises(SettingError, match="the log does not determine cq: give the known ones"):
        diagnosed(axis, cq=1.02)


def test_a_bent_spring_that_is_read_shares_its_joint_with_no_other_law() -> None:
    axis = celled().with_effect(StiffnessNonlinearity(SHAFT.at, "k3"))
    with pytest.raises(symid.SymidError, match="shares its joint with CoulombFriction: put that at a body"):
        axis.with_effect(CoulombFriction(SHAFT.at, "Fs"))
