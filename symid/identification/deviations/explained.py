"""Rows of an estimate by instruments as its checks need them: the part that the instruments explain."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symid.arrays import FloatArray
from symid.estimation import LeastSquares
from symid.identification.rows.observation import Observation


def explained_by_instruments(
    observations: Sequence[Observation], instruments: Sequence[FloatArray], fit: LeastSquares
) -> tuple[tuple[Observation, ...], LeastSquares]:
    """The observations with the part of W that instruments explain and the same residual; the fit in its coordinates.

    The residual of an estimate by instruments is not orthogonal to W, whose noise it contains, but to Z and to all that
    is linear in Z. Checks that compare parts of a log, or columns that a model lacks, need such columns: those of the
    first stage of two-stage least squares, Z (Z'Z)^-1 Z'W (J. Wooldridge, Econometric Analysis of Cross Section and
    Panel Data, 2010, section 5.1.2).
    """
    p, n_equations, coordinates = fit.solution.size, observations[0].y.shape[0], fit.rank.inverse_root
    own, cross = np.zeros((p, p)), np.zeros((p, p))
    for k, (seen, Z) in enumerate(zip(observations, instruments, strict=True)):
        for j, used in enumerate(seen.valid):
            weight = fit.weights[k * n_equations + j]
            z, w = (weight * columns[j][used] @ coordinates for columns in (Z, seen.W))
            own, cross = own + z.T @ z, cross + z.T @ w
    first_stage = np.linalg.pinv(own) @ cross
    values, vectors = np.linalg.eigh(cross.T @ first_stage)
    root = coordinates @ (vectors / np.sqrt(np.maximum(values, np.finfo(float).tiny)))
    by_parameter = coordinates @ first_stage @ np.linalg.inv(coordinates)
    explained = []
    for seen, Z in zip(observations, instruments, strict=True):
        W = Z @ by_parameter
        explained.append(replace(seen, W=W, y=seen.y + (W - seen.W) @ fit.solution))
    return tuple(explained), replace(fit, rank=replace(fit.rank, inverse_root=root))
