"""A constant delay and a clock that drifts, on the default trajectory, which is fast at first."""

import numpy as np
import pytest

from symid import Log, identify
from symid.axis import load_axis
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade

PERIOD = 5e-4


@pytest.fixture(scope="module")
def fast_at_first() -> Log:
    """The default trajectory of `symid simulate`, at a quarter of its rate."""
    axis, values = load_axis("rigid_1m"), {"M": 109.0, "Fv": 230.0, "Fs": 23.0}
    path = trapezoids(
        [0.2], [0.5, 0.25, 0.1], acceleration=5.0, jerk=500.0, dwell=0.2, sampling_period=PERIOD
    )
    return simulate(axis, values, path, tuned_cascade(plant_of(axis, values), "q")).log


@pytest.mark.parametrize(("late", "drift", "words"), [(0, 0, ""), (4, 0, "recorded"), (0, 2, "drifts by")])
def test_a_constant_delay_is_no_drift(fast_at_first: Log, late: float, drift: float, words: str) -> None:
    t = np.arange(fast_at_first.n_samples)
    F = np.interp(t - late - drift * t / t.size, t, fast_at_first["F"])
    found = identify(
        load_axis("rigid_1m"), Log.from_arrays({"q": fast_at_first["q"], "F": F}, sampling_period=PERIOD)
    )
    assert found.status == ("timing" if words else "ok"), found.message
    assert words in found.message
    assert ("drifts by" in found.message) == (drift > 0)
