"""One output of one log: measured and predicted, and the residual over time, velocity, position and frequency; Bode."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy
from matplotlib.axes import Axes

from symid.arrays import BoolArray, FloatArray
from symid.axis import Axis
from symid.data import Log
from symid.report.figures.binned_means import means_over
from symid.report.figures.colours import Palette
from symid.report.figures.drawn import seen_range, title_lines
from symid.report.figures.envelope import envelope, envelope_places
from symid.simulation.plants import COHERENT, FrequencyResponse, ResponseBand, degrees_of

_SMOOTHED_HZ = 50.0


@dataclass(frozen=True, eq=False)
class SensorMotion:
    """Position and velocity of the first position sensor, SI; the velocity is smoothed below 50 Hz."""

    signal: str
    unit: str
    time: FloatArray
    position: FloatArray
    velocity: FloatArray

    @classmethod
    def of(cls, axis: Axis, log: Log) -> SensorMotion | None:
        """Motion in a log; None without a position."""
        signals = [s.signal for s in axis.sensors if s.derivative == 0 and s.signal in log.signals]
        if not signals:
            return None
        position, period = np.asarray(log[signals[0]]), log.sampling_period
        velocity = np.gradient(position, period)
        if 0.4 / period > _SMOOTHED_HZ and position.size > 100:
            sections = scipy.signal.butter(2, _SMOOTHED_HZ, fs=1 / period, output="sos")
            velocity = scipy.signal.sosfiltfilt(sections, velocity)
        return cls(signals[0], str(axis.signal_units[signals[0]]), log.time, position, velocity)

    def at(self, time: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Position and velocity at other times."""
        return np.interp(time, self.time, self.position), np.interp(time, self.time, self.velocity)


_MOST_POINTS, _MOST_ON_PAGE = 20_000, 1_500
"""Points of a curve and dots of a map, which is a picture; points of a curve on a page: two for a column of pixels."""


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
        rows_of_axes = place.subplots(rows, 1, height_ratios=(1.5, 1, 1.1, 2, 1.5, 1.5)[:rows])
        top, below, spectrum, against, *maps = rows_of_axes
    else:
        two = place.subplots(3, 2, width_ratios=(2.1, 1), height_ratios=(1.7, 1, 1.1))
        (top, against), (below, _), (spectrum, _) = two
        maps = two[1:, 1]
    below.sharex(top)
    error, used = panel.measured - panel.predicted, np.isfinite(panel.measured)
    wide, thin = (panel.measured, palette.measured, 3.0), (panel.predicted, palette.model, 0.9)
    both = {"measured": wide, "predicted": thin}
    draw_over_time(top, panel.time, both, f"{panel.output} [{panel.unit}]", _MOST_ON_PAGE)
    top.set_title(title_lines(panel.title, narrow=narrow), loc="left", pad=22)
    top.legend(loc="lower left", bbox_to_anchor=(-0.02, 0.98), ncols=2, frameon=False)
    top.tick_params(labelbottom=False)
    residual = {"residual": (error, palette.residual, 0.7)}
    draw_over_time(below, panel.time, residual, f"residual [{panel.unit}]", _MOST_ON_PAGE)
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
    axes: Axes,
    time: FloatArray,
    curves: dict[str, tuple[FloatArray, str, float]],
    label: str,
    most: int = _MOST_POINTS,
) -> None:
    """Curves over time, long ones as their envelopes."""
    places = envelope_places(time, most)
    for name, (values, colour, width) in curves.items():
        axes.plot(places, envelope(values, most), color=colour, linewidth=width, label=name)
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
    curves = [means_over(x[part], error[part]) for part in parts.values()]
    looks = ((palette.model, "o", "-"), (palette.other, "^", "--"))
    for name, means, (colour, mark, style) in zip(parts, curves, looks, strict=False):
        line: Any = {"color": colour, "marker": mark, "linestyle": style, "markersize": 3, "linewidth": 1.2}
        axes.errorbar(means.places, means.values, means.doubt, elinewidth=0.8, label=name, **line)
    axes.axhline(0.0, color=palette.ink, linewidth=0.6)
    axes.set_ylim(*seen_range(error, *curves))
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


def draw_bode(place: Any, response: FrequencyResponse, palette: Palette, band: ResponseBand) -> None:
    """Magnitude, phase and coherence below each other, in a subfigure."""
    magnitude, phase, coherence = place.subplots(3, 1, sharex=True, height_ratios=(2.2, 1.2, 0.8))
    sure, f = response.is_coherent, response.frequency
    curves: tuple[tuple[Axes, Any], ...] = ((magnitude, np.abs), (phase, degrees_of))
    for axes, of in curves:
        doubtful = (~sure, 1.5, 0.4, f"coherence below {COHERENT}")
        for some, size, alpha, label in (doubtful, (sure, 3.4, 1.0, "measured (H1)")):
            look: Any = {"color": palette.measured, "markersize": size, "alpha": alpha, "label": label}
            axes.plot(f[some], of(response.measured)[some], "o", rasterized=True, **look)
        axes.plot(f, of(response.identified), color=palette.model, linewidth=1.3, label="identified")
    look = {"color": palette.model, "alpha": 0.25, "linewidth": 0, "label": "95 % of the identified"}
    magnitude.fill_between(band.frequency, band.lowest, band.highest, **look)
    turned = np.interp(band.frequency, f, degrees_of(response.identified))
    late, early = turned + np.rad2deg(band.latest), turned + np.rad2deg(band.earliest)
    phase.fill_between(band.frequency, late, early, **look)
    label = f"{response.quantity} / {response.force} [{response.unit}]"
    magnitude.set(xscale="log", yscale="log", ylabel=label)
    magnitude.set_title(f"Frequency response {response.force} → {response.signal}", loc="left", pad=44)
    seen = np.abs(np.concatenate([response.identified, response.measured[sure]]))
    magnitude.set_ylim(float(seen.min() / 3), float(seen.max() * 3))
    handles, labels = magnitude.get_legend_handles_labels()
    where: Any = {"loc": "lower left", "bbox_to_anchor": (-0.02, 0.99), "ncols": 2}
    where |= {"columnspacing": 1.0, "handlelength": 1.4}  # within a figure for a phone
    magnitude.legend(handles[::-1], labels[::-1], frameon=False, markerscale=1.5, **where)
    phase.set(ylabel="phase [°]", ylim=(-190, 190), yticks=(-180, -90, 0, 90, 180))
    coherence.plot(f, response.coherence, color=palette.residual, linewidth=0.8, label="coherence")
    coherence.axhline(COHERENT, color=palette.ink, linewidth=0.7, linestyle="--")
    coherence.set(ylabel="coherence", ylim=(0, 1.03), xlabel="frequency [Hz]")
