"""The range of a plot of a residual."""

from __future__ import annotations

import numpy as np

from symid.arrays import FloatArray
from symid.estimation.residual_measures import Means

_SEEN = (0.5, 99.5)
_ROOM = 0.15
"""Percentiles of the residual within the plot, and the margin around them."""


def seen_range(residual: FloatArray, *means: Means) -> tuple[float, float]:
    """Range of a residual without its rarest values, which contains all means.

    >>> low, high = seen_range(np.array([-1.0, 1.0]), Means(np.zeros(1), np.array([4.0]), np.zeros(1)))
    >>> round(low, 3), round(high, 3)
    (-1.287, 4.297)
    """
    low, high = np.percentile(residual, _SEEN) if residual.size else (-1.0, 1.0)
    room = _ROOM * (high - low)
    ends = np.concatenate([[low, high], *(one.values for one in means)])
    return float(ends.min() - room), float(ends.max() + room)
