"""Columns of numbers that rise as the times or the numbers of samples do, and the unit of their steps."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from symid.arrays import FloatArray
from symid.data.quality.clock import PLAUSIBLE_PERIODS
from symid.data.quality.coarse_clock import is_coarse
from symid.units import to_si

_EVEN: Final = 1e-3
"""Range of the steps of an even clock, as a share of the usual one."""
_UNEVEN, _REGULAR = 0.7, 0.9
"""Deviation from the usual step, as a share of it, up to which a step of a clock is regular, and least share of those:
times that are off by up to 0.45 steps have 95 % of such steps."""
_CLOCKS: Final = ("s", "ms", "us", "ns", "day")
_YEAR_2000: Final = 946_684_800  # s from 1970
_FROM_1601: Final = 1.25e17, 1.6e17  # times of 1997 to 2108, in 100 ns


def rises_evenly(values: FloatArray) -> bool:
    """Whether these are the times of samples, or their numbers."""
    steps = np.diff(values)
    step = float(np.median(steps)) if steps.size > 1 else 0.0
    return step > 0 and bool(np.ptp(steps) <= _EVEN * step)


def counts_up(values: FloatArray) -> bool:
    """Whether whole numbers rise by 1 as a rule."""
    return bool(np.all(values % 1 == 0) and np.median(np.diff(values)) == 1)


def rises_unevenly(values: FloatArray) -> bool:
    """Whether these may be the times of samples with jitter and gaps: always later, mostly by about one step.

    >>> times = np.arange(50) / 100 + 3e-3 * np.sin(np.arange(50) ** 2)
    >>> rises_unevenly(times), rises_unevenly(np.delete(times, 20)), rises_unevenly(np.arange(50.0) ** 2)
    (True, True, False)
    """
    steps = np.diff(values)
    if steps.size < 2 or np.any(steps <= 0):
        return False
    step = float(np.median(steps))
    return bool(np.mean(np.abs(steps - step) <= _UNEVEN * step) >= _REGULAR)


def step_of_clock(times: FloatArray, named: Sequence[str] = ()) -> tuple[float, str | None]:
    """Usual step of times, the mean of coarse ones, and the first unit that makes it plausible; `named` come first.

    >>> [step_of_clock(step * np.arange(9), named) for step, named in ((1.0, []), (1.0, ["us"]), (20.0, ["us"]))]
    [(1.0, 'ms'), (1.0, 'ms'), (20.0, 'us')]
    """
    step = abs(float(np.median(np.diff(times)))) if times.size > 1 else 0.0  # the last row may come first
    if not step and is_coarse(times):
        step = float(times[-1] - times[0]) / (times.size - 1)
    low, high = PLAUSIBLE_PERIODS
    fits = (unit for unit in (*named, *_clocks_of(times)) if low <= step * to_si(unit) <= high)
    return step, next(fits, None)


def _clocks_of(times: FloatArray) -> Sequence[str]:
    """Units that times may have: one, if they count from 1970, or, as Windows does, from 1601 in 100 ns.

    >>> _clocks_of(np.array([1.76e15])), _clocks_of(np.array([1.33e17])), len(_clocks_of(np.zeros(1)))
    (['us'], ['100 ns'], 5)
    """
    first = float(times[0]) if times.size else 0.0
    from_1970 = [unit for unit in _CLOCKS[:4] if _YEAR_2000 < first * to_si(unit) < 4 * _YEAR_2000]
    return from_1970 or (["100 ns"] if _FROM_1601[0] < first < _FROM_1601[1] else _CLOCKS)
