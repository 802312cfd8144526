"""A force that switches between two levels has power at all frequencies, which looks like noise of its record."""

import numpy as np
import pytest

from symid import Axis, Drive, Position, ViscousFriction
from symid.axis import Body
from symid.diagnosis import diagnose

J, FV, FC, PERIOD, STEPS = 0.02, 0.02, 0.08, 1e-3, 10


def binary_run(seconds: float) -> dict[str, np.ndarray]:
    """A rotor under a held torque of -1 or 1 N*m that changes at random every 50 ms, read by an encoder of counts."""
    random = np.random.default_rng(3)
    levels = np.repeat(2.0 * random.integers(0, 2, 400) - 1.0, 50)[: round(seconds / PERIOD)]
    q, w, positions = 0.0, 0.0, np.zeros(levels.size)
    for k, torque in enumerate(levels):
        positions[k] = q
        for _ in range(STEPS):
            faster = w + PERIOD / STEPS * (torque - FV * w - FC * np.sign(w)) / J
            q, w = q + PERIOD / STEPS * (w + faster) / 2, faster
    count = 2 * np.pi / 20_000
    noisy = levels + 0.005 * random.standard_normal(levels.size)
    return {"t": PERIOD * np.arange(levels.size), "q": count * np.round(positions / count), "F": noisy}


def test_friction_is_found_below_the_level_that_looks_like_noise() -> None:
    rotor = Body("rotor", inertia="J")
    axis = Axis("rotor", (rotor, ViscousFriction(rotor, "Fv")), Drive("F", rotor), (Position("q", rotor),))
    found = diagnose(axis, binary_run(8.0))
    (effect,) = found.effects
    assert effect.effect == "coulomb_friction"
    (level,) = effect.parameters.values()
    assert level.value == pytest.approx(FC, rel=0.1)
    assert found.gap.explained.rms < found.gap.noise_floor.rms < found.gap.reidentified.rms
