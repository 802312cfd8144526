"""A bare motor that swings to and fro once or twice: few laws, and no mode, show in so short a motion."""

from dataclasses import replace

import numpy as np
import pytest

from symid import Axis, Body, Drive, Log, Position, ViscousFriction, diagnose

INERTIA, VISCOUS, COULOMB, HERTZ = 1.9e-4, 1e-4, 0.08, 2.0
ROTOR = Body("rotor", inertia="J")
AXIS = Axis("motor", (ROTOR,), Drive("i", ROTOR, unit="A"), (Position("q", ROTOR),))


def swing(seconds: float, begin: float, builds_up: float) -> Log:
    """A sine, by a noisy encoder; its friction builds up over a speed."""
    rng, phase = np.random.default_rng(1), 2 * np.pi * HERTZ * np.arange(0.0, seconds, 2e-3) + np.pi + begin
    q, omega = 12 * np.sin(phase), 2 * np.pi * HERTZ
    v, a = 12 * omega * np.cos(phase), -(omega**2) * q
    friction = VISCOUS * v + COULOMB * np.tanh(v / builds_up)
    current = INERTIA * a + friction + 0.012 * rng.standard_normal(q.size)
    signals = {"q": q + 0.02 * rng.standard_normal(q.size), "i": current}
    return replace(Log.from_arrays(signals, sampling_period=2e-3), notes=("resampled to 500 Hz",))


def test_friction_is_found_and_no_mode_of_the_rotor() -> None:
    found = diagnose(AXIS, swing(0.586, 0.35, builds_up=8.0))
    assert [effect.effect for effect in found.effects] == ["coulomb_friction"]
    assert found.effects[0].parameters["Fs"].value == pytest.approx(COULOMB, rel=0.15)
    assert "resampled to 500 Hz" in found.assumptions


def test_a_cause_that_the_motion_contradicts_gives_way_to_another() -> None:
    viscous = replace(AXIS, elements=(ROTOR, ViscousFriction(ROTOR, "Fv")))
    found = diagnose(viscous, swing(0.9, 0.0, builds_up=0.1))
    assert [effect.effect for effect in found.effects] == ["coulomb_friction"]
    assert found.effects[0].parameters["Fs"].value == pytest.approx(COULOMB, rel=0.15)
    assert any(text.startswith("Rejected: flexible mode at rotor") for text in found.assumptions)
