"""Curves of a tuning: the error against cutoff and sampling frequency."""

from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes

from symid.report.figures.colours import LIGHT, Palette
from symid.report.figures.drawn import Drawn, label_log_scales
from symid.tuning import BoundSearch, TotalTuning, Tuning

_CIRCLE: Any = {"fillstyle": "none", "markersize": 9}


def plot_tuning(tuning: Tuning, palette: Palette = LIGHT, *, narrow: bool = False) -> Drawn:
    """Largest error against the cutoff and against the sampling frequency, side by side, or below each other."""
    with mpl.rc_context(palette.style):
        figure = Drawn(figsize=(4.2, 8) if narrow else (10, 4), layout="constrained")
        left, right = figure.subplots(*((2, 1) if narrow else (1, 2)))
        _draw(
            left, tuning.cutoff, "cutoff frequency [Hz]", "low-pass filter, exact derivatives [35]", palette
        )
        title = f"central differences of {', '.join(tuning.measured)} [37]"
        _draw(right, tuning.sampling, "sampling frequency [Hz]", title, palette)
        look: Any = {"color": palette.residual, "linestyle": ":", "linewidth": 1}
        right.axvline(tuning.first_sampling_hz, label="first guess [36]", **look)
        left.set_ylabel("largest error of a parameter [%]")
        for axes in (left, right):
            axes.legend(loc="lower left", frameon=True, edgecolor="none", framealpha=0.9)
            label_log_scales(axes)
    return figure


def _draw(axes: Axes, search: BoundSearch, label: str, title: str, palette: Palette) -> None:
    look = {"color": palette.other, "linewidth": 1, "label": "error"}
    axes.loglog(search.scanned_hz, search.scanned_errors, ".-", **look)
    axes.axhline(search.bound, color=palette.model, linewidth=1, label=f"bound {search.bound:g} %")
    tuned, circle = search.frequency_hz, {**_CIRCLE, "color": palette.model}
    axes.loglog(tuned, search.largest_error, "o", label=f"tuned {tuned:.4g} Hz", **circle)
    axes.set_xlabel(label)
    axes.set_title(title, loc="left")


def plot_total_tuning(tuning: TotalTuning, palette: Palette = LIGHT, *, narrow: bool = False) -> Drawn:
    """Total error against the cutoff."""
    with mpl.rc_context(palette.style):
        figure = Drawn(figsize=(4.2 if narrow else 6, 4), layout="constrained")
        axes = figure.subplots()
        label = "scan, best decimation"
        axes.loglog(tuning.cutoffs_hz, tuning.totals, ".-", color=palette.other, linewidth=1, label=label)
        tuned, decimation = tuning.preparation.cutoff_hz, tuning.preparation.decimation
        label = f"tuned {tuned:.4g} Hz, decimation {decimation}"
        axes.loglog(tuned, tuning.total_percent, "o", color=palette.model, label=label, **_CIRCLE)
        axes.set_xlabel("cutoff frequency [Hz]")
        axes.set_ylabel("total error, rms over parameters [%]")
        axes.legend(loc="best", frameon=True, edgecolor="none", framealpha=0.9)
        label_log_scales(axes)
    return figure
