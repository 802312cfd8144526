"""Autoregressive model of weighted errors, which whitens them."""

from dataclasses import dataclass

import numpy as np

from symid.arrays import BoolArray, FloatArray

_ROWS_PER_COEFFICIENT = 2
_LEAST_USABLE = 0.75
"""Least share of the kept rows that have a past of the order of the model."""


@dataclass(frozen=True, eq=False)
class Autoregression:
    """Autoregressive model that whitens weighted errors."""

    coefficients: FloatArray  # shape (n_outputs, order, n_outputs): factors of past rows in the next one
    whitening: FloatArray  # shape (n_outputs, n_outputs): scales the innovations to unit covariance
    usable: BoolArray  # shape (n_rows,): rows whose past is kept too

    def apply(self, rows: FloatArray) -> FloatArray:
        """Whiten rows of shape (..., n_outputs, n_rows); the result has shape (..., n_outputs * n_usable)."""
        if not self.coefficients.any():  # the rows as they are, see `unweighted`
            return rows[..., self.usable].reshape(*rows.shape[:-2], -1)
        from symid.estimation.white_rows import white_rows  # numba takes 0.3 s

        flat = np.ascontiguousarray(rows.reshape(-1, *rows.shape[-2:]))
        white = white_rows(flat, self.coefficients, self.whitening, np.flatnonzero(self.usable))
        return np.asarray(white.reshape(*rows.shape[:-2], -1))

    def by_sample(self, rows: FloatArray) -> FloatArray:
        """White rows from weighted ones, both as vectors (..., n) of the outputs of one sample after the other."""
        p = len(self.coefficients)
        outputs = rows.reshape(*rows.shape[:-1], -1, p).swapaxes(-1, -2)
        white = self.apply(outputs).reshape(*rows.shape[:-1], p, -1)
        return np.asarray(white.swapaxes(-1, -2).reshape(*rows.shape[:-1], -1))

    def adjoint(self, white: FloatArray) -> FloatArray:
        """The adjoint of `apply`: rows, (..., n_outputs, n_rows), from white ones, (..., n_outputs * n_usable)."""
        n_outputs, order, _ = self.coefficients.shape
        whole = np.zeros((*white.shape[:-1], n_outputs, self.usable.size))
        whole[..., self.usable] = white.reshape(*white.shape[:-1], n_outputs, -1)
        whole = np.matmul(self.whitening.T, whole)
        rows = whole.copy()
        for k in range(order):
            rows[..., : -(k + 1)] -= np.matmul(self.coefficients[:, k].T, whole[..., k + 1 :])
        return np.asarray(rows)


def autoregression(rows: FloatArray, kept: BoolArray, order: int) -> Autoregression:
    """Least-squares autoregressive model of the kept rows, of shape (n_outputs, n_rows).

    The order is reduced where rests leave few rows with a past of that length: those of short strokes would be lost.
    """
    p = len(rows)
    usable = _with_past(kept, order)
    while order > 1 and usable.sum() < max(_ROWS_PER_COEFFICIENT * p * order, _LEAST_USABLE * kept.sum()):
        order -= 1
        usable = _with_past(kept, order)
    past = np.concatenate([np.roll(rows, k, axis=1)[:, usable] for k in range(1, order + 1)]).T
    present = rows[:, usable].T
    solution = np.linalg.lstsq(past, present, rcond=None)[0]
    # The innovations still correlate between outputs: the inverse Cholesky factor of their covariance whitens them.
    left = present - past @ solution
    covariance = left.T @ left / max(len(left), 1)
    root = np.linalg.cholesky(covariance + 1e-14 * np.trace(covariance) * np.eye(p))
    return Autoregression(np.ascontiguousarray(solution.T).reshape(p, order, p), np.linalg.inv(root), usable)


def _with_past(kept: BoolArray, order: int) -> BoolArray:
    """Kept rows whose `order` predecessors are kept too."""
    usable = kept.copy()
    for k in range(1, order + 1):
        usable &= np.roll(kept, k)
    usable[:order] = False
    return usable


def unweighted(rows: FloatArray, kept: BoolArray, order: int) -> Autoregression:
    """The model of white errors, on the rows that an autoregressive model would use."""
    found = autoregression(rows, kept, order)
    return Autoregression(np.zeros_like(found.coefficients), np.eye(len(rows)), found.usable)
