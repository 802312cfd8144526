"""What one of two drives does to its force: simulated, found in that drive, and written to the axis."""

from __future__ import annotations

import numpy as np
import pytest

from symid import (
    ActuatorDelay,
    Axis,
    Body,
    CoulombFriction,
    Drive,
    ForceLimit,
    Geared,
    Position,
    ViscousFriction,
    axis_source,
)
from symid.codegen import declared_delays
from symid.data import Log
from symid.diagnosis import diagnose
from symid.diagnosis.effects import LIBRARY
from symid.diagnosis.in_motion.declared import explained_axis
from symid.errors import DeclarationError
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascades

LEFT, RIGHT = Body("left", mass=30.0), Body("right", mass=34.0)
BEAM = Body("beam", mass="Mb", geared=(Geared(to=LEFT, ratio=0.5), Geared(to=RIGHT, ratio=0.5)))
FRICTION = (
    *(ViscousFriction(LEFT, "Fv1"), CoulombFriction(LEFT, "Fs1")),
    *(ViscousFriction(RIGHT, "Fv2"), CoulombFriction(RIGHT, "Fs2")),
)
OF_DRIVES = ("delay", "actuator_lag", "recorded_lag", "saturation", "gain_nonlinearity", "gain_asymmetry")
LIBRARY_OF_DRIVES = [effect for effect in LIBRARY if effect.name in OF_DRIVES]
VALUES = {"Mb": 80.0, "Fv1": 110.0, "Fs1": 25.0, "Fv2": 140.0, "Fs2": 32.0}


def gantry(*, held: bool = True) -> Axis:
    drives = (Drive("F1", LEFT, held=held, noise=0.3), Drive("F2", RIGHT, held=held, noise=0.3))
    scales = (Position("q1", LEFT, noise=2e-7), Position("q2", RIGHT, noise=2e-7))
    return Axis("gantry", (LEFT, RIGHT, BEAM, *FRICTION), drives, scales)


def logged(machine: Axis) -> Log:
    path = trapezoids(
        [0.2, 0.1, 0.3], [0.3, 0.5, 0.8], acceleration=4.0, jerk=200.0, dwell=0.1, sampling_period=1e-3
    )
    loops = tuned_cascades(plant_of(gantry(), VALUES), ("q1", "q2"))
    return simulate(machine, VALUES, path, loops, seed=1).log


def test_a_delay_is_in_the_drive_that_it_names() -> None:
    late = gantry().with_effect(ActuatorDelay(2e-3, drive="F2")).with_signal("F1", 0.0).with_signal("F2", 0.0)
    masses, log = np.array([[30.0 + 20.0, 20.0], [20.0, 34.0 + 20.0]]), logged(late)
    speed = np.stack([np.gradient(log[name], 1e-3) for name in ("q1", "q2")])
    moving = np.abs(speed).min(axis=0) > 0.05
    rates = np.gradient(speed, 1e-3, axis=1)
    friction = np.array([[110.0], [140.0]]) * speed + np.array([[25.0], [32.0]]) * np.sign(speed)
    needed = masses @ rates + friction
    errors = [
        [np.std((np.roll(log[name], k) - force)[moving]) for k in range(5)]
        for name, force in zip(("F1", "F2"), needed, strict=True)
    ]
    # A held force acts half a sample late besides, so that two samples are nearest for one, none or one for the other.
    assert int(np.argmin(errors[0])) in (0, 1)
    assert int(np.argmin(errors[1])) in (2, 3)
    assert declared_delays(late) == {"F2": -2e-3}


def test_a_drive_that_the_axis_lacks_is_refused() -> None:
    with pytest.raises(DeclarationError, match="drive='F3' is not a drive: choose from F1, F2"):
        gantry().with_effect(ActuatorDelay(2e-3, drive="F3"))


def test_the_hold_of_two_drives_is_recognised() -> None:
    found = diagnose(gantry(held=False), logged(gantry()))
    assert found.verdict == "no_gap", found.sentence
    assert [fault.split(" is held")[0] for fault in found.faults] == ["F1", "F2"]


def test_delays_of_both_drives_are_two_and_written_with_their_drives() -> None:
    machine = gantry().with_effect(ActuatorDelay(0.8e-3, drive="F1"), ActuatorDelay(1.6e-3, drive="F2"))
    found = diagnose(gantry(), logged(machine), library=LIBRARY_OF_DRIVES)
    times = {effect.at: effect.parameters["T"].value for effect in found.effects if effect.effect == "delay"}
    assert times == pytest.approx({"F1": 0.8e-3, "F2": 1.6e-3}, abs=2e-5)
    assert len(found.effects) == 2
    written = axis_source(explained_axis(found).axis)
    assert 'drive="F1")' in written
    assert 'drive="F2")' in written


def test_a_limit_of_one_drive() -> None:
    machine = gantry().with_effect(ForceLimit(400.0, drive="F2"))
    found = diagnose(gantry(), logged(machine), library=LIBRARY_OF_DRIVES)
    assert [(effect.effect, effect.at) for effect in found.effects] == [("saturation", "F2")]
    assert found.effects[0].parameters["limit"].value == pytest.approx(400.0, rel=0.02)
