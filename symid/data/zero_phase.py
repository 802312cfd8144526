"""Recursive filters run forward and backward, over pieces of a signal that several threads share.

A recursive filter forgets: after `reach` samples nothing that a number can hold is left of the state it started
from. A piece of a signal, filtered together with that many samples on either side, therefore equals what filtering the
whole signal gives, to rounding. Pieces stay in the cache, need no memory of the size of the signal, and can be
computed by several threads at a time.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
import scipy

from symid.arrays import FloatArray
from symid.errors import SettingError

_PIECE: Final = 131_072  # samples of a piece at least: measured best for 1 to 8 rows of 1e7 samples
_MOST_REACH: Final = 16  # length of a piece in multiples of the reach on either side
_FORGOTTEN: Final = 1e-19  # of a state; far below rounding, since the modes of a filter add up


@dataclass(frozen=True)
class Piece:
    """Samples `start` to before `stop` of a signal, and the wider range `first` to before `last` that they need."""

    start: int
    stop: int
    first: int
    last: int

    @property
    def inner(self) -> slice:
        """The samples of the piece, counted from `first`."""
        return slice(self.start - self.first, self.stop - self.first)


def pieces(n_samples: int, reach: int) -> Iterator[Piece]:
    """Pieces of a signal, each with `reach` samples on either side, or as many as there are.

    Examples
    --------
    >>> [(piece.start, piece.stop, piece.first, piece.last) for piece in pieces(200_000, 10)]
    [(0, 131072, 0, 131082), (131072, 200000, 131062, 200000)]
    """
    size = max(_PIECE, _MOST_REACH * reach)
    for start in range(0, n_samples, size):
        stop = min(start + size, n_samples)
        yield Piece(start, stop, max(start - reach, 0), min(stop + reach, n_samples))


def in_pieces(work: Callable[[Piece], None], n_samples: int, reach: int, workers: int) -> None:
    """Do some work on all pieces of a signal, `workers` of them at a time."""
    if workers <= 1 or n_samples <= _PIECE:
        for piece in pieces(n_samples, reach):
            work(piece)
    else:
        with ThreadPoolExecutor(workers) as pool:
            for _ in pool.map(work, pieces(n_samples, reach)):
                pass


@dataclass(frozen=True, eq=False)
class ZeroPhaseFilter:
    """Sections of the second order, run forward and backward with odd padding, as scipy's sosfiltfilt.

    Parameters
    ----------
    sections : array of shape (n_sections, 6)
        As scipy's filter design gives them.
    padding : int
        Samples by which a signal is continued at each end; a signal must be longer than this.
    """

    sections: FloatArray
    padding: int

    @cached_property
    def reach(self) -> int:
        """Samples after which the filter has forgotten its state."""
        slowest = max(float(np.max(np.abs(np.roots(section[3:])))) for section in self.sections)
        return (
            self.padding + math.ceil(math.log(_FORGOTTEN) / math.log(slowest))
            if slowest > 0.0
            else self.padding
        )

    @cached_property
    def constant_gain(self) -> float:
        """Gain of both passes for a constant."""
        return float(np.prod(self.sections[:, :3].sum(axis=1) / self.sections[:, 3:].sum(axis=1))) ** 2

    @cached_property
    def _settled(self) -> FloatArray:
        try:
            return np.asarray(scipy.signal.sosfilt_zi(self.sections))
        except np.linalg.LinAlgError as error:
            raise SettingError(
                "the cutoff is so low against the sampling rate that the filter does not settle: raise it"
            ) from error

    def apply(self, x: FloatArray) -> FloatArray:
        """Vector, filtered forward and backward."""
        if x[0] == x[-1] == x[x.size // 2] and bool(np.all(x == x[0])):
            return np.full(x.size, x[0] * self.constant_gain)
        before = 2.0 * x[0] - x[self.padding : 0 : -1]
        after = 2.0 * x[-1] - x[-2 : -self.padding - 2 : -1]
        extended: FloatArray = np.concatenate((before, x, after))
        for _ in ("forward", "backward"):
            passed, _ = scipy.signal.sosfilt(self.sections, extended, zi=self._settled * extended[0])
            extended = passed[::-1]
        return extended[self.padding : -self.padding]

    def apply_rows(self, x: FloatArray, out: FloatArray, kept: slice, workers: int) -> None:
        """Filter each row of `x` and write the samples `kept` into the same row of `out`."""
        offset, step = kept.start or 0, kept.step or 1

        def filter_piece(piece: Piece) -> None:
            places, chosen = kept_of(piece, offset, step)
            for row in np.ndindex(x.shape[:-1]):
                out[row][places] = self.apply(x[row][piece.first : piece.last])[chosen]

        in_pieces(filter_piece, x.shape[-1], self.reach, workers)


def kept_of(piece: Piece, offset: int, step: int) -> tuple[slice, slice]:
    """Where the samples offset, offset + step ... that lie in a piece go, and where they are counted from `first`.

    Examples
    --------
    >>> kept_of(Piece(start=10, stop=20, first=8, last=22), offset=1, step=4)
    (slice(3, 5, None), slice(5, 12, 4))
    """
    begin = max(-(-(piece.start - offset) // step), 0)
    end = max(-(-(piece.stop - offset) // step), 0)
    return slice(begin, end), slice(offset + begin * step - piece.first, piece.stop - piece.first, step)
