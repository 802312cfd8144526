"""Linear recursions over long signals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from symid.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class StateSpace:
    """x[k+1] = A x[k] + B u[k], y[k] = C x[k] + D u[k]."""

    A: FloatArray
    B: FloatArray
    C: FloatArray
    D: FloatArray

    def free_response(self, n_samples: int, forgotten: float = 0.0) -> FloatArray:
        """Outputs from each unit initial state, of shape (n_samples, p, n); shorter if it falls to `forgotten` before.

        >>> system = StateSpace(np.array([[0.5]]), np.ones((1, 1)), np.ones((1, 1)), np.zeros((1, 1)))
        >>> system.free_response(4).ravel().tolist()
        [1.0, 0.5, 0.25, 0.125]
        """
        outputs, power = self.C, self.A  # the outputs of all samples, one below the other: one product each
        while len(outputs) < n_samples * len(self.C):
            following = outputs @ power
            if np.abs(following).max() <= forgotten * np.abs(outputs).max():
                break
            outputs, power = np.concatenate([outputs, following]), power @ power
        return outputs.reshape(-1, *self.C.shape)[:n_samples]

    def observed(self, C: FloatArray) -> StateSpace:
        """The recursion with other outputs, without direct feedthrough."""
        return StateSpace(self.A, self.B, C, np.zeros((len(C), self.B.shape[1])))

    def response(self, inputs: FloatArray, starts: Sequence[int]) -> FloatArray:
        """Outputs for inputs, one signal a column, from a zero state at each start: ascending, the first of them 0.

        >>> system = StateSpace(np.array([[0.5]]), np.ones((1, 1)), np.ones((1, 1)), np.zeros((1, 1)))
        >>> system.response(np.array([[1.0], [0.0], [0.0], [1.0]]), [0, 2]).ravel().tolist()
        [0.0, 1.0, 0.0, 0.0]
        """
        from symid.simulation.sample_loop import recursion  # numba takes 0.3 s to import

        A, gained, outputs = np.ascontiguousarray(self.A), inputs @ self.B.T, inputs @ self.D.T
        for start, stop in pairwise([*starts, len(inputs)]):
            outputs[start:stop] += recursion(A, np.zeros(len(A)), gained[start:stop])[:-1] @ self.C.T
        return np.asarray(outputs)
