"""Parameters that an observation determines, alone or only in combination.

Decisions are made on columns of unit norm, so that they do not depend on the units of the parameters.
"""

from dataclasses import dataclass

import numpy as np

from symid.arrays import FloatArray

_EPS = float(np.finfo(np.float64).eps)


@dataclass(frozen=True)
class RankAnalysis:
    """The column space of an observation matrix, as far as it matters for its parameters."""

    rank: int  # numerical rank of W with columns of unit norm
    singular_values: FloatArray  # shape (n_parameters,): of W with columns of unit norm, largest first
    # shape (n_parameters, rank): T with T T' the (pseudo-)inverse of W'W in the caller's units; W T has
    # orthonormal columns
    inverse_root: FloatArray
    undetermined: tuple[int, ...]  # parameters that the rows do not determine
    # shape (n_parameters, n_parameters - rank): changes of the parameters that leave W X as it is; each has a 1
    # at one dependent parameter
    null_space: FloatArray
    # shape (len(undetermined) - (n_parameters - rank), n_parameters): coefficients of the combinations of
    # undetermined parameters that are determined; each has a 1 at one parameter and the dependent ones grouped to it
    combinations: FloatArray

    @property
    def condition_number(self) -> float:
        """2-norm condition of W with columns of unit norm; inf if its smallest singular value is 0."""
        return condition_number(self.singular_values)


def condition_number(singular_values: FloatArray) -> float:
    """Return largest over smallest singular value; inf where the smallest is 0.

    >>> import numpy as np
    >>> condition_number(np.array([4.0, 2.0])), condition_number(np.array([1.0, 0.0]))
    (2.0, inf)
    """
    smallest = float(singular_values[-1])
    return float(singular_values[0]) / smallest if smallest > 0.0 else float("inf")


def analyse_rank(R: FloatArray, rows: int) -> RankAnalysis:
    """Analyse which parameters a triangular factor R of W determines, W having `rows` rows.

    The rank counts singular values above eps max(rows, parameters, 100) times the largest, columns having
    unit norm: what rounding in W itself and in its factorisation leaves of an exact dependency lies below.

    Two equal columns: only the sum of the parameters is determined, the third is by itself.

    >>> import numpy as np
    >>> analysis = analyse_rank(np.array([[1.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 2.0]]), 3)
    >>> analysis.rank, analysis.undetermined
    (2, (0, 1))
    >>> analysis.combinations.round(12).tolist()
    [[1.0, 1.0, 0.0]]
    """
    norms: FloatArray = np.linalg.norm(R, axis=0)
    scales = np.where(norms > 0.0, norms, 1.0)
    values = np.asarray(np.linalg.svd(R / scales, compute_uv=False), dtype=np.float64)
    tolerance = _EPS * max(rows, R.shape[1], 100)
    rank = int(np.count_nonzero(values > tolerance * values[0])) if values[0] > 0.0 else 0
    if rank == R.shape[1]:
        root = np.asarray(np.linalg.solve(R, np.eye(rank)))
        return _frozen(rank, values, root, (), np.zeros((rank, 0)), np.zeros((0, rank)))
    Vt = np.linalg.svd(R / scales)[2]
    # a direction of the null space is known to about (what rounding leaves) / (smallest value that is not 0)
    noise = np.clip(10.0 * tolerance * values[0] / values[rank - 1], 1e-8, 0.1) if rank else 1e-8
    undetermined, null_space, combinations = _dependencies(Vt[rank:].T, scales, float(noise))
    root = (Vt[:rank].T / values[:rank]) / scales[:, None]
    return _frozen(rank, values, root, undetermined, null_space, combinations)


def _dependencies(
    basis: FloatArray, scales: FloatArray, noise: float
) -> tuple[tuple[int, ...], FloatArray, FloatArray]:
    """Undetermined parameters, their null space and determined combinations, from its orthonormal basis."""
    dependent = _dependent_parameters(basis)
    undetermined = np.union1d(np.flatnonzero(np.linalg.norm(basis, axis=1) > noise), dependent)
    reduced = np.asarray(np.linalg.solve(basis[dependent].T, basis.T).T, dtype=np.float64)
    reduced[np.abs(reduced) <= noise] = 0.0
    independent = np.setdiff1d(undetermined, dependent)
    grouped = np.zeros((len(independent), len(basis)))
    grouped[np.arange(len(independent)), independent] = 1.0
    grouped[:, dependent] = -reduced[independent]
    null_space = reduced * scales[dependent] / scales[:, None]
    return tuple(int(i) for i in undetermined), null_space, grouped * scales / scales[independent, None]


def _dependent_parameters(basis: FloatArray) -> list[int]:
    """One parameter for each direction of the null space, the last ones that describe it well.

    Not those that describe it best: between equal columns rounding would choose, and the grouping would
    change from log to log.
    """
    remaining = basis.copy()
    chosen: list[int] = []
    for _ in range(basis.shape[1]):
        norms = np.linalg.norm(remaining, axis=1)
        chosen.append(int(np.flatnonzero(norms > 0.1 * norms.max())[-1]))
        direction = remaining[chosen[-1]] / norms[chosen[-1]]
        remaining -= np.outer(remaining @ direction, direction)
    return sorted(chosen)


def _frozen(
    rank: int,
    values: FloatArray,
    root: FloatArray,
    undetermined: tuple[int, ...],
    null_space: FloatArray,
    combinations: FloatArray,
) -> RankAnalysis:
    for array in (values, root, null_space, combinations):
        array.flags.writeable = False
    return RankAnalysis(rank, values, root, undetermined, null_space, combinations)
