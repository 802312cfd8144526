"""Array types of the numeric packages, runs of flags, fast lengths of transforms, linear combinations."""

from functools import lru_cache
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
"""Array of 64 bit floating point numbers of any shape."""

BoolArray = npt.NDArray[np.bool_]
"""Array of truth values of any shape."""

IntArray = npt.NDArray[np.intp]
"""Array of indices of any shape."""

ComplexArray = npt.NDArray[np.complex128]
"""Array of complex numbers of any shape."""

Values = TypeVar("Values", bound=npt.NDArray[Any])


def read_only(values: Values) -> Values:
    """View of an array that cannot be written to.

    >>> read_only(np.zeros(2)).flags.writeable
    False
    """
    view = values.view()
    view.flags.writeable = False
    return view


def runs_of_true(flags: BoolArray) -> IntArray:
    """Begin and end (exclusive) of each run of true values, shape (n_runs, 2).

    >>> runs_of_true(np.array([True, False, True, True])).tolist()
    [[0, 1], [2, 4]]
    """
    return np.flatnonzero(np.diff(flags, prepend=False, append=False)).reshape(-1, 2)


def norms_or_one(columns: npt.NDArray[Any], axis: int = 0) -> FloatArray:
    """Norms of columns, by which they are divided to have a norm of 1; 1 for a column of zeros.

    >>> norms_or_one(np.array([[3.0, 0.0], [4.0, 0.0]])).tolist()
    [5.0, 1.0]
    """
    norms = np.linalg.norm(columns, axis=axis)
    return np.where(norms > 0.0, norms, 1.0)


def add_outer(total: ComplexArray, values: ComplexArray, row: FloatArray) -> None:
    """Add the outer product of values and a row with few entries to an array.

    >>> add_outer(total := np.zeros((1, 2), dtype=complex), np.array([2j]), np.array([0.0, 3.0]))
    >>> total.tolist()
    [[0j, 6j]]
    """
    for j in np.flatnonzero(row):
        total[:, j] += row[j] * values


def least_squares(columns: FloatArray, y: FloatArray, rcond: float | None = None) -> FloatArray:
    """Least-squares solution for columns that may differ by many decades, and may be zero.

    >>> found = least_squares(np.array([[1e-9, 0.0], [0.0, 1e9]]), np.array([2.0, 3.0]))
    >>> [f"{x:.6g}" for x in found]
    ['2e+09', '3e-09']
    """
    scale = norms_or_one(columns)
    return np.asarray((np.linalg.lstsq(columns / scale, y, rcond=rcond)[0].T / scale).T)


def unexplained_by(columns: FloatArray, y: FloatArray, rcond: float | None = None) -> FloatArray:
    """What no combination of columns explains of y, or of each of its columns: the residual of `least_squares`.

    >>> unexplained_by(np.ones((2, 1)), np.array([2.0, 4.0])).round(12).tolist()
    [-1.0, 1.0]
    """
    return y - columns @ least_squares(columns, y, rcond)


def combination_of(rows: FloatArray, wanted: FloatArray) -> FloatArray | None:
    """Factors by which rows add up to another row; None if they cannot.

    >>> combination_of(np.eye(2)[:1], np.array([3.0, 0.0])).round(12).tolist()
    [3.0]
    >>> combination_of(np.eye(2)[:1], np.array([3.0, 1.0])) is None
    True
    """
    factors = np.asarray(np.linalg.lstsq(rows.T, wanted, rcond=None)[0], dtype=float)
    return factors if np.allclose(factors @ rows, wanted) else None


@lru_cache(maxsize=256)
def fast_length(least: int) -> int:
    """Smallest number from `least` on that has no prime factor above 5: its Fourier transform is fast.

    >>> fast_length(7), fast_length(1000), fast_length(1001)
    (8, 1000, 1024)
    """
    found = 1 << (least - 1).bit_length()
    of_five = 1
    while of_five < found:
        odd = of_five
        while odd < found:
            found = min(found, odd << (-(-least // odd) - 1).bit_length())
            odd *= 3
        of_five *= 5
    return found
