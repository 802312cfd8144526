"""Recursive filters run forward and backward over whole blocks of samples by matrix products.

A filter is a sum of modes: each pole p of its sections keeps a state s, which a sample x makes p s + x, and adds the
real part of its residue times s to the next sample. A block of samples acts on these states, and on the filtered
samples that are kept, linearly: one product with a matrix replaces the recursion over its samples. Only the states
between blocks remain recursive, once forward and once backward. Modes lose fewer digits than the states of sections,
whose differences are small beside them at low cutoffs.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Final, TypeAlias

import numpy as np
import numpy.typing as npt

from symid.arrays import FloatArray

_Complex: TypeAlias = npt.NDArray[np.clongdouble]
FORGOTTEN: Final = 1e-19
"""What is left of a state that is forgotten; far below rounding, since the modes of a filter add up."""
_LEAST_LENGTH: Final = 32  # samples of a block
_LENGTH: Final = 512  # of them at least, if few are kept
_MOST_KEPT: Final = 16  # of the samples of a longer block
_DOUBLED: Final = tuple(2**k for k in range(40))  # numbers of blocks


@dataclass(frozen=True, eq=False)
class FilterBlocks:
    """Effect of a filter on a block of samples as matrices, which rows are multiplied with.

    States are real and imaginary parts of those of the modes, one beside the other.
    """

    padding: int  # samples by which a signal is continued at each end
    step: int  # distance of kept samples
    length: int  # samples of a block, a multiple of this distance; the first is kept
    level: float  # output for a constant input of 1
    settled: FloatArray  # shape (n_states,): state for a constant input of 1
    across: FloatArray  # shape (n_states, n_states): state behind a block by that before it
    # shape (n, n_states): state behind the last of n samples by each of them, n the most samples beside the blocks
    gain: FloatArray
    free: FloatArray  # shape (n_states, n): output by the state before
    passes: FloatArray  # shape (n, n): output by input
    # shape (length, 2 n_states + n_kept): what the samples of a block add to the state of the forward run, to that of
    # the backward run, and to what is kept
    input: FloatArray
    # shape (n_states, n_states + n_kept): the same by the state of the forward run before the block
    state: FloatArray
    # shape (n_states, n_kept): what is kept, by the state of the backward run behind the block
    later: FloatArray

    @classmethod
    def of(cls, sections: FloatArray, padding: int, step: int) -> "FilterBlocks":
        """Matrices of sections of the second order, of shape (n_sections, 6), if every `step`-th sample is kept."""
        length = max(step * min(_MOST_KEPT, -(-_LENGTH // step)), _LEAST_LENGTH)
        n = length + padding
        poles, residues = _modes(sections)
        powers = poles[:, None] ** np.arange(n)
        free = _real_and_imaginary(np.conj(residues[:, None] * powers))
        impulse = np.concatenate(([0.0] * (n - 1), [np.prod(sections[:, 0])], free[::2].sum(axis=0)[:-1]))
        passes = np.lib.stride_tricks.sliding_window_view(impulse, n)[::-1].copy()
        gain = _real_and_imaginary(powers).T
        inside = passes[:length, :length]
        back = np.concatenate((gain[:length], inside[::step].T), axis=1)
        across = np.zeros((len(poles), 2, len(poles), 2))
        for k, over in enumerate(poles**length):
            across[k, :, k] = [[over.real, over.imag], [-over.imag, over.real]]
        return cls(
            padding,
            step,
            length,
            gain_at_rest(sections),
            _real_and_imaginary(1.0 / (1.0 - poles[:, None]))[:, 0],
            across.reshape(len(free), len(free)),
            gain[::-1].copy(),
            free,
            passes,
            np.concatenate((gain[:length][::-1], inside @ back), axis=1),
            free[:, :length] @ back,
            free[:, length - 1 :: -1][:, ::step],
        )

    def apply(self, x: FloatArray, first: int, count: int) -> FloatArray:
        """`count` samples of filtered rows from `first` on; the ends are continued by odd reflection."""
        begin = (self.padding + first) % self.length - self.padding
        begin += self.length if begin < 0 else 0
        n_rows, n_blocks = len(x), max((x.shape[1] - 1 - begin) // self.length, 0)
        end, n = begin + n_blocks * self.length, len(self.across)
        head = np.concatenate((2.0 * x[:, :1] - x[:, self.padding : 0 : -1], x[:, :begin]), axis=1)
        tail = np.concatenate((x[:, end:], 2.0 * x[:, -1:] - x[:, -2 : -self.padding - 2 : -1]), axis=1)
        by_input = x[:, begin:end].reshape(n_rows, n_blocks, self.length) @ self.input
        entering, behind = self._states_before(by_input[..., :n], self._state_behind(head))
        size = tail.shape[1]
        passed = (tail @ self.passes[:size, :size] + behind @ self.free[:, :size])[:, ::-1]
        level = passed[:, :1]
        rest = self.level * level + (passed - level) @ self.passes[:size, :size]
        back = by_input[..., n:] + entering @ self.state
        entering, _ = self._states_before(back[:, ::-1, :n], self._state_behind(passed))
        inner = (back[..., n:] + entering[:, ::-1] @ self.later).reshape(n_rows, -1)
        found = np.concatenate((inner, rest[:, ::-1][:, :: self.step]), axis=1)
        skipped = (first - begin) // self.step
        return found[:, skipped : skipped + count]

    def _state_behind(self, x: FloatArray) -> FloatArray:
        """State behind few samples of rows, before which it was settled at their first level."""
        level = x[:, :1]
        return np.asarray(level * self.settled + (x - level) @ self.gain[len(self.gain) - x.shape[1] :])

    def _states_before(self, added: FloatArray, first: FloatArray) -> tuple[FloatArray, FloatArray]:
        """States before each block of rows and behind the last, by what the blocks add to the state before the first.

        Sums over 1, 2, 4 ... blocks are doubled until the filter has forgotten earlier samples.
        """
        states = np.concatenate((first[:, None], added), axis=1)
        for across, reach in zip(self._powers, _DOUBLED, strict=False):
            if reach >= states.shape[1]:
                break
            states[:, reach:] += states[:, :-reach] @ across
        return states[:, :-1], states[:, -1]

    @cached_property
    def _powers(self) -> list[FloatArray]:
        """State behind 1, 2, 4 ... blocks by that before them, until the filter has forgotten."""
        powers = [self.across]
        while np.abs(powers[-1]).max() > FORGOTTEN and len(powers) < len(_DOUBLED):
            powers.append(powers[-1] @ powers[-1])
        return powers[:-1] if np.abs(powers[-1]).max() <= FORGOTTEN else powers


def gain_at_rest(sections: FloatArray) -> float:
    """Output of sections for a constant input of 1.

    >>> gain_at_rest(np.array([[0.25, 0.25, 0.0, 1.0, -0.5, 0.0]]))
    1.0
    """
    return float(np.prod(sections[:, :3].sum(axis=1) / sections[:, 3:].sum(axis=1)))


def _modes(sections: FloatArray) -> tuple[_Complex, _Complex]:
    """Poles of sections in the upper half plane, and their residues, twice of those off the real axis."""
    exact = sections.astype(np.longdouble)  # powers of poles lose digits
    half, square = -0.5 * exact[:, 4], exact[:, 5]
    apart = np.sqrt(half**2 - square + 0j)
    every = np.concatenate((half + apart, half - apart))
    poles = every[every.imag >= 0.0]
    numerators = (exact[:, :1] * poles + exact[:, 1:2]) * poles + exact[:, 2:3]
    distances = poles[:, None] - every
    distances[every == poles[:, None]] = 1.0
    pairs = np.where(poles.imag > 0.0, 2.0, 1.0)
    return poles, pairs * np.prod(numerators, axis=0) / np.prod(distances, axis=1)


def _real_and_imaginary(values: _Complex) -> FloatArray:
    """Real and imaginary part of each row, one below the other."""
    parts = np.stack([values.real, values.imag], axis=1).astype(np.float64)
    return parts.reshape(2 * len(values), -1)
