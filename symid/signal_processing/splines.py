"""Quintic spline of even samples."""

import math

import numpy as np

from symid.arrays import FloatArray
from symid.signal_processing.zero_phase import ZeroPhaseFilter

_BEYOND = 32
"""Samples by which a signal is continued at its ends: there a spline has forgotten them to 1e-11."""
_REACH = 2
"""The value between samples i and i + 1 depends on the coefficients i - 2 to i + 3: this is the 2."""


_SLOW_ROOT, _FAST_ROOT = -0.4305753470999737915, -0.0430962882032646536
"""Roots of the samples of the cardinal spline, z^4 + 26 z^3 + 66 z^2 + 26 z + 1, within the unit circle."""
_INVERSE_SECTION = [
    (1 - _SLOW_ROOT) * (1 - _FAST_ROOT),
    0.0,
    0.0,
    1.0,
    -_SLOW_ROOT - _FAST_ROOT,
    _SLOW_ROOT * _FAST_ROOT,
]
_INVERSE = ZeroPhaseFilter(np.array([_INVERSE_SECTION]), padding=1)


class QuinticSpline:
    """The spline of fifth order through the samples of a signal that stays constant beyond its ends.

    Its coefficients are found once; a shift then costs six products a sample.

    Parameters
    ----------
    values : array of shape (n_samples,)
        The signal.

    Examples
    --------
    >>> t = np.arange(100.0)
    >>> moved = QuinticSpline(np.sin(t / 5)).earlier(0.25)
    >>> bool(np.allclose(moved[10:-10], np.sin((t + 0.25) / 5)[10:-10], atol=1e-6))
    True
    """

    def __init__(self, values: FloatArray) -> None:
        self.values = values
        continued = np.pad(values, _BEYOND, mode="edge")
        self._coefficients = _INVERSE.apply(continued)

    @staticmethod
    def reach(samples: float) -> int:
        """Samples on either side that influence a value shifted by the given number of samples, to rounding."""
        return 2 * _BEYOND + math.ceil(abs(samples)) + _REACH + 1

    def earlier(self, samples: float, kept: slice = slice(None)) -> FloatArray:
        """Samples of the signal moved to an earlier time by any number of them; negative: to a later one."""
        whole = math.floor(samples)
        weights = _b_spline(samples - whole - np.arange(-_REACH, _REACH + 2.0))
        margin = max(abs(whole) + _REACH + 1 - _BEYOND, 0)
        known = np.pad(self._coefficients, margin, mode="edge") if margin else self._coefficients
        first = _BEYOND + margin + whole - _REACH
        near = known[first : first + self.values.size + weights.size - 1]
        if kept == slice(None):
            return np.correlate(near, weights, mode="valid")
        return np.asarray(np.lib.stride_tricks.sliding_window_view(near, weights.size)[kept] @ weights)

    def mean_earlier(self, samples: float, over: float) -> FloatArray:
        """Mean of the signal over a time around the one by which it is moved, such as that for which a force is held.

        Two values at +-`over`/sqrt(12), by Gauss, are exact for a cubic.
        """
        if not over:
            return self.earlier(samples)
        apart = over / math.sqrt(12)
        return (self.earlier(samples - apart) + self.earlier(samples + apart)) / 2


def _b_spline(x: FloatArray) -> FloatArray:
    """Cardinal B-spline of fifth order, as a sum of truncated powers; 0 beyond 3 on either side."""
    knots = np.arange(7)
    signs = np.array([(-1) ** k * math.comb(6, k) for k in range(7)]) / math.factorial(5)
    return np.asarray(np.maximum(x[:, None] + 3.0 - knots, 0.0) ** 5 @ signs)
