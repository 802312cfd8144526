"""The clock of a log: one sampling period from the written times, and their deviations from it."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from symid.arrays import FloatArray
from symid.data.quality.coarse_clock import SHARED, is_coarse, period_of_rows
from symid.errors import LogError
from symid.text import counted, moment
from symid.units import Unit, to_si

MINIMUM_SAMPLES: Final = 25
"""Fewest samples of a log: one more than the decimation filter continues a signal at its ends."""

PLAUSIBLE_PERIODS: Final = (1.9e-5, 0.052)
"""Lowest and highest plausible sampling period of a machine, s: 50 kHz to 20 Hz, both with a margin for jitter."""

CLOCK_DIFFERENCE: Final = 0.002  # relative; real clocks differ by 0.0001, changed settings by more
_LARGEST_TIME: Final = 1e12  # s, 30 000 years: a larger number is damaged
_JITTER: Final = 0.01  # of the period, rms: the largest accepted deviation of an interval from it
_MANY_SHARE: Final = 3  # samples of one time, as no accident repeats them
_NOTED_SHARE: Final = 0.5  # share of the accepted jitter


@dataclass(frozen=True)
class Clock:
    """Clock found in the written times."""

    start: float  # time of the first sample, s
    period: float  # time between two samples, s; NaN if it could not be determined
    faults: tuple[str, ...] = ()  # reasons why the times are not one uniform clock
    notes: tuple[str, ...] = ()  # irregularities that are small enough to be ignored


@dataclass(frozen=True)
class _Rate:
    """Period of the regular intervals, before and after the time at which it changes (`change` = none)."""

    before: float
    after: float
    change: int | None


def require_seconds(time: FloatArray) -> None:
    """LogError for times without a unit that are hardly seconds: their steps fit in another unit.

    >>> require_seconds(np.arange(9) / 250.0)
    >>> require_seconds(np.arange(9) * 4.0)
    Traceback (most recent call last):
    ...
    symid.errors.LogError: t has no unit and steps of 4, which may be 4 ms: write t [ms], or give `units` t=ms, or t=s
    """
    known = time[np.isfinite(time)]
    low, high = PLAUSIBLE_PERIODS
    steps = np.diff(known)
    if steps.size and low <= steps.min() and steps.max() <= high:
        return
    step = float(np.median(steps)) if steps.size else 0.0
    fitting = (unit for unit in ("ms", "us", "ns", "day") if low <= step * to_si(unit, Unit.of("s")) <= high)
    if not low <= step <= high and (unit := next(fitting, None)):
        raise LogError(
            f"t has no unit and steps of {step:g}, which may be {step:g} {unit}: write t [{unit}], or give "
            f"`units` t={unit}, or t=s"
        )


def inspect_clock(time: FloatArray, *, before: int = 0) -> Clock:
    """The sampling period and the faults of the written times of a log, s.

    The rounding of the written times is allowed for: 1.5 ms written with three decimals, or 32 bit numbers, do not
    count as jitter. `before` counts the rows before the first of these times, in messages.

    >>> inspect_clock(np.arange(100) / 250.0).period
    0.004
    """
    if time.size < MINIMUM_SAMPLES:
        short = f"has only {counted(time.size, 'sample')}: at least {MINIMUM_SAMPLES} are required"
        return Clock(0.0, float("nan"), (short,))
    time = np.where(np.abs(time) < _LARGEST_TIME, time, np.nan)
    intervals = np.diff(time)
    if intervals.max() - intervals.min() < CLOCK_DIFFERENCE * intervals.min():  # uniform; nan never is
        return Clock(float(time[0]), rounded_period(_slope(time)))
    forward = np.flatnonzero(intervals > 0.0)
    step, faults = written_step(time), []
    missing = np.flatnonzero(~np.isfinite(time))
    if missing.size:
        faults.append(
            f"t has {counted(missing.size, 'value')} empty or no possible time, "
            f"the first in row {before + missing[0] + 1}: repair or cut out those rows"
        )
    repeated = np.count_nonzero(intervals == 0.0)
    often = repeated > SHARED * intervals.size and forward.size > 0
    digits = bool(often and np.median(intervals[forward]) < 1.5 * step)
    coarse = digits or bool(often and intervals.size >= _MANY_SHARE * forward.size)
    if coarse:
        period = period_of_rows(time) if is_coarse(time) else None
        rows = "" if period is None else f"let symid import take {period:.6g} s from row to row, or "
        or_else = "" if digits else ", or rows are repeated"
        faults.append(
            f"t is written too coarsely{or_else}, as many samples share a time: {rows}write more digits"
            + ", or remove repeated rows" * (not digits)
        )
    else:
        faults += _not_forward(time, intervals, before)
    if forward.size < 2 or coarse:
        return Clock(0.0, float("nan"), tuple(faults) or ("t does not advance: give times in s",))
    rate = _rate(intervals, forward, step)
    if rate.change is not None:
        faults.append(
            f"t changes its sampling period from {rate.before:.6g} s to {rate.after:.6g} s at "
            f"{time_and_row(time, rate.change, before)}: split the log there, or give `resample=own`"
        )
    late, wide = _lateness(intervals, rate, step)
    faults += _gaps(time, intervals, wide, rate, before)
    fault, note = _jitter(time, np.where(wide, 0.0, late), intervals > 0.0, rate.before)
    faults += fault
    period = rate.before if faults else rounded_period(_slope(time))
    return Clock(float(time[0]), period, tuple(faults), tuple(note))


def written_step(time: FloatArray) -> float:
    """Resolution of the written times, s, from their decimals or from numbers of 32 bits."""
    sample = time[:: max(1, time.size // 4096)]
    sample = sample[np.isfinite(sample)]
    largest = float(np.max(np.abs(sample), initial=0.0))
    for decimals in range(10):
        scaled = sample * 10.0**decimals
        tolerance = 8.0 * np.spacing(largest * 10.0**decimals)
        if tolerance < 0.01 and np.all(np.abs(scaled - np.round(scaled)) <= tolerance):
            return float(10.0**-decimals)
    if largest < np.finfo(np.float32).max and np.array_equal(sample.astype(np.float32), sample):
        return float(np.spacing(np.float32(largest)))
    return float(np.spacing(largest))


def time_and_row(time: FloatArray, sample: int, before: int = 0) -> str:
    """Time and row of a sample in messages; `before` counts the rows before the first of these times.

    >>> time_and_row(np.array([0.0, 0.5]), 1, before=10)
    't = 0.5 s (row 12)'
    """
    return f"t = {moment(time[sample])} s (row {before + sample + 1})"


def _not_forward(time: FloatArray, intervals: FloatArray, before: int) -> list[str]:
    faults = []
    repeated, backwards = ("repeated time", ""), ("step backwards", "steps backwards")
    for bad, words in ((intervals == 0.0, repeated), (intervals < 0.0, backwards)):
        where = np.flatnonzero(bad)
        if where.size:
            faults.append(
                f"t has {counted(where.size, *words)}, the first at "
                f"{time_and_row(time, where[0] + 1, before)}: remove those rows or split the log there"
            )
    return faults


def _rate(intervals: FloatArray, forward: npt.NDArray[np.intp], step: float) -> _Rate:
    """Sampling period before and after the one time at which it changes, robust against outliers."""
    length = min(max(12, forward.size // 64), forward.size)
    count = forward.size // length
    # The mean of the regular intervals of each stretch, those near its median, is robust against gaps and outliers, and
    # averages the rounding of the times.
    stretches = intervals[forward[: count * length]].reshape(count, length)
    middle = np.median(stretches, axis=1, keepdims=True)
    distance = np.abs(stretches - middle)
    nearest = np.min(distance, axis=1, keepdims=True)  # at least one interval must count
    regular = distance <= np.maximum(0.05 * middle + 1.01 * step, nearest)
    periods = np.sum(stretches * regular, axis=1) / np.sum(regular, axis=1)
    usual = float(np.median(periods))
    if count < 2:
        return _Rate(usual, usual, None)
    cut = _best_cut(periods)
    before, after = float(np.median(periods[:cut])), float(np.median(periods[cut:]))
    difference = abs(after - before) - CLOCK_DIFFERENCE * usual - 2.5 * step / length
    if difference <= 0.0 or difference <= 6.0 * 1.4826 * float(np.median(distance)) / np.sqrt(length):
        return _Rate(usual, usual, None)
    first = (cut - 1) * length
    near = forward[first : first + 2 * length]
    # The cut lies at a boundary of two stretches. Within both, each interval votes for the period before or after the
    # change: the sum of the votes is lowest where the change is.
    towards = np.cumsum(np.sign(after - before) * (intervals[near] - 0.5 * (before + after)))
    return _Rate(before, after, int(near[np.argmin(towards)]) + 1)


def _best_cut(periods: FloatArray) -> int:
    """Index of the cut that separates two levels best: the largest difference of means, weighted by length."""
    total = np.cumsum(periods)
    left = np.arange(1, periods.size)
    right = periods.size - left
    difference = np.abs(total[:-1] / left - (total[-1] - total[:-1]) / right)
    return int(np.argmax(difference * np.sqrt(left * right))) + 1


def _lateness(intervals: FloatArray, rate: _Rate, step: float) -> tuple[FloatArray, npt.NDArray[np.bool_]]:
    """Deviation of each interval beyond the rounding of the times, and which intervals are gaps."""
    late = np.empty_like(intervals)
    wide = np.empty(intervals.size, dtype=np.bool_)
    change = intervals.size if rate.change is None else rate.change
    for part, period in ((slice(0, change), rate.before), (slice(change, None), rate.after)):
        # Rounded to `step`, the intervals of a period alternate between the two multiples of the step beside it.
        shortest, longest = period, period
        if step > 1e-6 * period:
            shortest = np.floor(period / step + 0.02) * step
            longest = np.ceil(period / step - 0.02) * step
        inside = np.clip(intervals[part], min(shortest, period), max(longest, period))
        late[part] = intervals[part] - inside
        wide[part] = late[part] > 0.5 * period
    return late, wide


def _gaps(
    time: FloatArray, intervals: FloatArray, wide: npt.NDArray[np.bool_], rate: _Rate, before: int
) -> list[str]:
    where = np.flatnonzero(wide)
    if not where.size:
        return []
    first = where[0]
    period = rate.before if rate.change is None or first < rate.change else rate.after
    return [
        f"t has {counted(where.size, 'gap')}, the first after {time_and_row(time, first, before)}, "
        f"{intervals[first]:.4g} s instead of {period:.4g} s: split the log there, or give `resample=own`"
    ]


def _jitter(
    time: FloatArray, late: FloatArray, forward: npt.NDArray[np.bool_], period: float
) -> tuple[list[str], list[str]]:
    """Fault and note about intervals that are neither gaps nor regular."""
    deviation = np.where(forward, np.abs(late), 0.0) / period
    worst = int(np.argmax(deviation))
    if deviation[worst] <= _NOTED_SHARE * _JITTER:
        return [], []
    rms = float(np.sqrt(np.mean(deviation**2)))
    statement = (
        f"t jitters by {100.0 * rms:.2g} % of the period of {period:.6g} s (rms), by {100.0 * deviation[worst]:.3g} % "
        f"{time[worst + 1] - time[0]:.7g} s after its begin"
    )
    if rms > _JITTER:
        return [f"{statement}: at most {100.0 * _JITTER:g} % is accepted, give `resample=own`"], []
    return [], [f"{statement}; treated as uniform"]


def _slope(time: FloatArray) -> float:
    """Period of the straight line through all times, by least squares."""
    index = np.arange(time.size, dtype=np.float64) - 0.5 * (time.size - 1)
    return float(np.dot(index, time - time[0]) / np.dot(index, index))


def rounded_period(period: float) -> float:
    """Period, or frequency, of the fewest digits within one part in a million, the accuracy of good clocks."""
    for digits in range(1, 8):
        for candidate in (float(f"{period:.{digits - 1}e}"), 1.0 / float(f"{1.0 / period:.{digits - 1}e}")):
            if abs(candidate - period) <= 1e-6 * period:
                return candidate
    return period
