"""Segments of time in which a parameter is constant or drifts linearly, and the changes between them.

A series is cut into segments, each with a level or with a level and a slope, such that the criterion

    sum_i w_i (x_i - fit_i)^2 + sum_j log(n_j / K) + 3 log K (segments - 1) + slope penalty (sloping segments)

is smallest, with the inverse variance w_i of x_i. This is the modified information criterion of Zhang and Siegmund
(2007), which accounts for the search for the place of a change. The minimum over all cuts is exact, by optimal
partitioning (Jackson et al. 2005), in O(K^2) with cumulative sums.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from datetime import datetime
from typing import Literal

import numpy as np
import numpy.typing as npt

from symid.arrays import FloatArray

LEAST_LEVEL = 3
"""Smallest number of points in a segment without slope; fewer are outliers."""
LEAST_SLOPE = 6
"""Smallest number of points in a segment with a slope."""
_CREDIBLE = 0.95  # probability of the interval of a step
_MOST_PLACES = 1000  # cuts that are compared at once; those of a longer series are refined afterwards
_SHORT = 5.0  # raises the penalty for short series, whose estimated variance would cause more false alarms


@dataclass(frozen=True)
class TrendSegment:
    """Points from `first` to before `end`, and the line through them."""

    # first, end: indices in the series
    first: int
    end: int
    middle: float  # reference time of the line, the weighted mean of the times
    # level, slope: value at `middle`, and change per unit of time; a slope of 0 means a level
    level: float
    slope: float
    # level_variance, slope_variance: variances of level and slope, which are independent
    level_variance: float
    slope_variance: float

    def at(self, time: float) -> tuple[float, float]:
        """Value of the line at a time, and its variance."""
        away = time - self.middle
        return self.level + self.slope * away, self.level_variance + self.slope_variance * away**2

    def scaled(self, unit: float) -> TrendSegment:
        """The segment of all values multiplied by a unit."""
        return replace(
            self,
            level=self.level * unit,
            slope=self.slope * unit,
            level_variance=self.level_variance * unit**2,
            slope_variance=self.slope_variance * unit**2,
        )

    @property
    def drifts(self) -> bool:
        """Whether it has a slope."""
        return self.slope != 0.0


@dataclass(frozen=True, eq=False)
class Series:
    """Values in order of time.

    >>> Series(np.arange(3.0), np.array([1.0, 3.0, 5.0]), np.ones(3)).segment(0, 3, sloping=True).slope
    2.0
    """

    time: FloatArray  # shape (n,)
    values: FloatArray  # shape (n,)
    weights: FloatArray  # shape (n,): inverse variances of the values; 0 excludes a value

    def segment(self, first: int, end: int, *, sloping: bool) -> TrendSegment:
        """Level, or sloping line, of the values from `first` to before `end`."""
        t, x, w = self.time[first:end], self.values[first:end], self.weights[first:end]
        if not w.any():
            w = np.ones_like(w)
        middle = float(w @ t / w.sum())
        level = float(w @ x / w.sum())
        spread = float(w @ (t - middle) ** 2)
        if not sloping or spread == 0:
            return TrendSegment(first, end, middle, level, 0.0, float(1 / w.sum()), 0.0)
        slope = float(w @ ((t - middle) * x)) / spread
        return TrendSegment(first, end, middle, level, slope, float(1 / w.sum()), 1 / spread)

    def refitted(self, segments: Iterable[TrendSegment]) -> tuple[TrendSegment, ...]:
        """The same segments with lines through these values."""
        return tuple(self.segment(s.first, s.end, sloping=s.drifts) for s in segments)

    def fit(self, line: TrendSegment) -> FloatArray:
        """Values of a line at the times of its segment."""
        return line.level + line.slope * (self.time[line.first : line.end] - line.middle)

    def squared_error(self, *sides: tuple[int, int, bool]) -> float:
        """Weighted squared distance from the lines of segments, each given as (first, end, whether it has a slope)."""
        total = 0.0
        for first, end, sloping in sides:
            away = self.values[first:end] - self.fit(self.segment(first, end, sloping=sloping))
            total += float(self.weights[first:end] @ away**2)
        return total


@dataclass(frozen=True)
class TrendChange:
    """A step between two runs, or a drift over several."""

    kind: Literal["step", "drift"]
    """Step: tightening, lost preload, replaced part. Drift: wear, running-in, warming."""
    log: int
    """Index of the first run after a step, or of the first run of a drift."""
    when: datetime | float
    """Time of that run; its number if times are unknown."""
    earliest: datetime | float
    """A step occurred after this time, and not after `latest`, with a probability of 95 %; a drift starts here."""
    latest: datetime | float
    """Last time of a step, as above; a drift ends here."""
    size: float
    """Change, of a drift from its start to its end."""
    std: float
    """Standard deviation of the size."""
    interval: tuple[float, float]
    """95 % interval of the size."""
    before: float
    """Value before the change."""
    after: float
    """Value after the change."""

    @property
    def relative(self) -> float:
        """Size relative to the value before; nan if that is 0."""
        return self.size / abs(self.before) if self.before else math.nan


def cut(series: Series, slope_penalty: float) -> tuple[TrendSegment, ...]:
    """Segments of least cost, each slope penalised.

    >>> time = np.arange(40.0)
    >>> values = np.where(time < 25, 1.0, 2.0) + 0.1 * np.random.default_rng(0).standard_normal(40)
    >>> series = Series(time, values, np.full(40, 100.0))
    >>> [(s.first, s.end, round(s.level, 1), s.slope) for s in cut(series, slope_penalty=9.0)]
    [(0, 25, 1.0, 0.0), (25, 40, 2.0, 0.0)]
    """
    count = series.time.size
    if count < 2 * LEAST_LEVEL:
        return (series.segment(0, count, sloping=False),)
    ends, sloping = _best_cut(series, slope_penalty)
    for i in range(len(ends) - 2):
        ends[i + 1] = _refined(series, ends[i : i + 3], sloping[i : i + 2])
    sides = zip(ends[:-1], ends[1:], sloping, strict=True)
    return tuple(series.segment(first, end, sloping=slopes) for first, end, slopes in sides)


def _best_cut(series: Series, slope_penalty: float) -> tuple[list[int], list[bool]]:
    """Ends of the best segments, 0 first, and which have a slope; a long series is cut at every few places only."""
    count = series.time.size
    places = np.append(np.arange(0, count, -(-count // _MOST_PLACES)), count)
    sums = _Sums.of(series, places)
    step = 3 * math.log(count) * (1 + _SHORT / count)
    best, came_from = np.full(places.size, np.inf), np.zeros(places.size, dtype=int)
    with_slope = np.zeros(places.size, dtype=bool)
    # best[k] is the least cost of all runs before place k, came_from[k] the start of its last segment. An optimal cut
    # of more runs extends an optimal cut of fewer, so one pass over k compares all cuts. Starting at -step, the penalty
    # counts changes, one fewer than segments.
    best[0] = -step
    for k in range(1, places.size):
        level, line = sums.costs(k)
        length = places[k] - places[:k]
        shared = best[:k] + np.log(length / count) + step
        level = np.where(length < LEAST_LEVEL, np.inf, level + shared)
        line = np.where(length < LEAST_SLOPE, np.inf, line + shared + slope_penalty)
        with_slope[k] = line.min() < level.min()
        chosen = line if with_slope[k] else level
        came_from[k] = int(np.argmin(chosen))
        best[k] = chosen[came_from[k]]
    ends, sloping, k = [count], [], places.size - 1
    while k > 0:
        sloping.append(bool(with_slope[k]))
        k = int(came_from[k])
        ends.append(int(places[k]))
    return ends[::-1], sloping[::-1]


def _refined(series: Series, ends: list[int], sloping: list[bool]) -> int:
    """Best place of the middle one of three ends, among those around it that the coarse cut skipped."""
    reach = -(-series.time.size // _MOST_PLACES) - 1
    first, middle, last = ends
    places = range(max(middle - reach, first + LEAST_LEVEL), min(middle + reach, last - LEAST_LEVEL) + 1)

    def error(place: int) -> float:
        return series.squared_error((first, place, sloping[0]), (place, last, sloping[1]))

    return min(places, key=error) if reach else middle


def places_of_step(series: Series, before: TrendSegment, after: TrendSegment) -> tuple[int, int]:
    """First and last place of a step between two segments, with 95 % probability and a uniform prior."""
    places = np.arange(before.first + 1, after.end)
    costs = [
        series.squared_error((before.first, place, before.drifts), (place, after.end, after.drifts))
        for place in places.tolist()
    ]
    # With a uniform prior the posterior of a place is its likelihood; the likeliest places that hold 95 % of it count.
    likelihood = np.exp(-0.5 * (np.array(costs) - min(costs)))
    order = np.argsort(-likelihood)
    needed = int(np.searchsorted(np.cumsum(likelihood[order]), _CREDIBLE * likelihood.sum())) + 1
    likely = places[order[:needed]]
    return int(likely.min()), int(likely.max())


@dataclass(frozen=True)
class _Sums:
    """Cumulative weighted sums of a series, shape (6, n_places), from which the cost of every segment follows."""

    rows: FloatArray

    @classmethod
    def of(cls, series: Series, places: npt.NDArray[np.int64]) -> _Sums:
        """Sums of a series up to each place, centred and scaled so that differences of sums do not lose digits."""
        w, t = series.weights, (series.time - series.time.mean()) / (np.ptp(series.time) or 1.0)
        x = series.values - np.median(series.values)
        terms = np.stack([w, w * t, w * t * t, w * x, w * x * t, w * x * x])
        return cls(np.concatenate([np.zeros((6, 1)), np.cumsum(terms, axis=1)], axis=1)[:, places])

    def costs(self, end: int) -> tuple[FloatArray, FloatArray]:
        """Squared errors of a level and of a line from every earlier place to `end`."""
        w, wt, wtt, wx, wxt, wxx = self.rows[:, end : end + 1] - self.rows[:, :end]
        w = np.maximum(w, np.finfo(float).tiny)
        level = np.maximum(wxx - wx * wx / w, 0.0)
        spread = wtt - wt * wt / w
        together = wxt - wt * wx / w
        determined = spread > 1e-12 * wtt + 1e-300
        gained = np.divide(together**2, spread, out=np.zeros_like(spread), where=determined)
        return level, np.maximum(level - gained, 0.0)
