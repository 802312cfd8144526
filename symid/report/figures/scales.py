"""Scales of diagrams: the range of a residual, and the ticks of logarithmic scales."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from symid.arrays import FloatArray
from symid.estimation.residual_measures import Means

_SEEN = (0.5, 99.5)
_ROOM = 0.15
"""Percentiles of the residual within the plot, and the margin around them."""
_WIDE = 2.0
"""Decades from which on only powers of ten are labelled."""
_MOST_TICKS = 7


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


def label_log_scales(axes: Axes) -> None:
    """Label each logarithmic scale of a finished diagram by plain numbers, few enough that they stand apart."""
    for axis in (axes.xaxis, axes.yaxis):
        if axis.get_scale() != "log":
            continue
        low, high = sorted(axis.get_view_interval())
        between = (1.0,) if math.log10(high / low) >= _WIDE else (1.0, 2.0, 5.0)
        axis.set_major_locator(LogLocator(subs=between, numticks=_MOST_TICKS))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())
