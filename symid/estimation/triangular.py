"""The triangular factor of an observation, which holds everything that least squares needs of its rows.

Rows come in blocks: of a log, of several logs, from several workers. Each block updates the triangular factor R of the
QR factorisation of [W | y]. R is small, so memory limits neither the rows nor the logs, and the normal equations are
never formed.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from symid.arrays import BoolArray, FloatArray, read_only
from symid.errors import SettingError

# Elements of a chunk of [W | y] (1.5 MB). With 4e5 rows of 6 or 16 columns, a quarter of this size is equally fast, a
# sixteenth takes 17 to 25 % longer.
_CHUNK_ELEMENTS = 196_608


@dataclass(frozen=True)
class TriangularFactor:
    """R of the QR factorisation of [W | y] of one equation, and its number of rows.

    Householder's QR commutes with a scaling of the columns by powers of two: R has the same digits as if the columns
    had been scaled first. Scales are therefore chosen only when solving.

    Examples
    --------
    >>> import numpy as np
    >>> factor = TriangularFactor.empty(1).update(np.array([[3.0], [4.0]]), np.array([3.0, 4.0]))
    >>> factor.rows, abs(factor.R).round(12).tolist()
    (2, [[5.0, 5.0], [0.0, 0.0]])
    """

    R: FloatArray
    """Upper triangular, read-only; the last column belongs to y; shape (n_parameters + 1, n_parameters + 1)."""
    rows: int
    """Number of rows that it represents."""

    def __post_init__(self) -> None:
        if self.R.ndim != 2 or self.R.shape[0] != self.R.shape[1] or self.R.shape[0] < 2:
            raise SettingError(
                f"R of a triangular factor has shape {self.R.shape}: it must be square, with one row for each "
                "parameter and one for y"
            )
        object.__setattr__(self, "R", read_only(np.array(self.R, dtype=np.float64)))

    @classmethod
    def empty(cls, n_parameters: int) -> TriangularFactor:
        """The factor of no rows.

        Raises
        ------
        SettingError
            If `n_parameters` is below 1.

        Examples
        --------
        >>> TriangularFactor.empty(3).parameters
        3
        """
        if n_parameters < 1:
            raise SettingError(f"{n_parameters} parameters: an equation needs at least one column")
        return cls(np.zeros((n_parameters + 1, n_parameters + 1)), 0)

    @property
    def parameters(self) -> int:
        """Number of columns of W."""
        return len(self.R) - 1

    @cached_property
    def norms(self) -> FloatArray:
        """Euclidean norms of the columns of [W | y], shape (n_parameters + 1,)."""
        norms: FloatArray = np.linalg.norm(self.R, axis=0)
        return norms

    def update(self, W: FloatArray, y: FloatArray, valid: BoolArray | None = None) -> TriangularFactor:
        """The factor with a block of rows added.

        Parameters
        ----------
        W : array, shape (n_samples, n_parameters)
            Rows of the observation matrix; fastest if each column is contiguous.
        y : array, shape (n_samples,)
            Output in the same rows.
        valid : bool array, shape (n_samples,), optional
            Rows that enter; all by default. Other rows may hold NaN.

        Raises
        ------
        SettingError
            If the shapes do not match or a value of a valid row is not finite.

        Examples
        --------
        >>> import numpy as np
        >>> W, y = np.array([[1.0], [np.nan]]), np.array([2.0, 0.0])
        >>> TriangularFactor.empty(1).update(W, y, np.array([True, False])).rows
        1
        """
        W, y = np.asarray(W, dtype=np.float64), np.asarray(y, dtype=np.float64)
        self._check_block(W, y, valid)
        chosen = None if valid is None or bool(np.all(valid)) else np.flatnonzero(valid)
        count = len(y) if chosen is None else len(chosen)
        columns = self.parameters + 1
        size = max(4 * columns, _CHUNK_ELEMENTS // columns)
        R: FloatArray = np.array(self.R)
        buffer = np.empty((self.parameters + 1 + min(size, count), self.parameters + 1), order="F")
        for start in range(0, count, size):
            rows = slice(start, min(start + size, count))
            R = _fold(R, W, y, rows if chosen is None else chosen[rows], rows.stop - start, buffer)
        if not np.all(np.isfinite(R)):
            raise SettingError(
                "W or y has a value that is not finite in a valid row: mask such rows or repair the log"
            )
        return TriangularFactor(R, self.rows + count)

    def _check_block(self, W: FloatArray, y: FloatArray, valid: BoolArray | None) -> None:
        if W.ndim != 2 or W.shape[1] != self.parameters or y.shape != W.shape[:1]:
            raise SettingError(
                f"block of W with shape {W.shape} and y with shape {y.shape}: (n_samples, {self.parameters}) "
                "and (n_samples,) are required"
            )
        if valid is not None and np.shape(valid) != y.shape:
            raise SettingError(
                f"valid has shape {np.shape(valid)}: one flag for each row of y {y.shape} is required"
            )


def triangular_factors(
    W: FloatArray, y: FloatArray, valid: BoolArray | None = None
) -> tuple[TriangularFactor, ...]:
    """One triangular factor for each equation of an observation.

    Parameters
    ----------
    W : array, shape (n_equations, n_samples, n_parameters)
        Observation matrix.
    y : array, shape (n_equations, n_samples)
        Output.
    valid : bool array, shape (n_samples,) or (n_equations, n_samples), optional
        Rows that enter the fit; all by default.

    Raises
    ------
    SettingError
        If the shapes do not match or a value of a valid row is not finite.

    Examples
    --------
    >>> import numpy as np
    >>> [factor.rows for factor in triangular_factors(np.ones((2, 10, 1)), np.ones((2, 10)))]
    [10, 10]
    """
    W, y, mask = checked_observation(W, y, valid)
    empty = TriangularFactor.empty(W.shape[2])
    return tuple(empty.update(W[j], y[j], None if mask is None else mask[j]) for j in range(W.shape[0]))


def checked_observation(
    W: FloatArray, y: FloatArray, valid: BoolArray | None
) -> tuple[FloatArray, FloatArray, BoolArray | None]:
    """W and y as float arrays, and `valid` with one row for each equation; SettingError if the shapes do not match.

    >>> import numpy as np
    >>> checked_observation(np.ones((2, 3, 1)), np.ones((2, 3)), np.ones(3, dtype=bool))[2].shape
    (2, 3)
    """
    W, y = np.asarray(W, dtype=np.float64), np.asarray(y, dtype=np.float64)
    if W.ndim != 3 or W.shape[0] < 1 or y.shape != W.shape[:2]:
        raise SettingError(
            f"W with shape {W.shape} and y with shape {y.shape}: (n_equations, n_samples, n_parameters) and "
            "(n_equations, n_samples) are required"
        )
    if valid is None:
        return W, y, None
    mask = np.asarray(valid)
    if mask.dtype != np.bool_ or mask.shape not in (y.shape, y.shape[1:]):
        raise SettingError(
            f"valid has shape {mask.shape} and type {mask.dtype}: "
            f"bool of shape {y.shape[1:]} or {y.shape} is required"
        )
    return W, y, np.broadcast_to(mask, y.shape)


def triangle(rows: FloatArray) -> FloatArray:
    """Square upper triangular factor of the QR factorisation, for any number of rows.

    >>> import numpy as np
    >>> triangle(np.array([[-2.0, 4.0]])).tolist()
    [[-2.0, 4.0], [0.0, 0.0]]
    """
    columns = rows.shape[1]
    stacked = np.zeros((max(len(rows), columns), columns), order="F")
    stacked[: len(rows)] = rows
    return np.asarray(np.linalg.qr(stacked, mode="r"))


def _fold(
    R: FloatArray,
    W: FloatArray,
    y: FloatArray,
    rows: slice | npt.NDArray[np.intp],
    count: int,
    buffer: FloatArray,
) -> FloatArray:
    """R of [R; W y] for `count` rows; `buffer` is reused if it has the right size."""
    columns = len(R)
    stacked = buffer if len(buffer) == columns + count else np.empty((columns + count, columns), order="F")
    stacked[:columns] = R
    stacked[columns:, :-1] = W[rows]
    stacked[columns:, -1] = y[rows]
    return np.asarray(np.linalg.qr(stacked, mode="r"))
