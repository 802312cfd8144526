"""Errors of a fitted model on blocks of the log that are left out, one after the other.

For a model that is linear in its free values, the error of a block that takes no part in the fit follows from the fit
to all rows (Allen's PRESS for blocks): with columns J and error r of the block, and the normal matrix A of all rows,

    r' = r + J (A - J^T J)^-1 J^T r

The same sums give standard deviations that hold for errors of any correlation within a block (the sandwich of Huber
and White, with blocks as clusters).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from symid.arrays import FloatArray, IntArray
from symid.diagnosis.fit import Fit

N_BLOCKS = 16
"""Long enough that errors of different blocks hardly correlate, enough of them to draw from."""
_RANK = 1e-9
_DRAWS = 200


@dataclass(frozen=True, eq=False)
class Blocks:
    """A fitted model, block by block.

    Parameters
    ----------
    columns : array of shape (n_columns, n_outputs, n_kept)
        Derivatives of the weighted prediction, scaled to unit norm.
    scale : array of shape (n_columns,)
        Their norms before.
    errors : array of shape (n_outputs, n_kept)
        Weighted errors.
    members : sequence of array
        Rows of each block.
    """

    columns: FloatArray
    scale: FloatArray
    errors: FloatArray
    members: Sequence[IntArray]

    @cached_property
    def _normal(self) -> FloatArray:
        return np.stack([_gram(self.columns[:, :, rows]) for rows in self.members])

    @cached_property
    def _gradients(self) -> FloatArray:
        return np.stack(
            [np.einsum("pok,ok->p", self.columns[:, :, rows], self.errors[:, rows]) for rows in self.members]
        )

    @cached_property
    def squares(self) -> FloatArray:
        """Sums of squares of the errors of each block when it is left out, of shape (n_outputs, n_blocks)."""
        whole = self._normal.sum(axis=0)
        found = np.zeros((len(self.errors), len(self.members)))
        for b, rows in enumerate(self.members):
            moved = np.linalg.pinv(whole - self._normal[b], rcond=_RANK, hermitian=True) @ self._gradients[b]
            errors = self.errors[:, rows] + np.tensordot(moved, self.columns[:, :, rows], 1)
            found[:, b] = np.sum(errors**2, axis=1)
        return found

    def least_seen(self, n: int) -> float:
        """Least square of a combination of the last columns, of unit size, without what the others explain."""
        whole = self._normal.sum(axis=0)
        others, last = slice(None, -n), slice(-n, None)
        taken = np.linalg.pinv(whole[others, others], rcond=_RANK, hermitian=True)
        left = whole[last, last] - whole[last, others] @ taken @ whole[others, last]
        return float(np.linalg.eigvalsh(left)[0])

    @cached_property
    def covariance(self) -> FloatArray:
        """Covariance of the free values, errors of a block correlated in any way."""
        inverse = np.linalg.pinv(self._normal.sum(axis=0), rcond=_RANK**1.4, hermitian=True)
        n = len(self.members)
        meat = self._gradients.T @ self._gradients * (n / max(n - len(inverse) / 2, 1))
        return np.asarray(inverse @ meat @ inverse / np.outer(self.scale, self.scale))


def blocks_of(fit: Fit, n_blocks: int = N_BLOCKS) -> Blocks:
    """A fitted model in blocks of the same number of rows."""
    weighting, beginning = fit.weighting, fit.state.beginning
    columns, errors = (weighting.known(x, beginning) for x in (fit.columns, fit.state.rows))
    n_outputs, n_kept = len(fit.state.rows), int(weighting.kept.sum())
    scale = np.linalg.norm(columns, axis=1)
    scale = np.where(scale > 0, scale, 1.0)
    return Blocks(
        (columns / scale[:, None]).reshape(len(columns), n_outputs, n_kept),
        scale,
        errors.reshape(n_outputs, n_kept),
        np.array_split(np.arange(n_kept), n_blocks),
    )


def certainty(before: FloatArray, after: FloatArray, n_rows: float) -> float:
    """Probability that one model predicts better than another, from blocks drawn anew (paired bootstrap).

    Parameters
    ----------
    before, after : array of shape (n_outputs, n_blocks)
        Sums of squares of blocks left out.
    n_rows : float
        Independent rows of an output.
    """
    rng = np.random.default_rng(0)
    n = before.shape[1]
    drawn = rng.integers(n, size=(_DRAWS, n))
    gains = [
        log_likelihood(after[:, blocks], n_rows) - log_likelihood(before[:, blocks], n_rows)
        for blocks in drawn
    ]
    return float(np.mean(np.array(gains) > 0))


def deviation(one: FloatArray, other: FloatArray, n_rows: float) -> float:
    """Standard deviation of the gain of one model over another, from the scatter of the blocks.

    Parameters
    ----------
    one, other : array of shape (n_outputs, n_blocks)
        Sums of squares of blocks left out.
    n_rows : float
        Independent rows of an output.
    """
    mean = (one.sum(axis=1) + other.sum(axis=1)) / 2
    gains = 0.5 * n_rows * np.sum((one - other) / np.maximum(mean, np.finfo(float).tiny)[:, None], axis=0)
    return float(np.std(gains) * np.sqrt(gains.size))


def log_likelihood(squares: FloatArray, n_rows: float) -> float:
    """Logarithm of the likelihood of errors of unknown level in each output, but for a constant.

    Parameters
    ----------
    squares : array of shape (n_outputs, n_blocks)
        Sums of squares.
    n_rows : float
        Independent rows of an output.
    """
    return float(-0.5 * n_rows * np.sum(np.log(np.maximum(squares.sum(axis=1), np.finfo(float).tiny))))


def _gram(columns: FloatArray) -> FloatArray:
    flat = columns.reshape(len(columns), -1)
    return np.asarray(flat @ flat.T)


def rows_of(fit: Fit) -> float:
    """Independent rows of an output of a fit."""
    return float(fit.weighting.kept.sum()) * fit.state.scene.record.freedom


def predicted(fit: Fit) -> float:
    """Logarithm of the likelihood of the blocks of a fit when they are left out, but for a constant."""
    return log_likelihood(blocks_of(fit).squares, rows_of(fit))
