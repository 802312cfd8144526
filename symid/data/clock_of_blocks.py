"""The clock of a log that is read block by block."""

from __future__ import annotations

import numpy as np

from symid.arrays import FloatArray
from symid.data.clock import CLOCK_DIFFERENCE, Clock, inspect_clock, rounded_period


class ClockOfBlocks:
    """The clock of times that come block by block, each found as `inspect_clock` does.

    >>> clock = ClockOfBlocks()
    >>> clock.add(np.arange(60) / 250.0), clock.add(np.arange(60, 120) / 250.0)
    ((), ())
    >>> clock.found.period
    0.004
    """

    def __init__(self) -> None:
        self._seen = 0
        self._first = self._last = 0.0
        self._sums = np.zeros(2)
        self._blocks: list[Clock] = []

    def add(self, time: FloatArray) -> tuple[str, ...]:
        """Faults of the next block, shape (n_samples,); after one of them no more blocks are possible."""
        if self._seen == 0:
            self._first = float(time[0])
            found = inspect_clock(time)
        else:
            found = inspect_clock(np.append(self._last, time), before=self._seen - 1)
        if found.faults:
            return found.faults
        late = time - self._first
        index = np.arange(self._seen, self._seen + time.size, dtype=np.float64)
        self._sums += np.dot(index, late), np.sum(late)
        self._last, self._seen = float(time[-1]), self._seen + time.size
        self._blocks.append(found)
        return ()

    @property
    def found(self) -> Clock:
        """Clock of all blocks together; none of them may have a fault."""
        mean = 0.5 * (self._seen - 1)
        moment = self._seen * (self._seen**2 - 1.0) / 12.0
        period = float((self._sums[0] - mean * self._sums[1]) / moment)
        periods = np.array([block.period for block in self._blocks])
        worst = int(np.argmax(np.abs(periods - np.median(periods))))
        faults: tuple[str, ...] = ()
        if abs(periods[worst] - np.median(periods)) > CLOCK_DIFFERENCE * np.median(periods):
            faults = (
                f"t changes its sampling period: {np.median(periods):.6g} s in most of the log, {periods[worst]:.6g} s "
                f"from t = {self._blocks[worst].start:.7g} s on: split the log there, or give `resample=own`",
            )
        notes = tuple(note for block in self._blocks for note in block.notes)
        return Clock(self._first, rounded_period(period), faults, notes[:1])
