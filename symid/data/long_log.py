"""Logs that are longer than memory: one pass checks them, windows of them are read when they are needed.

The pass reads all columns block by block and finds what `read_table` finds: values that are not finite numbers, a clock
that is not uniform (in each block, and between them), channels that never change. It ends at the first block with a
fault. Stuck and clipped spans, which are notes only, are looked for in evenly spread windows.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Final, TypeAlias

import numpy as np

from symid.arrays import FloatArray
from symid.data.columns import TIME, Source
from symid.data.log import Log, check_window
from symid.data.quality.checks import constant_fault, inspect_finite, inspect_steps
from symid.data.quality.clock import (
    CLOCK_DIFFERENCE,
    MINIMUM_SAMPLES,
    Clock,
    inspect_clock,
    require_seconds,
    rounded_period,
)
from symid.data.quality.stuck import inspect_spans
from symid.data.reading import converted, positions_of
from symid.data.table import Slices, naming_file
from symid.errors import LogError, SettingError
from symid.units import Unit

BLOCK: Final = 524_288
"""Default samples per block: its rows and their computation stay within about 100 MB."""


@dataclass(frozen=True, eq=False)
class LongLog:
    """Signals of one run in SI units, uniformly sampled; windows are read when they are needed.

    Raises
    ------
    SettingError
        If a block would hold nothing.

    Examples
    --------
    >>> log = Log.from_arrays({"q": [0.0, 0.1, 0.4, 0.9]}, sampling_period=0.5)
    >>> long = LongLog.of(log, block=2)
    >>> long.n_samples, long.window(1, 3)["q"].tolist(), long.window(1, 3).start
    (4, [0.1, 0.4], 0.5)
    """

    source: str
    """Where the signals come from."""
    start: float
    """Time of the first sample, s."""
    sampling_period: float
    """Time between two samples, s."""
    n_samples: int
    """Samples of each signal."""
    signals: tuple[str, ...]
    """Names of the signals."""
    read: Callable[[int, int], Mapping[str, FloatArray]]
    """Takes the first sample and the one after the last, returns the values of each signal, SI."""
    notes: tuple[str, ...] = ()
    """Remarks on oddities of the data."""
    block: int = BLOCK
    """Samples that are processed at a time."""

    def __post_init__(self) -> None:
        if self.block < 1:
            raise SettingError(f"a block of {self.block} samples holds nothing: give 1 or more")

    @classmethod
    def of(cls, log: Log, block: int = BLOCK) -> LongLog:
        """A log in memory that is processed in blocks."""

        def read(first: int, stop: int) -> Mapping[str, FloatArray]:
            return log.window(first, stop).signals

        names = tuple(log.signals)
        return cls(log.source, log.start, log.sampling_period, log.n_samples, names, read, log.notes, block)

    @property
    def sampling_frequency(self) -> float:
        """Samples per second, Hz."""
        return 1.0 / self.sampling_period

    def window(self, start_index: int, stop_index: int) -> Log:
        """Part of the log from sample `start_index` to before sample `stop_index`, in memory.

        Raises
        ------
        LogError
            Unless ``0 <= start_index < stop_index <= n_samples``.
        """
        check_window(self.source, start_index, stop_index, self.n_samples)
        start = self.start + start_index * self.sampling_period
        return Log(self.source, start, self.sampling_period, self.read(start_index, stop_index), self.notes)


AnyLog: TypeAlias = Log | LongLog
"""A log that can be identified: its windows are logs in memory."""


def in_memory(log: AnyLog) -> Log:
    """A log, all samples of a long one read into memory."""
    return log if isinstance(log, Log) else log.window(0, log.n_samples)


def first_block(log: AnyLog) -> Log:
    """A log, or the first block of a long one, in memory."""
    return log if isinstance(log, Log) else log.window(0, min(log.block, log.n_samples))


def spans(n_samples: int, size: int) -> Iterator[tuple[int, int]]:
    """First sample and end (exclusive) of blocks of almost equal length, at most `size` each.

    Parameters
    ----------
    n_samples : int
        Samples of the log.
    size : int
        Samples of the largest block.

    Examples
    --------
    >>> list(spans(10, 4))
    [(0, 3), (3, 6), (6, 10)]
    """
    count = -(-n_samples // size)
    for block in range(count):
        yield block * n_samples // count, (block + 1) * n_samples // count


_WINDOWS: Final = 8  # evenly spread over the log
_WINDOW: Final = 131_072  # samples


def scanned(
    file: Path,
    slices: Slices,
    sources: Sequence[Source],
    headers: Sequence[str],
    expected: Mapping[str, Unit],
    block: int,
) -> LongLog:
    """A long log, after a check of its rows in one pass; LogError for the first block that has a fault."""
    values_of = partial(_values_of, slices, sources, headers)

    def signals_of(first: int, stop: int) -> dict[str, FloatArray]:
        with naming_file(file):
            values = values_of(first, stop)
        return {name: x for name, x in values.items() if name != TIME}

    is_stated = all(source.stated for source in sources if source.signal == TIME)
    blocks = spans(slices.n_rows, max(block, MINIMUM_SAMPLES))
    clock, names = _checked(((first, values_of(first, stop)) for first, stop in blocks), expected, is_stated)
    log = LongLog(
        source=str(file),
        start=clock.start,
        sampling_period=clock.period,
        n_samples=slices.n_rows,
        signals=names,
        read=signals_of,
        notes=(*clock.notes, f"read in blocks of {block} samples at most"),
        block=block,
    )
    return replace(log, notes=(*log.notes, *_stuck_or_clipped(log, positions_of(expected, names))))


def _values_of(
    slices: Slices, sources: Sequence[Source], headers: Sequence[str], first: int, stop: int
) -> dict[str, FloatArray]:
    """Values of some rows by signal, SI; LogError for columns that are not numbers."""
    values: dict[str, FloatArray] = {}
    faults = []
    for source, header, column in zip(sources, headers, slices.read(first, stop), strict=True):
        if isinstance(column, str):
            faults.append(f"column {header!r} {column}")
        else:
            values[source.signal] = converted(column, source.factor)
    if faults:
        raise LogError("; ".join(faults))
    return values


def _checked(
    blocks: Iterable[tuple[int, dict[str, FloatArray]]], expected: Mapping[str, Unit], is_stated: bool
) -> tuple[Clock, tuple[str, ...]]:
    """Clock and signals of blocks, each with its first row; LogError for a fault of clock, values or jumps."""
    clock = _ClockOfBlocks()
    # The range of each channel over all blocks shows a constant one at the end.
    lowest: dict[str, float] = {}
    highest: dict[str, float] = {}
    for first, values in blocks:
        time = values.pop(TIME)
        if not first and not is_stated:
            require_seconds(time)
        faults = (*clock.add(time), *inspect_finite(time, values, first))
        if not faults:
            faults = inspect_steps(time, {n: values[n] for n in positions_of(expected, values)}, first)
        if faults:
            raise LogError("; ".join(faults))
        for name, x in values.items():
            lowest[name] = min(lowest.get(name, np.inf), float(x.min()))
            highest[name] = max(highest.get(name, -np.inf), float(x.max()))
    flat = [fault for name, x in lowest.items() if (fault := constant_fault(name, x, highest[name]))]
    whole_clock = clock.found
    if flat or whole_clock.faults:
        raise LogError("; ".join(flat or whole_clock.faults))
    return whole_clock, tuple(lowest)


def _stuck_or_clipped(log: LongLog, positions: Sequence[str]) -> list[str]:
    """The first note on each channel from evenly spread windows."""
    size = min(_WINDOW, log.n_samples)
    notes: dict[str, str] = {}
    for start in np.linspace(0, log.n_samples - size, _WINDOWS).astype(int).tolist():
        window = log.window(start, start + size)
        for note in inspect_spans(window.time, window.signals, positions):
            notes.setdefault(note.split("'")[1], note)
    return list(notes.values())


class _ClockOfBlocks:
    """The clock of times that come block by block, each found as `inspect_clock` does.

    >>> clock = _ClockOfBlocks()
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
            block_clock = inspect_clock(time)
        else:
            block_clock = inspect_clock(np.append(self._last, time), before=self._seen - 1)
        if block_clock.faults:
            return block_clock.faults
        elapsed = time - self._first
        index = np.arange(self._seen, self._seen + time.size, dtype=np.float64)
        self._sums += np.dot(index, elapsed), np.sum(elapsed)
        self._last, self._seen = float(time[-1]), self._seen + time.size
        self._blocks.append(block_clock)
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
