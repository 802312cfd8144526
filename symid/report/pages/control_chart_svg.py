"""Control charts and distributions as shapes of a page: drawn without JavaScript, coloured by the page's style."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta

import numpy as np

from symid.arrays import FloatArray
from symid.fleet import ControlChart, ParameterReview, robust_deviation
from symid.report.tables.fleet import change_sentence

WIDTH, HEIGHT = 760, 190
_LEFT, _RIGHT, _TOP, _BOTTOM = 64, 10, 12, 24
_MOST_BARS = 250
"""Most runs for which each has an interval bar and individual limits."""
BARS_WIDTH, BARS_HEIGHT = 220, 84
_BINS = 28
_REACH = 4.5
"""Robust standard deviations that a distribution shows on either side; values beyond are in its last bars."""
_STEPS = (
    timedelta(hours=1),
    timedelta(hours=6),
    *(timedelta(days=d) for d in (1, 2, 7, 14, 30, 91, 182, 365, 730)),
)


@dataclass(frozen=True)
class Tick:
    """A mark on an axis: its place in the drawing and its text."""

    place: float
    text: str


@dataclass(frozen=True)
class Mark:
    """A change in a chart: its place, the interval of the place, and its kind."""

    place: float
    left: float
    width: float
    kind: str
    text: str


@dataclass(frozen=True)
class ChartShapes:
    """Shapes of a control chart; paths in the units of a drawing of WIDTH by HEIGHT."""

    runs: str
    outside: str
    intervals: str
    band: str
    centre: str
    x_ticks: tuple[Tick, ...]
    y_ticks: tuple[Tick, ...]
    marks: tuple[Mark, ...]
    # in the order of the points: rows of the page's table, and the values that the chart draws of each
    rows: tuple[int, ...]
    levels: tuple[float, ...]
    limits: tuple[float, ...]


@dataclass(frozen=True)
class DistributionShapes:
    """Shapes of a distribution; paths in the units of a drawing of BARS_WIDTH by BARS_HEIGHT."""

    bars: str
    promised: str
    low: str
    middle: str
    high: str


def chart_shapes(parameter: ParameterReview, rows: Sequence[int]) -> ChartShapes:
    """Shapes of the chart of a parameter with at least one interval; `rows` are those of the page's table, by log."""
    chart = parameter.chart
    time = np.array([t.timestamp() if isinstance(t, datetime) else float(t) for t in chart.time])
    x, (low, high) = _horizontal(time), _range(chart)

    def y(values: FloatArray) -> FloatArray:
        return _TOP + (high - np.clip(values, low, high)) / (high - low) * (HEIGHT - _TOP - _BOTTOM)

    heights, line = y(chart.values), y(chart.centre)
    out = chart.outside | (chart.values < low) | (chart.values > high)
    few = x.size <= _MOST_BARS
    segments = [(s.first, s.end - 1) for s in chart.segments]
    ends = zip(x, y(chart.values - chart.deviations), y(chart.values + chart.deviations), strict=True)
    places = np.concatenate([np.flatnonzero(~out), np.flatnonzero(out)])
    return ChartShapes(
        runs=_points(x[~out], heights[~out]),
        outside=_points(x[out], heights[out]),
        intervals="".join(f"M{a:.1f} {b:.1f}V{c:.1f}" for a, b, c in ends) if few else "",
        band=_band(chart, x, y(chart.centre - _limits(chart)), y(chart.centre + _limits(chart))),
        centre="".join(f"M{x[a]:.1f} {line[a]:.1f}L{x[b]:.1f} {line[b]:.1f}" for a, b in segments),
        x_ticks=_time_ticks(chart, time),
        y_ticks=tuple(Tick(float(y(np.array(v))), _number(v, high - low)) for v in _round_values(low, high)),
        marks=_marks(chart, time),
        rows=tuple(int(rows[place]) for place in chart.order[places]),
        levels=tuple(chart.centre[places].tolist()),
        limits=tuple(chart.limit[places].tolist()),
    )


def distribution_shapes(parameter: ParameterReview, values: FloatArray) -> DistributionShapes:
    """Shapes of the distribution of a parameter's values, with the curve expected from its intervals."""
    reach = _REACH * max(robust_deviation(values), 1e-9 * abs(parameter.median), 1e-300)
    low, high = max(parameter.median - reach, values.min()), min(parameter.median + reach, values.max())
    margin = 0.12 * (high - low) or reach
    if math.isfinite(
        parameter.spread.promised
    ):  # values that hardly differ need no digits beyond their deviations
        margin = max(margin, 0.2 * parameter.spread.promised)
    low, high = float(low - margin), float(high + margin)
    counts, edges = np.histogram(np.clip(values, low, high), bins=_BINS, range=(low, high))
    floor, width = BARS_HEIGHT - 16, BARS_WIDTH / _BINS
    middles = np.linspace(low, high, 141)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        density = np.exp(-0.5 * ((middles - parameter.median) / parameter.spread.promised) ** 2)
        area = values.size * (edges[1] - edges[0])
        expected = density * area / parameter.spread.promised / math.sqrt(2 * math.pi)
    known = bool(np.all(np.isfinite(expected)))
    if known:  # a narrow curve would dwarf the bars: only its width matters
        expected *= min(1.0, 1.4 * counts.max() / expected.max())
    top = 1.1 * max(counts.max(), expected.max() if known else 0.0)
    heights = (floor - 2) * counts / top
    bars = "".join(
        f"M{i * width + 0.5:.1f} {floor}v{-h:.1f}h{width - 1:.1f}v{h:.1f}z"
        for i, h in enumerate(heights)
        if h > 0
    )
    line = floor - (floor - 2) * expected / top if known else np.zeros(0)
    places = (middles[: line.size] - low) / (high - low) * BARS_WIDTH
    path = "L".join(f"{a:.1f} {b:.1f}" for a, b in zip(places, line, strict=True))
    texts = (_number(value, high - low) for value in (low, parameter.median, high))
    return DistributionShapes(bars, f"M{path}" if path else "", *texts)


