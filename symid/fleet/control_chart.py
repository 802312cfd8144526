"""Control chart of a parameter over time: which runs are outliers, and when the parameter stepped or drifted.

An individuals chart (Shewhart; Montgomery, ch. 6) whose limits follow each run: the run's own standard deviation s_i
and the deviation between runs tau,

    centre +- 3 sqrt(s_i^2 + tau^2).

The centre is the level, or the line, of the segment that the run belongs to (`symid.fleet.segments`). The variance
between runs is at first taken from successive differences, as a moving range is, by their median, so that steps and
drifts do not enter; then from the residuals within the segments, by Paule and Mandel's equation. Single runs, or two
in a row, that stand off the median of five neighbours are outliers and take no part in the search for changes; three
in a row may be a step.
"""

from __future__ import annotations

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

LEAST_RUNS = 8
"""Runs from which changes are looked for."""
_LIMIT = 3.0
_STANDS_OFF = 4.5
_LEAST_STEP = 3.0
"""Standard deviations that the jump between two segments must have to be called a step."""
_TINY, _SMALLEST = np.finfo(np.float64).tiny, 1e-100
"""Least standard deviation, and its least ratio to the value; no measurement has a smaller one."""
_MEDIAN_OF_SQUARE = float(scipy.special.chdtri(1, 0.5))
_ROUNDS = 5
_NEIGHBOURS = 5


@dataclass(frozen=True, eq=False)
class ControlChart:
    """A parameter over time. Arrays are read-only, one entry a run, in order of time.

    Parameters
    ----------
    time : tuple of datetime or of float
        When each run was recorded; its number where that is not known.
    order : array of int
        Place of each run in what was given.
    values, deviations : array of shape (n,)
        Value and promised standard deviation of each run.
    centre, limit : array of shape (n,)
        Line of the segment, and three standard deviations about it.
    outside : bool array of shape (n,)
        Runs beyond their limits.
    isolated : bool array of shape (n,)
        Outliers, alone or two in a row: far from their neighbours on both sides, and left out of all estimates.
    between : float
        Standard deviation between runs within the segments.
    segments : tuple of TrendSegment
        Their times are days since the first run, or numbers of runs.
    changes : tuple of TrendChange
        In order of time.
    """

    time: tuple[datetime, ...] | tuple[float, ...]
    order: npt.NDArray[np.intp]
    values: FloatArray
    deviations: FloatArray
    centre: FloatArray
    limit: FloatArray
    outside: BoolArray
    isolated: BoolArray
    between: float
    segments: tuple[TrendSegment, ...]
    changes: tuple[TrendChange, ...]


