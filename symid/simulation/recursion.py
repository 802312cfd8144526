"""Linear recursions z[k + 1] = F z[k] + v[k] over many samples by a few matrix products.

The samples are cut into rows of 8. Within a row the response to its own inputs is one matrix product for all rows at
once; from row to row the states follow the same recursion with F^8, solved in the same way.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from symid.arrays import FloatArray

ROW = 8
"""Samples whose responses are computed by one matrix."""

_UNSHARED = 2**18
"""Multiplications up to which OpenBLAS leaves a product to one thread; sharing costs more than it gives here."""


class Recursion:
    """The recursion of a square matrix F.

    Examples
    --------
    >>> Recursion(np.array([[0.5]])).states(np.array([8.0]), np.array([[0.0], [1.0], [0.0]])).ravel().tolist()
    [8.0, 4.0, 3.0, 1.5]
    """

    def __init__(self, matrix: FloatArray) -> None:
        self._size = m = len(matrix)
        powers = [np.eye(m)]
        for _ in range(ROW):
            powers.append(matrix @ powers[-1])
        self._across = powers[ROW]
        self._free = np.hstack([power.T for power in powers[1:]])
        self._forced = np.zeros((ROW * m, ROW * m))
        for i in range(ROW):
            for j in range(i, ROW):
                self._forced[i * m : (i + 1) * m, j * m : (j + 1) * m] = powers[j - i].T

    @cached_property
    def _rows(self) -> Recursion:
        return Recursion(self._across)

    def states(self, start: FloatArray, inputs: FloatArray) -> FloatArray:
        """States from a start under inputs of shape (n, m); shape (n + 1, m), the start first."""
        n, m = len(inputs), self._size
        n_rows, rest = divmod(n, ROW)
        found = np.empty((n + 1, m))
        found[0] = start
        # Response of each row to its own inputs from rest; the ends of these responses are the inputs of the recursion
        # from row to row, which gives the states at the beginnings of the rows; their free responses are added.
        if n_rows > 1:
            forced = _product(inputs[: n_rows * ROW].reshape(n_rows, ROW * m), self._forced)
            begins = self._rows.states(start, forced[:-1, -m:])
            forced += _product(begins, self._free)
            found[1 : n_rows * ROW + 1] = forced.reshape(-1, m)
        elif n_rows == 1:
            self._row(found, 0, inputs, ROW)
        if rest:
            self._row(found, n_rows * ROW, inputs, rest)
        return found

    def _row(self, found: FloatArray, begin: int, inputs: FloatArray, n: int) -> None:
        """Fill in the n states after `begin`."""
        size = n * self._size
        forced = inputs[begin : begin + n].ravel() @ self._forced[:size, :size]
        found[begin + 1 : begin + n + 1] = (forced + found[begin] @ self._free[:, :size]).reshape(n, -1)


def _product(left: FloatArray, right: FloatArray) -> FloatArray:
    """left @ right, by one thread."""
    rows = max(_UNSHARED // right.size, 1)
    found = np.empty((len(left), right.shape[1]))
    for begin in range(0, len(left), rows):
        np.matmul(left[begin : begin + rows], right, out=found[begin : begin + rows])
    return found
