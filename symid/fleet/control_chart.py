"""Control chart of a parameter over time: outliers among the runs, and steps and drifts of the parameter.

An individuals chart (Shewhart; Montgomery, ch. 6) with separate limits for each run, from its standard deviation s_i
and the standard deviation between runs tau:

    centre +- 3 sqrt(s_i^2 + tau^2).

The centre is the level, or the line, of the segment that contains the run (`symid.fleet.segments`). The variance
between runs is first estimated from the median of successive differences, which steps and drifts do not affect, and
then from the residuals within the segments, by Paule and Mandel's equation. One or two successive runs far from the
median of five neighbours are outliers, which the search for changes ignores; three successive runs may be a step.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Literal

import numpy as np
import numpy.typing as npt
import scipy

from symid.arrays import BoolArray, FloatArray, read_only
from symid.errors import SettingError
from symid.fleet.segments import Series, TrendChange, TrendSegment, cut, places_of_step
from symid.fleet.spread import variance_where_zero

_LEAST_RUNS = 8
"""Smallest number of runs for which changes are sought."""
_LIMIT = 3.0  # control limits, in standard deviations
_OUTLYING = 4.5  # distance of an outlier from the median of its neighbours, in standard deviations
_LEAST_STEP = 3.0  # smallest jump between two segments that counts as a step, in standard deviations
_TINY = np.finfo(np.float64).tiny  # smallest standard deviation
_SMALLEST = 1e-100  # the same, relative to the value
_MEDIAN_OF_SQUARE = float(scipy.special.chdtri(1, 0.5))
_ROUNDS = 5  # of outliers, segments and variance between runs, which depend on each other
_NEIGHBOURS = 5  # runs whose median shows an outlier


@dataclass(frozen=True, eq=False)
class ControlChart:
    """A parameter over time. Arrays are read-only, with one entry per run in order of time."""

    time: tuple[datetime, ...] | tuple[float, ...]
    """Time of each run; its number if times are unknown."""
    order: npt.NDArray[np.intp]
    """Index of each run in the given order."""
    values: FloatArray
    """Value of each run; shape (n,)."""
    deviations: FloatArray
    """Stated standard deviation of each run; shape (n,)."""
    centre: FloatArray
    """Line of the segment; shape (n,)."""
    limit: FloatArray
    """Three standard deviations about it; shape (n,)."""
    outside: BoolArray
    """Runs beyond their limits; shape (n,)."""
    isolated: BoolArray
    """Outliers, single or two in a row, which no estimate uses; shape (n,)."""
    between: float
    """Standard deviation between runs within the segments."""
    segments: tuple[TrendSegment, ...]
    """Segments, with times in days since the first run, or in numbers of runs."""
    changes: tuple[TrendChange, ...]
    """Steps and drifts in order of time."""


def control_chart(
    values: npt.ArrayLike, deviations: npt.ArrayLike, times: Sequence[datetime] | None = None
) -> ControlChart:
    """Control chart of one parameter of one axis; changes are sought from eight runs on.

    Incomplete runs are left out. Times have all a time zone or none; without times, the runs are in order. A bolt was
    tightened before run 30:

    >>> import numpy as np
    >>> stiffness = np.where(np.arange(50) < 30, 4.0, 4.4) + 0.05 * np.random.default_rng(2).standard_normal(50)
    >>> (change,) = control_chart(stiffness, np.full(50, 0.05)).changes
    >>> change.kind, change.when, round(change.size, 1)
    ('step', 30.0, 0.4)
    """
    x, s = np.asarray(values, dtype=np.float64), np.asarray(deviations, dtype=np.float64)
    if x.ndim != 1 or x.shape != s.shape or (times is not None and len(times) != x.size):
        raise SettingError(
            f"values of shape {x.shape}, deviations {s.shape}, {'no' if times is None else len(times)} times: "
            "one of each for each run"
        )
    measured = np.isfinite(x) & np.isfinite(s) & (s > np.maximum(_TINY, _SMALLEST * np.abs(x)))
    chosen: list[int] = np.flatnonzero(measured).tolist()
    when: list[datetime] | list[float] = [float(i) for i in chosen]
    if times is not None:
        chosen.sort(key=lambda i: times[i])
        when = [times[i] for i in chosen]
    return _charted(when, x[chosen], s[chosen], np.array(chosen, dtype=np.intp))


def _charted(
    when: list[datetime] | list[float],
    values: FloatArray,
    deviations: FloatArray,
    order: npt.NDArray[np.intp],
) -> ControlChart:
    """Chart of runs in order of time."""
    # In units of the median deviation, squares of very small values do not lose digits.
    unit = float(np.median(deviations)) if order.size else 1.0
    x, variance = values / unit, (deviations / unit) ** 2
    days = [(one - when[0]) / timedelta(days=1) if isinstance(one, datetime) else one for one in when]  # type: ignore[operator]
    time = np.array(days, dtype=np.float64)
    outlying, segments, between = _segmented(time, x, variance)
    weights = np.where(outlying, 0.0, 1 / (variance + between))
    series = Series(time, x, weights)
    segments = series.refitted(segments)
    centre = np.concatenate([series.fit(s) for s in segments] or [x])
    limit = _LIMIT * np.sqrt(variance + between)
    freedom = max(int(np.count_nonzero(weights)) - sum(1 + s.drifts for s in segments), 1)
    factor = float(scipy.special.stdtrit(freedom, 0.975))
    return ControlChart(
        time=tuple(when),  # type: ignore[arg-type]  # all of one kind
        order=read_only(order),
        values=read_only(values),
        deviations=read_only(deviations),
        centre=read_only(centre * unit),
        limit=read_only(limit * unit),
        outside=read_only(np.abs(x - centre) > limit),
        isolated=read_only(outlying),
        between=math.sqrt(between) * unit,
        segments=tuple(s.scaled(unit) for s in segments),
        changes=tuple(_changes(series, segments, when, unit, factor)),
    )


def _changes(
    series: Series,
    segments: Sequence[TrendSegment],
    when: Sequence[datetime] | Sequence[float],
    unit: float,
    factor: float,
) -> Iterator[TrendChange]:
    """Steps between the segments and drifts within them; intervals are `factor` standard deviations to either side."""

    def change(
        kind: Literal["step", "drift"], places: tuple[int, int, int], before: float, after: float, std: float
    ) -> TrendChange:
        run, earliest, latest = places
        size, reach = unit * (after - before), unit * factor * std
        interval, levels = (size - reach, size + reach), (unit * before, unit * after)
        return TrendChange(
            kind, run, when[run], when[earliest], when[latest], size, unit * std, interval, *levels
        )

    for i, segment in enumerate(segments):
        first, last = segment.first, segment.end - 1
        start, stop = float(series.time[first]), float(series.time[last])
        (begin, variance), (end, _) = segment.at(start), segment.at(stop)
        if i:
            old, old_variance = segments[i - 1].at(start)
            std = math.sqrt(old_variance + variance)
            if abs(begin - old) >= _LEAST_STEP * std:
                earliest, latest = places_of_step(series, segments[i - 1], segment)
                yield change("step", (first, earliest - 1, latest), old, begin, std)
        if segment.drifts:
            std = math.sqrt(segment.slope_variance) * (stop - start)
            yield change("drift", (first, first, last), begin, end, std)


def _segmented(
    time: FloatArray, x: FloatArray, variance: FloatArray
) -> tuple[BoolArray, tuple[TrendSegment, ...], float]:
    """Outliers, segments and the variance between runs of a series."""
    outlying = np.zeros(x.size, dtype=bool)
    segments: tuple[TrendSegment, ...] = ()
    if not x.size:
        return outlying, segments, 0.0
    if x.size < _LEAST_RUNS:
        segments = (Series(time, x, 1 / variance).segment(0, x.size, sloping=False),)
        return outlying, segments, _variance_within(x, variance, time, segments, ~outlying)
    # Outliers, segments and variance depend on each other: they are computed in turn until the segments do not change.
    # The first variance makes the median of the squared successive differences that of their chi-square distribution.
    squares, stated = np.diff(x) ** 2, variance[1:] + variance[:-1]
    between = variance_where_zero(
        lambda tau2: float(np.median(squares / (stated + 2 * tau2))) - _MEDIAN_OF_SQUARE,
        float(squares.max()) / _MEDIAN_OF_SQUARE,
    )
    starts = np.clip(np.arange(x.size) - _NEIGHBOURS // 2, 0, x.size - _NEIGHBOURS)
    # neighbours include the run
    away = np.abs(x - np.median(x[starts[:, None] + np.arange(_NEIGHBOURS)], axis=1))
    for _ in range(_ROUNDS):
        outlying, before = np.asarray(away > _OUTLYING * np.sqrt(variance + between)), segments
        weights = np.where(outlying, 0.0, 1 / (variance + between))
        segments = cut(Series(time, x, weights), slope_penalty(x.size))
        between = _variance_within(x, variance, time, segments, ~outlying)
        if [(s.first, s.end, s.drifts) for s in segments] == [(s.first, s.end, s.drifts) for s in before]:
            break
    return outlying, segments, between


def slope_penalty(runs: int) -> float:
    """Penalty of a slope in the criterion: the 1 % quantile of chi-square, plus the logarithm of the length.

    >>> round(slope_penalty(100), 1)
    11.2
    """
    return float(scipy.special.chdtri(1, 1e-2)) + math.log(runs)


def _variance_within(
    x: FloatArray, variance: FloatArray, time: FloatArray, segments: Sequence[TrendSegment], used: BoolArray
) -> float:
    """Variance between runs about the lines of the segments, at which Q equals its degrees of freedom."""
    freedom = int(used.sum()) - sum(1 + s.drifts for s in segments)
    if freedom < 1:
        return 0.0

    def excess(tau2: float) -> float:
        series = Series(time, x, np.where(used, 1 / (variance + tau2), 0.0))
        return series.squared_error(*((s.first, s.end, s.drifts) for s in segments)) - freedom

    return variance_where_zero(excess, (excess(0.0) + freedom) / freedom * float(variance.max()))
