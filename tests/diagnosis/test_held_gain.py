"""A gain that bends, and a limit, on a force that is held from sample to sample: both act when the force does."""

from collections.abc import Callable

import numpy as np
import pytest

from symid import Axis, Body, Diagnosis, Drive, Log, Position, ViscousFriction, diagnose

RATE, MASS, VISCOUS, NOISE = 2000.0, 20.0, 40.0, 0.5
SLIDE = Body("slide", mass="M")
AXIS = Axis(
    "slide", (SLIDE, ViscousFriction(SLIDE, "Fv")), Drive("F", SLIDE, held=True), (Position("q", SLIDE),)
)
BEND, LIMIT = 6e-4, 250.0


def run(acting: Callable[[np.ndarray], np.ndarray], seed: int) -> Log:
    """A run under a held force, by the exact solution over a sample."""
    t, draw = np.arange(10000) / RATE, np.random.default_rng(seed)
    hertz = np.linspace(0.4, 60.0, 40)
    phases = draw.uniform(0, 2 * np.pi, hertz.size)
    force = 45.0 * np.sin(2 * np.pi * np.multiply.outer(t, hertz) + phases).sum(axis=1)
    ended, decay = MASS / VISCOUS, np.exp(-VISCOUS / MASS / RATE)
    q, v, read = 0.0, 0.0, np.empty(t.size)
    for k, f in enumerate(acting(force) / VISCOUS):
        read[k] = q
        q, v = q + f / RATE + (v - f) * ended * (1 - decay), f + (v - f) * decay
    noisy = {
        "q": read + 2e-7 * draw.standard_normal(t.size),
        "F": force + NOISE * draw.standard_normal(t.size),
    }
    return Log(f"held, {seed}", 0.0, 1 / RATE, noisy)


def found(acting: Callable[[np.ndarray], np.ndarray]) -> Diagnosis:
    """The diagnosis of what acts in place of the force."""
    off = {"M": 1.1 * MASS, "Fv": 0.9 * VISCOUS}
    return diagnose(AXIS, run(acting, 1), validation=run(acting, 2), nominal=off)


@pytest.mark.parametrize(
    ("acting", "effect", "value", "true"),
    [
        (lambda f: f - BEND * f * np.abs(f), "gain_nonlinearity", "bend", BEND),
        (lambda f: np.clip(f, -LIMIT, LIMIT), "saturation", "limit", LIMIT),
    ],
)
def test_what_a_drive_makes_of_a_held_force_leaves_noise_only(
    acting: Callable[[np.ndarray], np.ndarray], effect: str, value: str, true: float
) -> None:
    named = found(acting)
    assert [e.effect for e in named.effects] == [effect], named.sentence
    assert named.effects[0].parameters[value].value == pytest.approx(true, rel=3e-3)
    assert named.gap.explained.rms < 1.3 * NOISE
    assert named.parameters[0].explained == pytest.approx(MASS, rel=2e-3)
