"""A drive that acts late moves a load that swings on freely: its rope's force is recorded late, too."""

import pytest

from symid import (
    ActuatorDelay,
    Axis,
    Between,
    Body,
    CoulombFriction,
    Drive,
    Position,
    Spring,
    ViscousFriction,
)
from symid.diagnosis import diagnose
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade

VALUES = {"Jd": 2.5, "Mh": 400.0, "b": 3.0, "c": 12.0, "Kr": 3000.0, "Dr": 60.0}


def test_a_late_drive_of_a_swinging_load_is_the_only_effect() -> None:
    """Motion from the unknown state after each rest was not late: 3.79 ms and a periodic disturbance were found."""
    drum, hook = Body("drum", inertia="Jd"), Body("hook", mass="Mh")
    rope = Spring("rope", Between(first=drum, second=hook, ratio=0.15), stiffness="Kr", damping="Dr")
    elements = (drum, hook, ViscousFriction(drum, "b"), CoulombFriction(drum, "c"), rope)
    sensors = Position("q", drum, noise=1e-7), Position("z", hook, noise=1e-7)
    axis = Axis("hoist", elements, Drive("T", drum, noise=0.02, held=True), sensors)
    late = axis.with_effect(ActuatorDelay(4e-3))
    path = trapezoids([20.0], [6.0, 3.0], acceleration=6.0, jerk=60.0, dwell=0.2, sampling_period=2e-3)
    run = simulate(late, VALUES, path, tuned_cascade(plant_of(late, VALUES), "q", 3.0), start="equilibrium")
    found = diagnose(axis, run.log)
    assert [effect.effect for effect in found.effects] == ["delay"]
    assert found.effects[0].parameters["T"].value == pytest.approx(4e-3, rel=2e-3)
    assert found.gap.explained.rms < 1.1 * found.gap.noise_floor.rms
