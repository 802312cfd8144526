"""One output of one log: measured and predicted, and the residual over time, velocity, position and frequency."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy
from matplotlib.axes import Axes

from symid.arrays import BoolArray, FloatArray
from symid.data.sensor_motion import SensorMotion
from symid.estimation.residual_measures import means_over
from symid.report.figures.colours import Palette
from symid.report.figures.scales import seen_range

_MOST_POINTS = 20_000


@dataclass(frozen=True, eq=False)
class Panel:
    """Curves of one output of one log, of shape (n,); nan where nothing is compared."""

    title: str
    output: str
    unit: str
    time: FloatArray
    measured: FloatArray
    predicted: FloatArray
    motion: SensorMotion | None = None


def draw_panel(place: Any, panel: Panel, palette: Palette, *, narrow: bool = False) -> None:
    """Draw a panel into a subfigure, in two columns of diagrams, or in one."""
    if narrow:
        rows = 4 if panel.motion is None else 6
        one = place.subplots(rows, 1, height_ratios=(1.5, 1, 1.1, 2, 1.5, 1.5)[:rows])
        top, below, spectrum, against, *maps = one
    else:
        two = place.subplots(3, 2, width_ratios=(2.1, 1), height_ratios=(1.7, 1, 1.1))
        (top, against), (below, _), (spectrum, _) = two
        maps = two[1:, 1]
    below.sharex(top)
    error, used = panel.measured - panel.predicted, np.isfinite(panel.measured)
    wide, thin = (panel.measured, palette.measured, 3.0), (panel.predicted, palette.model, 0.9)
    draw_over_time(top, panel.time, {"measured": wide, "predicted": thin}, f"{panel.output} [{panel.unit}]")
    top.set_title(panel.title, loc="left")
    top.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, frameon=False)
    top.tick_params(labelbottom=False)
    residual = {"residual": (error, palette.residual, 0.7)}
    draw_over_time(below, panel.time, residual, f"residual [{panel.unit}]")
    below.axhline(0.0, color=palette.ink, linewidth=0.6)
    below.set_xlabel("time [s]")
    _against(against, panel.measured[used], panel.predicted[used], panel, palette)
    _densities(spectrum, panel, error, palette)
    if panel.motion is None:
        for axes in maps:
            axes.axis("off")
        return
    by_velocity, by_position = maps
    position, velocity = panel.motion.at(panel.time[used])
    _map(by_velocity, velocity, error[used], {"mean": np.isfinite(velocity)}, panel, palette)
    by_velocity.set_xlabel(f"velocity of {panel.motion.signal} [{panel.motion.unit}/s]")
    ways = {"forward": velocity > 0, "backward": velocity < 0}
    _map(by_position, position, error[used], ways, panel, palette)
    by_position.legend(loc="lower right", bbox_to_anchor=(1.0, 0.96), ncols=2, frameon=False)
    by_position.set_xlabel(f"position {panel.motion.signal} [{panel.motion.unit}]")


def draw_over_time(
    axes: Axes, time: FloatArray, curves: dict[str, tuple[FloatArray, str, float]], label: str
) -> None:
    """Curves over time; of long logs the envelope of each bundle of samples, so that no peak is lost."""
    for name, (values, colour, width) in curves.items():
        bundle = -(-values.size // _MOST_POINTS)
        if bundle == 1:
            axes.plot(time, values, color=colour, linewidth=width, label=name)
            continue
        whole = values.size // bundle * bundle
        parts = values[:whole].reshape(-1, bundle)
        low, high = np.fmin.reduce(parts, axis=1), np.fmax.reduce(parts, axis=1)
        axes.fill_between(time[:whole:bundle], low, high, color=colour, alpha=0.8, linewidth=0.4, label=name)
    axes.set_ylabel(label)
    axes.margins(x=0.01)


def _against(axes: Axes, measured: FloatArray, predicted: FloatArray, panel: Panel, palette: Palette) -> None:
    """Predicted against measured output; a perfect model lies on the line."""
    _dots(axes, measured, predicted, palette)
    ends = [float(np.min(measured)), float(np.max(measured))]
    axes.plot(ends, ends, color=palette.model, linewidth=1.0, label="equal")
    axes.set_xlabel(f"measured {panel.output} [{panel.unit}]")
    axes.set_ylabel(f"predicted [{panel.unit}]")


def _map(
    axes: Axes, x: FloatArray, error: FloatArray, parts: dict[str, BoolArray], panel: Panel, palette: Palette
) -> None:
    """Residual over a signal, with the means of some parts of it in bins, and twice the deviation of each mean."""
    _dots(axes, x, error, palette)
    found = [means_over(x[part], error[part]) for part in parts.values()]
    looks = ((palette.model, "o", "-"), (palette.other, "^", "--"))
    for name, means, (colour, mark, style) in zip(parts, found, looks, strict=False):
        line: Any = {"color": colour, "marker": mark, "linestyle": style, "markersize": 3, "linewidth": 1.2}
        axes.errorbar(means.places, means.values, means.doubt, elinewidth=0.8, label=name, **line)
    axes.axhline(0.0, color=palette.ink, linewidth=0.6)
    axes.set_ylim(*seen_range(error, *found))
    axes.set_ylabel(f"residual [{panel.unit}]")


def _dots(axes: Axes, x: FloatArray, y: FloatArray, palette: Palette) -> None:
    step = -(-x.size // _MOST_POINTS)
    axes.plot(x[::step], y[::step], ".", color=palette.measured, markersize=2, alpha=0.6, rasterized=True)


def _densities(axes: Axes, panel: Panel, error: FloatArray, palette: Palette) -> None:
    """Amplitude densities of output and residual; rows that were left out count as zero."""
    rate = 1.0 / (panel.time[1] - panel.time[0])
    curves = (
        (panel.measured, palette.measured, 2.2, "-", "measured"),
        (error, palette.residual, 1.0, "--", "residual"),
    )
    for values, colour, width, style, name in curves:
        frequency, power = scipy.signal.welch(np.nan_to_num(values), fs=rate, nperseg=min(1024, values.size))
        look = {"color": colour, "linewidth": width, "linestyle": style, "label": name}
        axes.loglog(frequency[1:], np.sqrt(power[1:]), **look)
    axes.set_xlabel("frequency [Hz]")
    axes.set_ylabel(f"{panel.output} [{panel.unit}/√Hz]")
    axes.legend(loc="lower left", frameon=True, edgecolor="none", framealpha=0.85)