def control_chart(
    values: npt.ArrayLike, deviations: npt.ArrayLike, times: Sequence[datetime] | None = None
) -> ControlChart:
    """Control chart of one parameter of one axis.

    Parameters
    ----------
    values, deviations : array of shape (n_runs,)
        Value and standard deviation from each run; runs without both are left out.
    times : sequence of datetime, optional
        When they were recorded, all with a time zone or all without; by default they come in order.

    Returns
    -------
    ControlChart
        Below eight runs, no changes are looked for.

    Raises
    ------
    SettingError
        If the numbers of values, deviations and times differ.

    Examples
    --------
    A bolt was tightened before the 30th run:

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
    """Chart of runs in order of time; internally in a unit in which squares of small values keep their digits."""
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
    found = list(_shifts(series, segments))
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
        changes=tuple(
            TrendChange(
                kind=one.kind,
                log=one.run,
                when=when[one.run],
                earliest=when[one.earliest],
                latest=when[one.latest],
                size=unit * one.size,
                std=unit * one.std,
                interval=(unit * (one.size - factor * one.std), unit * (one.size + factor * one.std)),
                before=unit * one.before,
                after=unit * one.after,
            )
            for one in found
        ),
    )


@dataclass(frozen=True)
class _Shift:
    """A step or a drift between runs given by their places; values in the unit of the computation."""

    kind: Literal["step", "drift"]
    run: int
    earliest: int
    latest: int
    before: float
    after: float
    std: float

    @property
    def size(self) -> float:
        """Change of the value."""
        return self.after - self.before


def _shifts(series: Series, segments: Sequence[TrendSegment]) -> Iterator[_Shift]:
    """Steps between the segments and drifts within them; a drift may begin or end without a step."""
    for i, segment in enumerate(segments):
        first, last = segment.first, segment.end - 1
        start, stop = float(series.time[first]), float(series.time[last])
        (begin, variance), (end, _) = segment.at(start), segment.at(stop)
        if i:
            old, old_variance = segments[i - 1].at(start)
            std = math.sqrt(old_variance + variance)
            if abs(begin - old) >= _LEAST_STEP * std:
                earliest, latest = places_of_step(series, segments[i - 1], segment)
                yield _Shift("step", first, earliest - 1, latest, old, begin, std)
        if segment.drifts:
            std = math.sqrt(segment.slope_variance) * (stop - start)
            yield _Shift("drift", first, first, last, begin, end, std)


def _segmented(
    time: FloatArray, x: FloatArray, variance: FloatArray
) -> tuple[BoolArray, tuple[TrendSegment, ...], float]:
    """Outliers, segments and the variance between runs of a series."""
    outlying = np.zeros(x.size, dtype=bool)
    segments: tuple[TrendSegment, ...] = ()
    if not x.size:
        return outlying, segments, 0.0
    if x.size < LEAST_RUNS:
        segments = (Series(time, x, 1 / variance).segment(0, x.size, sloping=False),)
        return outlying, segments, _variance_within(x, variance, time, segments, ~outlying)
    # The three depend on each other: they are found in turn until the segments no longer change.
    # At first the variance comes from the median of successive differences, squared and over their variances.
    squares, promised = np.diff(x) ** 2, variance[1:] + variance[:-1]
    between = variance_where_zero(
        lambda tau2: float(np.median(squares / (promised + 2 * tau2))) - _MEDIAN_OF_SQUARE,
        float(squares.max()) / _MEDIAN_OF_SQUARE,
    )
    for _ in range(_ROUNDS):
        outlying, before = _stand_off(x, variance + between), segments
        weights = np.where(outlying, 0.0, 1 / (variance + between))
        segments = cut(Series(time, x, weights), slope_penalty(x.size))
        between = _variance_within(x, variance, time, segments, ~outlying)
        if [(s.first, s.end, s.drifts) for s in segments] == [(s.first, s.end, s.drifts) for s in before]:
            break
    return outlying, segments, between


def slope_penalty(runs: int) -> float:
    """Penalty of a slope in the criterion: a chi-square of one in a hundred, and more for long series.

    >>> round(slope_penalty(100), 1)
    11.2
    """
    return float(scipy.special.chdtri(1, 1e-2)) + math.log(runs)


def _stand_off(x: FloatArray, variance: FloatArray) -> BoolArray:
    """Runs far from the median of five neighbours, themselves included; at the ends, of the nearest five."""
    starts = np.clip(np.arange(x.size) - _NEIGHBOURS // 2, 0, x.size - _NEIGHBOURS)
    middles = np.median(x[starts[:, None] + np.arange(_NEIGHBOURS)], axis=1)
    return np.asarray(np.abs(x - middles) > _STANDS_OFF * np.sqrt(variance))


def _variance_within(
    x: FloatArray, variance: FloatArray, time: FloatArray, segments: Sequence[TrendSegment], used: BoolArray
) -> float:
    """Variance between runs about the lines of the segments: the root of Q = degrees of freedom."""
    freedom = int(used.sum()) - sum(1 + s.drifts for s in segments)
    if freedom < 1:
        return 0.0

    def excess(tau2: float) -> float:
        series = Series(time, x, np.where(used, 1 / (variance + tau2), 0.0))
        return series.squared_error(*((s.first, s.end, s.drifts) for s in segments)) - freedom

    return variance_where_zero(excess, (excess(0.0) + freedom) / freedom * float(variance.max()))
