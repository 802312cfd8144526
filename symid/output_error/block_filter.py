"""Linear recursions over long signals, block by block: no loop over samples."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symid.arrays import FloatArray

_BLOCK = 64


@dataclass(frozen=True, eq=False)
class StateSpace:
    """x[k+1] = A x[k] + B u[k], y[k] = C x[k] + D u[k]."""

    A: FloatArray
    B: FloatArray
    C: FloatArray
    D: FloatArray

    def free_response(self, n_samples: int, forgotten: float = 0.0) -> FloatArray:
        """Outputs from each unit initial state, of shape (n_samples, p, n); shorter if it falls to `forgotten` before.

        Examples
        --------
        >>> system = StateSpace(np.array([[0.5]]), np.ones((1, 1)), np.ones((1, 1)), np.zeros((1, 1)))
        >>> system.free_response(4).ravel().tolist()
        [1.0, 0.5, 0.25, 0.125]
        """
        response, power = self.C[None], self.A
        while len(response) < n_samples:
            following = response @ power
            if np.abs(following).max() <= forgotten * np.abs(response).max():
                break
            response, power = np.concatenate([response, following]), power @ power
        return response[:n_samples]

    def observed(self, C: FloatArray) -> StateSpace:
        """The recursion with other outputs, without direct feedthrough."""
        return StateSpace(self.A, self.B, C, np.zeros((len(C), self.B.shape[1])))

    def response(self, inputs: FloatArray, starts: Sequence[int]) -> FloatArray:
        """Outputs for inputs, one signal a column, from a zero state at each start: ascending, the first of them 0.

        Examples
        --------
        >>> system = StateSpace(np.array([[0.5]]), np.ones((1, 1)), np.ones((1, 1)), np.zeros((1, 1)))
        >>> system.response(np.array([[1.0], [0.0], [0.0], [1.0]]), [0, 2]).ravel().tolist()
        [0.0, 1.0, 0.0, 0.0]
        """
        n_samples, m = inputs.shape
        ends = [*starts[1:], n_samples]
        counts = [-(-(stop - start) // _BLOCK) for start, stop in zip(starts, ends, strict=True)]
        padded = np.zeros((sum(counts) * _BLOCK, m))
        places = np.cumsum([0, *counts])
        for start, stop, place in zip(starts, ends, places, strict=False):
            padded[place * _BLOCK : place * _BLOCK + stop - start] = inputs[start:stop]
        blocks = padded.reshape(sum(counts), _BLOCK * m)
        forced, reached = self._block_matrices()
        outputs = blocks @ forced.T
        outputs += (
            self._states(blocks @ reached.T, places[:-1])
            @ self.free_response(_BLOCK).reshape(-1, len(self.A)).T
        )
        rows = outputs.reshape(len(padded), len(self.C))
        parts = zip(starts, ends, places, strict=False)
        return np.concatenate(
            [rows[place * _BLOCK : place * _BLOCK + stop - start] for start, stop, place in parts]
        )

    def _block_matrices(self) -> tuple[FloatArray, FloatArray]:
        """Outputs within a block, and state at its end, as functions of its inputs."""
        n, m, p = len(self.A), self.B.shape[1], len(self.C)
        impulse = np.concatenate([self.D[None], self.free_response(_BLOCK - 1) @ self.B])
        forced = np.zeros((_BLOCK, p, _BLOCK, m))
        for k in range(_BLOCK):
            forced[k:, :, k] = impulse[: _BLOCK - k]
        reached = np.zeros((n, _BLOCK, m))
        effect = self.B
        for k in reversed(range(_BLOCK)):
            reached[:, k] = effect
            effect = self.A @ effect
        return forced.reshape(_BLOCK * p, _BLOCK * m), reached.reshape(n, _BLOCK * m)

    def _states(self, gained: FloatArray, firsts: FloatArray) -> FloatArray:
        """State at the beginning of each block; it is zero in the blocks `firsts`."""
        power = np.linalg.matrix_power(self.A, _BLOCK).T
        states = np.zeros_like(gained)
        fresh = set(map(int, firsts))
        state = np.zeros(len(self.A))
        for block in range(len(gained)):
            if block in fresh:
                state = np.zeros(len(self.A))
            states[block] = state
            state = state @ power + gained[block]
        return states
