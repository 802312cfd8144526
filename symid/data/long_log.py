"""A log that is longer than memory: only windows of it are ever read."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final, TypeAlias

from symid.arrays import FloatArray
from symid.data.log import Log, check_window
from symid.errors import SettingError

BLOCK: Final = 524_288
"""Default samples per block: its rows and their computation stay within about 100 MB."""


@dataclass(frozen=True, eq=False)
class LongLog:
    """Signals of one run in SI units, uniformly sampled; windows are read when they are needed.

    Parameters
    ----------
    source : str
        Where the signals come from.
    start : float
        Time of the first sample, s.
    sampling_period : float
        Time between two samples, s.
    n_samples : int
        Samples of each signal.
    signals : tuple of str
        Names of the signals.
    read : callable
        From the first sample and the one behind the last to the values of each signal, SI.
    notes : tuple of str
        Remarks on oddities of the data.
    block : int
        Samples that are worked on at a time.

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
    start: float
    sampling_period: float
    n_samples: int
    signals: tuple[str, ...]
    read: Callable[[int, int], Mapping[str, FloatArray]]
    notes: tuple[str, ...] = ()
    block: int = BLOCK

    def __post_init__(self) -> None:
        if self.block < 1:
            raise SettingError(f"a block of {self.block} samples holds nothing: give 1 or more")

    @classmethod
    def of(cls, log: Log, block: int = BLOCK) -> LongLog:
        """A log in memory that is worked on in blocks."""

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
