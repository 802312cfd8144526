"""Ticks of logarithmic scales as plain numbers, few enough that they stand apart."""

from __future__ import annotations

import math

from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

_WIDE = 2.0
"""Decades from which on only powers of ten are labelled."""
_MOST_TICKS = 7


def label_log_scales(axes: Axes) -> None:
    """Label each logarithmic scale of a finished diagram by plain numbers; matplotlib's own are formulas."""
    for axis in (axes.xaxis, axes.yaxis):
        if axis.get_scale() != "log":
            continue
        low, high = sorted(axis.get_view_interval())
        between = (1.0,) if math.log10(high / low) >= _WIDE else (1.0, 2.0, 5.0)
        axis.set_major_locator(LogLocator(subs=between, numticks=_MOST_TICKS))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())
