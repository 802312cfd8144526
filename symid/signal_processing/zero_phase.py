"""Recursive filters run forward and backward, over pieces of a signal that several threads share.

A recursive filter forgets: after `reach` samples the state is left of the state it started
from. A piece of a signal, filtered together with that many samples on either side, therefore equals what filtering the
whole signal gives, to rounding. Pieces stay in the cache, need no memory of the size of the signal, and can be
computed by several threads at a time.
"""

import math
import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Final

import numpy as np

from symid.arrays import ComplexArray, FloatArray
from symid.signal_processing.filter_blocks import FORGOTTEN, FilterBlocks, gain_at_rest
from symid.signal_processing.sections import run_sections, settled_states

_PIECE: Final = 131_072  # samples of a piece at least: measured best for 1 to 8 rows of 1e7 samples
_MOST_REACH: Final = 16  # length of a piece in multiples of the reach on either side
_MANY: Final = 4096  # samples from which products of blocks are faster than the recursion
_SLOWEST: Final = 1.0 - 1e-12  # modulus of a pole; of a cutoff near zero it is rounded beyond the circle


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

    >>> [(piece.start, piece.stop, piece.first, piece.last) for piece in pieces(200_000, 10)]
    [(0, 131072, 0, 131082), (131072, 200000, 131062, 200000)]
    """
    size = max(_PIECE, _MOST_REACH * reach)
    for start in range(0, n_samples, size):
        stop = min(start + size, n_samples)
        yield Piece(start, stop, max(start - reach, 0), min(stop + reach, n_samples))


def in_pieces(work: Callable[[Piece], None], n_samples: int, reach: int, workers: int) -> None:
    """Call `work` on every piece of a signal, in `workers` threads.

    Parameters
    ----------
    work : callable
        Takes a piece; what it returns is not used.
    n_samples : int
        Samples of the signal.
    reach : int
        Samples on either side that a piece needs.
    workers : int
        Threads; 1 calls `work` in this one.

    Examples
    --------
    >>> in_pieces(lambda piece: print(piece.start, piece.stop), 100, reach=8, workers=1)
    0 100
    """
    if workers <= 1 or n_samples <= _PIECE:
        for piece in pieces(n_samples, reach):
            work(piece)
    else:
        for _ in _threads(workers).map(work, pieces(n_samples, reach)):
            pass


@lru_cache(maxsize=4)
def _threads(workers: int) -> ThreadPoolExecutor:
    """Threads that are kept: glibc gives each new thread an arena of memory, which outlives the thread."""
    return ThreadPoolExecutor(workers)


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_threads.cache_clear)  # the threads are not in the child


def odd_extension(x: FloatArray, n: int) -> FloatArray:
    """Vector extended at both ends by `n` samples that are reflected about its first and last value.

    >>> odd_extension(np.array([1.0, 2.0, 4.0]), 2).tolist()
    [-2.0, 0.0, 1.0, 2.0, 4.0, 6.0, 7.0]
    """
    return np.concatenate((2.0 * x[0] - x[n:0:-1], x, 2.0 * x[-1] - x[-2 : -n - 2 : -1]))


@dataclass(frozen=True, eq=False)
class ZeroPhaseFilter:
    """Sections of the second order, run forward and backward with odd padding, as scipy's sosfiltfilt."""

    sections: FloatArray
    """As scipy's filter design gives them; shape (n_sections, 6)."""
    padding: int
    """Samples by which a signal is continued at each end; a signal must be longer than this."""

    @cached_property
    def reach(self) -> int:
        """Samples after which the filter has forgotten its state."""
        slowest = float(np.max(np.abs(self._poles)))
        if slowest == 0.0:
            return self.padding
        return self.padding + math.ceil(math.log(FORGOTTEN) / math.log(min(slowest, _SLOWEST)))

    def transients(self, places: FloatArray) -> FloatArray:
        """Real and imaginary parts of powers of the poles, shape (n_places, n_poles), at samples from an end.

        The assumed signal beyond an end adds a sum of these columns to the filtered signal.

        >>> from symid.signal_processing.sections import butterworth
        >>> ZeroPhaseFilter(butterworth(1, 0.25), 3).transients(np.arange(3.0))[:, 0].round(3).tolist()
        [1.0, 0.414, 0.172]
        """
        poles = self._poles[(self._poles.imag >= 0.0) & (self._poles != 0.0)]
        powers = poles ** places[:, None]
        return np.concatenate((powers.real, powers.imag[:, poles.imag > 0.0]), axis=1)

    @cached_property
    def _poles(self) -> ComplexArray:
        half, square = -0.5 * self.sections[:, 4], self.sections[:, 5]
        apart = np.sqrt(half**2 - square + 0j)
        return np.concatenate((half + apart, half - apart))

    @cached_property
    def _settled(self) -> FloatArray:
        return settled_states(self.sections)

    def apply(self, x: FloatArray) -> FloatArray:
        """Vector, filtered forward and backward."""
        passed: FloatArray = self.apply_thinned(x[None], slice(None))[0]
        return passed

    def apply_thinned(self, rows: FloatArray, kept: slice) -> FloatArray:
        """Samples `kept` of each filtered row, shape (n_rows, n_kept)."""
        first, stop, step = kept.indices(rows.shape[1])
        thinned = np.empty((len(rows), len(range(first, stop, step))))
        moving = []
        for row, x in enumerate(rows):
            if _is_constant(x):
                thinned[row] = x[0] * gain_at_rest(self.sections) ** 2
            elif rows.size < _MANY:
                thinned[row] = self._recursion(x)[kept]
            else:
                moving.append(row)
        if moving:
            chosen = rows if len(moving) == len(rows) else rows[moving]
            thinned[moving] = _blocks(self, step).apply(chosen, first, thinned.shape[1])
        return thinned

    def _recursion(self, x: FloatArray) -> FloatArray:
        """Vector, filtered sample by sample."""
        extended = odd_extension(x, self.padding)[None]
        for _ in ("forward", "backward"):
            passed, _ = run_sections(self.sections, extended, self._states(extended[:, 0]))
            extended = passed[:, ::-1]
        return extended[0, self.padding : -self.padding]

    def _states(self, levels: FloatArray) -> FloatArray:
        """States that are settled at the level of each row."""
        return self._settled * levels[:, None, None]

    def apply_rows(self, x: FloatArray, out: FloatArray, kept: slice, workers: int) -> None:
        """Filter each row of `x` and write the samples `kept` into the same row of `out`."""
        offset, step = kept.start or 0, kept.step or 1

        def filter_piece(piece: Piece) -> None:
            places, chosen = kept_of(piece, offset, step)
            for row in np.ndindex(x.shape[:-1]):
                part = x[row][piece.first : piece.last]
                out[row][places] = self.apply_thinned(part[None], chosen)[0]

        in_pieces(filter_piece, x.shape[-1], self.reach, workers)


def _is_constant(x: FloatArray) -> bool:
    return bool(x[0] == x[-1] == x[x.size // 2]) and bool(np.all(x == x[0]))


@lru_cache(maxsize=64)
def _blocks(of: ZeroPhaseFilter, step: int) -> FilterBlocks:
    return FilterBlocks.of(of.sections, of.padding, step)


def kept_of(piece: Piece, offset: int, step: int) -> tuple[slice, slice]:
    """Indices of the samples offset, offset + step ... within a piece: in the thinned signal, and from `first` on.

    Parameters
    ----------
    piece : Piece
        The piece.
    offset, step : int
        First sample of the thinned signal, and samples between two of it.

    Examples
    --------
    >>> kept_of(Piece(start=10, stop=20, first=8, last=22), offset=1, step=4)
    (slice(3, 5, None), slice(5, 12, 4))
    """
    begin = max(-(-(piece.start - offset) // step), 0)
    end = max(-(-(piece.stop - offset) // step), 0)
    return slice(begin, end), slice(offset + begin * step - piece.first, piece.stop - piece.first, step)
