"""A law that the library lacks takes no name of the library with confidence."""

from collections.abc import Callable

import numpy as np
import pytest

from symid import load_axis
from symid.arrays import FloatArray
from symid.data import Log
from symid.diagnosis import diagnose
from symid.diagnosis.selection.evidence import Errors, _chance_of_another_law
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade

RIGID = load_axis("rigid_1m")
VALUES = {"M": 100.0, "Fv": 120.0, "Fs": 30.0}
PERIOD = 1e-3


def log_with(
    force_of: Callable[[FloatArray, FloatArray], FloatArray], seed: int, period: float = PERIOD
) -> Log:
    """A slide whose drive needs a force of velocity and acceleration more, which no effect of the library does."""
    speeds = [0.3, 0.7, 1.0] if seed % 2 else [0.4, 0.6, 0.9]
    reference = trapezoids(0.4, speeds, acceleration=5.0, jerk=100.0, dwell=0.1, sampling_period=period)
    run = simulate(RIGID, VALUES, reference, tuned_cascade(plant_of(RIGID, VALUES), "q"), seed=seed).log
    velocity = np.gradient(run["q"], period)
    noise = np.random.default_rng(seed).standard_normal((2, velocity.size))
    force = run["F"] + force_of(velocity, np.gradient(velocity, period)) + 0.3 * noise[0]
    return Log.from_arrays({"q": run["q"] + 1e-7 * noise[1], "F": force}, sampling_period=period)


def test_no_effect_is_named_for_a_law_of_another_shape_with_confidence() -> None:
    logs = [log_with(lambda v, a: 4.0 * a * np.abs(a), seed, 2 * PERIOD) for seed in (1, 2)]
    found = diagnose(RIGID, logs[0], validation=logs[1], nominal=VALUES, held=True)
    assert found.verdict == "partly"
    assert all(effect.probability < 0.15 for effect in found.effects)
    assert found.probabilities["unexplained"] > 0.8
    assert found.effects[0].outdone_by == "acceleration"


@pytest.mark.parametrize(("power", "certain"), [(1.5, False), (2.0, True)])
def test_drag_is_certain_only_with_the_square_of_the_speed(power: float, certain: bool) -> None:
    logs = [log_with(lambda v, a: 300.0 * np.sign(v) * np.abs(v) ** power, seed) for seed in (1, 2)]
    first, *others = diagnose(RIGID, logs[0], validation=logs[1], nominal=VALUES, held=True).effects
    assert first.effect == "quadratic_drag"
    assert first.outdone_by == ("" if certain else "velocity")
    assert (first.probability > 0.9) == certain
    assert all(effect.probability < 0.5 for effect in others)  # what makes up for the shape is as doubtful


def test_a_constant_force_stays_certain_beside_a_law_that_the_library_lacks() -> None:
    logs = [log_with(lambda v, a: 30.0 + 10.0 * np.tanh(v / 0.15), seed) for seed in (1, 2)]
    first = diagnose(RIGID, logs[0], validation=logs[1], nominal=VALUES, held=True).effects[0]
    assert (first.effect, first.outdone_by) == ("offset_force", "")
    assert first.probability > 0.5
    assert first.parameters["F0"].value == pytest.approx(30.0, rel=0.02)


@pytest.mark.parametrize("share", [0.0, 0.3])
def test_the_probability_of_an_effect_falls_with_what_another_shape_leaves(share: float) -> None:
    assert 0.8 < _chance_of_another_law(Errors(None, 50.0, 10.0, 0.1, nonparametric=share)) <= 0.85
    assert _chance_of_another_law(Errors(None, 50.0, 10.0, 0.1, nonparametric=1.0)) < 0.05
