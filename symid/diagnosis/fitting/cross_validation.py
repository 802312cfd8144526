"""Block cross-validation of a fitted model: errors on each block of the log when it is left out of the fit.

For a model that is linear in its free values, the error of a block that takes no part in the fit follows from the fit
to all rows (Allen's PRESS for blocks): with columns J and error r of the block, and the normal matrix A of all rows,

    r' = r + J (A - w J^T J)^-1 w J^T r

With w = 1 a value that only this block determines, such as the limit of a drive that saturates once, would be
arbitrary; w < 1 leaves the block a small weight, so such a value stays where it was.

The same sums give standard deviations for errors with any correlation within a block (cluster-robust covariance of
Huber and White, with blocks as clusters).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from symid.arrays import BoolArray, FloatArray, norms_or_one
from symid.diagnosis.fitting.state import State
from symid.diagnosis.prediction.weighting import Weighting
from symid.identification.deviations import Segment

N_BLOCKS = 16
"""Long enough that errors of different blocks hardly correlate, enough of them to draw from."""
_RANK = 1e-9
_LEFT_OUT = 0.95
"""Share of its weight that a block loses where it is left out."""
_DRAWS = 200  # of blocks with replacement
_UNFELT = 1e-12  # square of a unit column below which no row feels a value


@dataclass(frozen=True, eq=False)
class Blocks:
    """A fitted model, block by block."""

    # shape (n_columns, n_outputs, n_kept): derivatives of the weighted prediction, scaled to unit norm
    columns: FloatArray
    scale: FloatArray  # shape (n_columns,): their norms before
    errors: FloatArray  # shape (n_outputs, n_kept): weighted errors
    members: Sequence[slice]  # rows of each block
    # shape (n_columns,): values that are estimated again when a block is left out; values in which the prediction
    # is far from linear are not
    free: BoolArray

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
        """Sum of squared errors of each block when it is left out, of shape (n_outputs, n_blocks)."""
        whole, free = self._normal.sum(axis=0), np.flatnonzero(self.free)
        columns = self.columns if self.free.all() else self.columns[free]
        found = np.zeros((len(self.errors), len(self.members)))
        for b, rows in enumerate(self.members):
            left = (whole - _LEFT_OUT * self._normal[b])[np.ix_(free, free)]
            moved = np.linalg.pinv(left, rcond=_RANK, hermitian=True) @ self._gradients[b][free]
            moved *= _LEFT_OUT
            errors = self.errors[:, rows] + np.tensordot(moved, columns[:, :, rows], 1)
            found[:, b] = np.sum(errors**2, axis=1)
        return found

    def least_independent_part(self, n: int) -> float:
        """Least sum of squares of a unit combination of the last columns after projection on the others.

        Columns that are zero do not count, such as that of a change at a moment when the axis rests.
        """
        whole = self._normal.sum(axis=0)
        felt = np.flatnonzero(np.diag(whole) > _UNFELT)
        others, last = felt[felt < len(whole) - n], felt[felt >= len(whole) - n]
        if not last.size:
            return 0.0
        taken = np.linalg.pinv(whole[np.ix_(others, others)], rcond=_RANK, hermitian=True)
        cross = whole[np.ix_(last, others)]
        left = whole[np.ix_(last, last)] - cross @ taken @ cross.T
        return float(np.linalg.eigvalsh(left)[0])

    @cached_property
    def covariance(self) -> FloatArray:
        """Covariance of the free values, for errors with any correlation within a block."""
        inverse = np.linalg.pinv(self._normal.sum(axis=0), rcond=_RANK**1.4, hermitian=True)
        n = len(self.members)
        meat = self._gradients.T @ self._gradients * (n / max(n - len(inverse) / 2, 1))
        return np.asarray(inverse @ meat @ inverse / np.outer(self.scale, self.scale))

    def segments(self, times: FloatArray) -> tuple[tuple[Segment, ...], FloatArray]:
        """Blocks as segments of an estimate of all columns, and the transformation of its coordinates to the values.

        `times`, shape (n_kept,), are those of the rows.
        """
        strengths, V = np.linalg.eigh(self._normal.sum(axis=0))
        root = V[:, strengths > _RANK] / np.sqrt(strengths[strengths > _RANK])
        found = (
            Segment(
                float(times[rows.start]),
                0,
                root.T @ normal @ root,
                root.T @ gradient,
                float(np.sum(self.errors[:, rows] ** 2)),
                self.errors[:, rows].size,
            )
            for rows, normal, gradient in zip(self.members, self._normal, self._gradients, strict=True)
            if rows.stop > rows.start
        )
        return tuple(found), root / self.scale[:, None]


def cross_validation_blocks(
    state: State, weighting: Weighting, columns: FloatArray, errors: FloatArray
) -> Blocks:
    """A fitted model in blocks of equal length.

    `columns` are its weighted derivatives by its values, of shape (n_columns, n), and `errors`, (n,), its errors, both
    as `Weighting.known` gives them.
    """
    n_outputs, n_kept = len(state.rows), int(weighting.kept.sum())
    scale = norms_or_one(columns, axis=1)
    known = columns / scale[:, None]
    return Blocks(
        known.reshape(len(known), n_outputs, n_kept),
        scale,
        errors.reshape(n_outputs, n_kept),
        _blocks(n_kept),
        _free(state),
    )


def _blocks(n: int) -> list[slice]:
    """Contiguous blocks of rows; the first blocks have one row more where the number does not divide."""
    lengths = np.full(N_BLOCKS, n // N_BLOCKS) + (np.arange(N_BLOCKS) < n % N_BLOCKS)
    ends = np.cumsum(lengths)
    return [slice(int(end - length), int(end)) for length, end in zip(lengths, ends, strict=True)]


def _free(state: State) -> BoolArray:
    """All physical parameters and amplitudes; shapes only of effects without amplitudes."""
    free = [True] * len(state.prediction.parameters)
    for item in state.placed:
        amplitudes = item.n_free - len(item.shape)
        free += [True] * amplitudes + [not amplitudes and i == 0 for i in range(len(item.shape))]
    return np.array(free)


def certainty(before: FloatArray, after: FloatArray, n_rows: float) -> float:
    """Probability that one model predicts better than another, from blocks drawn with replacement (paired bootstrap).

    From sums of squares of blocks left out, of shape (n_outputs, n_blocks), and the independent rows of an output.
    """
    rng = np.random.default_rng(0)
    n = before.shape[1]
    drawn = rng.integers(n, size=(_DRAWS, n))
    gains = _log_likelihoods(after[:, drawn], n_rows) - _log_likelihoods(before[:, drawn], n_rows)
    return float(np.mean(gains > 0))


def least_fall(before: FloatArray, after: FloatArray) -> float:
    """Least fall of the error in a block, relative to the median of the blocks, of the output whose error falls most.

    >>> least_fall(np.array([[4.0, 4.0, 4.0]]), np.array([[2.0, 2.0, 3.0]]))
    0.5
    """
    falls = before - after
    of_output = falls[np.argmax(falls.sum(axis=1) / before.sum(axis=1))]
    median = float(np.median(of_output))
    return float(of_output.min()) / median if median > 0 else -np.inf


def deviation(one: FloatArray, other: FloatArray, n_rows: float) -> float:
    """Standard deviation of the gain of one model over another, from the scatter of the blocks; as `certainty`."""
    mean = (one.sum(axis=1) + other.sum(axis=1)) / 2
    gains = 0.5 * n_rows * np.sum((one - other) / np.maximum(mean, np.finfo(float).tiny)[:, None], axis=0)
    return float(np.std(gains) * np.sqrt(gains.size))


def log_likelihood(squares: FloatArray, n_rows: float) -> float:
    """Log-likelihood of errors of unknown level in each output, up to a constant; arguments as in `certainty`."""
    return float(_log_likelihoods(squares, n_rows))


def _log_likelihoods(squares: FloatArray, n_rows: float) -> FloatArray:
    """`log_likelihood` for any number of draws of the blocks, of shape (n_outputs, ..., n_blocks)."""
    levels = np.maximum(squares.sum(axis=-1), np.finfo(float).tiny)
    return np.asarray(-0.5 * n_rows * np.sum(np.log(levels), axis=0))


def _gram(columns: FloatArray) -> FloatArray:
    flat = columns.reshape(len(columns), -1)
    return np.asarray(flat @ flat.T)
