"""Signals moved by parts of a sample: against scipy's shift, and constant beyond their ends."""

import numpy as np
import pytest
from scipy.ndimage import shift

from symid.signal_processing import QuinticSpline


@pytest.mark.parametrize("samples", [0.0, 0.3, -0.3, 1.0, 7.75, -60.5, 150.25])
def test_a_moved_signal_is_that_of_scipy_away_from_its_ends(samples: float) -> None:
    x = np.cumsum(np.random.default_rng(5).standard_normal(1000))
    inner = slice(200, -200)
    expected = shift(x, -samples, order=5, mode="nearest")[inner]
    assert QuinticSpline(x).earlier(samples)[inner] == pytest.approx(expected, abs=1e-11)


def test_a_signal_stays_constant_beyond_its_ends() -> None:
    x = np.arange(50.0)
    assert QuinticSpline(x).earlier(100.0) == pytest.approx(np.full(50, 49.0), abs=1e-9)
    assert QuinticSpline(x).earlier(-100.5) == pytest.approx(np.zeros(50), abs=1e-9)