def _horizontal(time: FloatArray, of: FloatArray | None = None) -> FloatArray:
    shown = time if of is None else of
    length = float(np.ptp(time))
    share = (shown - time.min()) / length if length else np.full(shown.shape, 0.5)
    return np.asarray(_LEFT + 6 + share * (WIDTH - _LEFT - _RIGHT - 12))


def _range(chart: ControlChart) -> tuple[float, float]:
    """Values that are shown: all within twice the limits; a run that is farther off is drawn at the edge."""
    # one poorly determined log must not flatten the others
    limits = np.minimum(_limits(chart), 3 * np.median(chart.limit))
    lowest = np.minimum(np.maximum(chart.values, chart.centre - 2 * limits), chart.centre - limits)
    highest = np.maximum(np.minimum(chart.values, chart.centre + 2 * limits), chart.centre + limits)
    low, high = float(lowest.min()), float(highest.max())
    margin = 0.04 * (high - low) or abs(high) or 1.0
    return low - margin, high + margin


def _limits(chart: ControlChart) -> FloatArray:
    """Limits as drawn: of many runs, their median in each segment."""
    if chart.limit.size <= _MOST_BARS:
        return chart.limit
    limits = chart.limit.copy()
    for s in chart.segments:
        limits[s.first : s.end] = np.median(limits[s.first : s.end])
    return limits


def _band(chart: ControlChart, x: FloatArray, lower: FloatArray, upper: FloatArray) -> str:
    """Area between the limits, one for each segment."""
    parts = []
    for s in chart.segments:
        places = np.arange(s.first, s.end) if x.size <= _MOST_BARS else np.array([s.first, s.end - 1])
        there = [f"{x[i]:.1f} {upper[i]:.1f}" for i in places]
        back = [f"{x[i]:.1f} {lower[i]:.1f}" for i in places[::-1]]
        parts.append("M" + "L".join([*there, *back]) + "z")
    return "".join(parts)


def _points(x: FloatArray, y: FloatArray) -> str:
    """Points as strokes of no length with round ends: thousands are one shape."""
    return "".join(f"M{a:.1f} {b:.1f}h0" for a, b in zip(x, y, strict=True))


def _marks(chart: ControlChart, time: FloatArray) -> tuple[Mark, ...]:
    marks = []
    for change in chart.changes:
        moments = (change.when, change.earliest, change.latest)
        seconds = [m.timestamp() if isinstance(m, datetime) else float(m) for m in moments]
        if change.kind == "step" and change.log > 0:  # between the run before it and that after it
            seconds[0] = 0.5 * (time[change.log] + time[change.log - 1])
        place, left, right = _horizontal(time, np.array(seconds))
        width = float(max(right - left, 1.0))
        marks.append(Mark(float(place), float(left), width, change.kind, change_sentence(change)))
    return tuple(marks)


def _time_ticks(chart: ControlChart, time: FloatArray) -> tuple[Tick, ...]:
    first = chart.time[0]
    if isinstance(first, datetime):
        length = float(np.ptp(time))
        step = next((s.total_seconds() for s in _STEPS if length / s.total_seconds() <= 7), length / 5)
        begin = math.ceil(time.min() / step) * step
        moments = np.arange(begin, time.max() + 1, step) if length else time[:1]
        moments = moments[moments <= time.max()]
        form = "%Y-%m-%d" if step >= 86400 else "%m-%d %H:%M"
        texts = [datetime.fromtimestamp(float(m), tz=first.tzinfo).strftime(form) for m in moments]
    else:
        moments = np.array([v for v in _round_values(time.min(), time.max()) if v == int(v)] or [time.min()])
        texts = [f"log {m + 1:.0f}" for m in moments]
    return tuple(Tick(float(p), text) for p, text in zip(_horizontal(time, moments), texts, strict=True))


def _round_values(low: float, high: float) -> list[float]:
    """Round numbers between two, five at most."""
    if not high > low:
        return [low]
    size = 10.0 ** math.floor(math.log10((high - low) / 5))
    step = next(size * m for m in (1, 2, 5, 10) if (high - low) / (size * m) <= 5)
    return [step * k for k in range(math.ceil(low / step), math.floor(high / step) + 1)]


def _number(value: float, length: float) -> str:
    """A number with the digits that distinguish it at the resolution of an axis."""
    if value == 0:
        return "0"
    order, size = math.floor(math.log10(length)), math.floor(math.log10(abs(value)))
    if -4 <= size < 6:
        return f"{value:.{max(1 - order, 0)}f}"
    mantissa, exponent = f"{value:.{min(max(size - order + 1, 0), 9)}e}".split("e")
    return f"{mantissa}e{int(exponent)}"
