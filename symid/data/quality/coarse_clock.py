"""Times that are rounded so much that several samples share one: whether the samples are even, and their period."""

from typing import Final

import numpy as np

from symid.arrays import FloatArray

SHARED: Final = 0.2
"""Least share of the intervals that are zero where times are coarse."""
_FEWEST: Final = 2
"""Fewest different times: of fewer nothing is known about the period."""

_TIE: Final = 1e-3
"""Share of the tick for the digits of times since 1970; times halfway between two ticks are rounded to either."""


def is_coarse(time: FloatArray) -> bool:
    """Whether many samples share a time, and none is earlier than the one before.

    >>> is_coarse(np.floor(np.arange(100) / 10)), is_coarse(np.arange(100.0)), is_coarse(np.zeros(100))
    (True, False, False)
    """
    intervals = np.diff(time)
    return bool(
        intervals.size
        and np.all(intervals >= 0.0)
        and np.count_nonzero(intervals) >= _FEWEST
        and np.mean(intervals == 0.0) > SHARED
    )


def period_of_rows(time: FloatArray) -> float | None:
    """Sampling period of evenly sampled rows with these coarse times; None if no period fits.

    Times of even samples, rounded to a tick, deviate from a straight line over a range of at most the tick. Of the
    periods of such lines it is that of the fewest digits, as itself or as a frequency. A gap of more than one sample
    breaks the line.

    >>> period_of_rows(np.round(np.arange(4000) / 1600, 2)), period_of_rows(np.round(np.arange(999.0) ** 2 / 4e5, 2))
    (0.000625, None)
    """
    intervals, index = np.diff(time), np.arange(time.size, dtype=np.float64)
    tick = float(np.median(intervals[intervals > 0.0]))
    slope = float(np.polyfit(index, time - time[0], 1)[0])
    for digits in range(1, 8):
        for period in (float(f"{slope:.{digits - 1}e}"), 1.0 / float(f"{1.0 / slope:.{digits - 1}e}")):
            if np.ptp(time - time[0] - period * index) <= (1.0 + _TIE) * tick:
                return period
    return None


def change_between(values: FloatArray, time: FloatArray) -> bool:
    """Whether values change between samples that share a time as they do elsewhere; those of repeated rows do not."""
    if values.size != time.size:
        return False
    changes, shared = np.diff(values) != 0.0, np.diff(time) == 0.0
    return bool(changes.any() and np.mean(changes[shared]) > 0.5 * np.mean(changes[~shared]))
