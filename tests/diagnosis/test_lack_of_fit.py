"""A law that the library lacks takes no name of the library with confidence."""

import numpy as np
import pytest

from symid import load_axis
from symid.data import Log
from symid.diagnosis import diagnose
from symid.diagnosis.selection.evidence import Errors, _is_outdone
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade

RIGID = load_axis("rigid_1m")
VALUES = {"M": 100.0, "Fv": 120.0, "Fs": 30.0}
PERIOD = 1e-3


def log_with_a_force_of_the_acceleration(seed: int) -> Log:
    """A slide whose drive needs 4 N s^4/m^2 times a |a| more, which no effect of the library does."""
    speeds = [0.3, 0.7, 1.0] if seed % 2 else [0.4, 0.6, 0.9]
    reference = trapezoids(0.4, speeds, acceleration=5.0, jerk=100.0, dwell=0.1, sampling_period=PERIOD)
    run = simulate(RIGID, VALUES, reference, tuned_cascade(plant_of(RIGID, VALUES), "q"), seed=seed).log
    acceleration = np.gradient(np.gradient(run["q"], PERIOD), PERIOD)
    noise = np.random.default_rng(seed).standard_normal((2, acceleration.size))
    force = run["F"] + 4.0 * acceleration * np.abs(acceleration) + 0.3 * noise[0]
    return Log.from_arrays({"q": run["q"] + 1e-7 * noise[1], "F": force}, sampling_period=PERIOD)


def test_no_effect_is_named_for_a_law_of_another_shape_with_confidence() -> None:
    logs = [log_with_a_force_of_the_acceleration(seed) for seed in (1, 2)]
    found = diagnose(RIGID, logs[0], validation=logs[1], nominal=VALUES, held=True)
    assert found.verdict == "unexplained"
    assert all(effect.probability < 0.1 for effect in found.effects)
    assert found.probabilities["unexplained"] > 0.5
    assert "nothing in the library explains" in found.sentence


@pytest.mark.parametrize("share", [0.0, 0.3])
def test_the_probability_of_an_effect_falls_with_what_another_shape_leaves(share: float) -> None:
    assert 0.8 < _is_outdone(Errors(None, 50.0, 10.0, 0.1, nonparametric=share)) <= 0.85
    assert _is_outdone(Errors(None, 50.0, 10.0, 0.1, nonparametric=1.0)) < 0.05
