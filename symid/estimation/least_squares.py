"""Ordinary and weighted least squares from triangular factors, equations [20] to [30] of the paper."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from symid.arrays import FloatArray, read_only
from symid.errors import SettingError
from symid.estimation.rank import RankAnalysis, analyse_rank, condition_number
from symid.estimation.triangular import TriangularFactor, triangle

Method: TypeAlias = Literal["ols", "wls"]
FitStatus: TypeAlias = Literal["ok", "rank_deficient", "too_few_rows"]

_EPS = float(np.finfo(np.float64).eps)


@dataclass(frozen=True)
class LeastSquares:
    """A least-squares estimate with its statistics. Arrays are read-only."""

    status: FitStatus
    """Either "ok"; "rank_deficient": some parameters are not determined; "too_few_rows": there are no more rows than
    parameters, so that the noise and the standard deviations cannot be estimated."""
    method: Method | Literal["iv"]
    """Either "ols" [20] or "wls" [26]; "iv" for one by instrumental variables that started from one of these."""
    parameters: FloatArray
    """In the caller's units; nan where not determined; shape (n_parameters,)."""
    covariance: FloatArray
    """Classical covariance [22]; nan where not determined; shape (n_parameters, n_parameters)."""
    solution: FloatArray
    """A solution without nan: where parameters are not determined, one of many with the same residual. Shape
    (n_parameters,)."""
    weights: FloatArray
    """S_j = 1/sigma_rho_j, or 1 for "ols"; shape (n_equations,)."""
    sigma_rho: float
    """Standard deviation of the weighted residual: in units of y for "ols", near 1 for "wls"."""
    sigma_rho_equation: FloatArray
    """sigma_rho_j of [25], from each equation alone; of a homogeneous one, from the joint ordinary solution; shape
    (n_equations,)."""
    residual_norm: FloatArray
    """Norm of the unweighted residual of each equation; shape (n_equations,)."""
    y_norm: FloatArray
    """Norm of y of each equation; shape (n_equations,)."""
    factors: tuple[TriangularFactor, ...]
    """Of each equation."""
    condition_number_scaled: float
    """That of the weighted W with columns of unit norm."""
    rank: RankAnalysis
    """Determined parameters, and determined combinations of the others."""

    @property
    def rows(self) -> tuple[int, ...]:
        """Rows of each equation."""
        return tuple(factor.rows for factor in self.factors)

    @property
    def condition_number(self) -> float:
        """2-norm condition number of the unweighted W in the caller's units."""
        R = _stacked(self.factors, np.ones(len(self.factors)))[:-1, :-1]
        return condition_number(np.asarray(np.linalg.svd(R, compute_uv=False), dtype=np.float64))

    @property
    def standard_deviations(self) -> FloatArray:
        """Classical standard deviations, shape (n_parameters,)."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def relative_standard_deviations(self) -> FloatArray:
        """Relative standard deviations in percent [23], shape (n_parameters,)."""
        return relative_standard_deviation(self.parameters, self.standard_deviations)

    @property
    def undetermined(self) -> tuple[int, ...]:
        """Indices of parameters that the rows do not determine."""
        return self.rank.undetermined

    @property
    def combinations(self) -> FloatArray:
        """Coefficients of the determined combinations of undetermined parameters."""
        return self.rank.combinations

    @property
    def relative_error(self) -> float:
        """||rho|| / ||y|| over all equations; nan if y is 0 throughout."""
        norms = (np.linalg.norm(self.residual_norm), np.linalg.norm(self.y_norm))
        return float(norms[0] / norms[1]) if norms[1] > 0.0 else float("nan")


def estimate(
    factors: Sequence[TriangularFactor], method: Method = "wls", ddof: int | None = None
) -> LeastSquares:
    """Estimate the parameters that all equations share.

    Parameters
    ----------
    factors : sequence of TriangularFactor
        One for each equation.
    method : {"wls", "ols"}
        Weighted with 1/sigma_rho_j from each equation alone [24]-[30], or unweighted [20]-[22].
    ddof : int, optional
        Number subtracted from the number of rows in the divisor of sigma_rho; the rank by default. Published figures
        sometimes use 1.

    Returns
    -------
    LeastSquares
        Its status reports rank deficiency and too few rows.

    Raises
    ------
    SettingError
        If there is no factor, their columns differ, or an option is unknown.

    Examples
    --------
    >>> import numpy as np
    >>> from symid.estimation.triangular import triangular_factors
    >>> W = np.array([[[1.0, 0.0], [1.0, 1.0], [1.0, 2.0]]])
    >>> fit = estimate(triangular_factors(W, np.array([[0.0, 1.0, 5.0]])))
    >>> fit.parameters.round(12).tolist(), fit.standard_deviations.round(6).tolist()
    ([-0.5, 2.5], [1.118034, 0.866025])
    """
    _check(factors, method, ddof)
    rows = sum(factor.rows for factor in factors)
    ranks = [analyse_rank(factor.R[:-1, :-1], factor.rows) for factor in factors]
    sigmas, floors = _equation_deviations(factors, ranks, ddof)
    # An exact fit has the weight of rounding errors; an equation without information has the weight 1.
    levels = np.maximum(sigmas, floors)
    weights = np.ones(len(factors)) if method == "ols" else 1.0 / np.where(levels > 0.0, levels, 1.0)
    R = _stacked(factors, weights)
    if len(factors) == 1:
        rank = replace(ranks[0], inverse_root=read_only(ranks[0].inverse_root / weights[0]))
    else:
        rank = analyse_rank(R[:-1, :-1], rows)
    solution = _solve(R, rank)
    residual_norm = _residual_norms(factors, solution)
    divisor = rows - (rank.rank if ddof is None else ddof)
    sigma = float(np.linalg.norm(weights * residual_norm)) / np.sqrt(divisor) if divisor > 0 else float("nan")
    covariance = sigma**2 * (rank.inverse_root @ rank.inverse_root.T)
    free = list(rank.undetermined)
    deficient: FitStatus = "rank_deficient" if free else "ok"
    return LeastSquares(
        status="too_few_rows" if rows <= len(rank.singular_values) else deficient,
        method=method,
        parameters=read_only(_with_nan(solution, free)),
        covariance=read_only(_with_nan(_with_nan(covariance, free).T, free).T),
        solution=read_only(solution),
        weights=read_only(weights),
        sigma_rho=float(sigma),
        sigma_rho_equation=read_only(sigmas),
        residual_norm=read_only(residual_norm),
        y_norm=read_only(np.array([factor.norms[-1] for factor in factors])),
        factors=tuple(factors),
        condition_number_scaled=rank.condition_number,
        rank=rank,
    )


def relative_standard_deviation(parameters: FloatArray, standard_deviations: FloatArray) -> FloatArray:
    """100 sigma_X / |X|, equation [23]; inf for a parameter that is 0.

    >>> import numpy as np
    >>> relative_standard_deviation(np.array([-4.0]), np.array([1.0])).tolist()
    [25.0]
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        return 100.0 * np.asarray(np.divide(standard_deviations, np.abs(parameters)))


def residuals(W: FloatArray, y: FloatArray, fit: LeastSquares) -> FloatArray:
    """rho = y - W X, shape (n_equations, n_samples), in the units of y.

    Parameters
    ----------
    W : array, shape (n_equations, n_samples, n_parameters)
        Observation matrix.
    y : array, shape (n_equations, n_samples)
        Output.
    fit : LeastSquares
        The estimate, whose solution is X.

    Examples
    --------
    >>> import numpy as np
    >>> from symid.estimation.triangular import triangular_factors
    >>> W, y = np.ones((1, 2, 1)), np.array([[0.0, 2.0]])
    >>> residuals(W, y, estimate(triangular_factors(W, y))).round(12).tolist()
    [[-1.0, 1.0]]
    """
    predicted = fit.solution @ W.swapaxes(1, 2)
    return np.subtract(y, predicted, out=predicted)


def _check(factors: Sequence[TriangularFactor], method: str, ddof: int | None) -> None:
    if not factors:
        raise SettingError("no equation to estimate from: give one triangular factor for each equation")
    sizes = sorted({factor.parameters for factor in factors})
    if len(sizes) > 1:
        raise SettingError(f"the equations have {sizes} columns: all must have a column for each parameter")
    if method not in ("ols", "wls"):
        raise SettingError(f"method {method!r} is unknown: choose 'ols' or 'wls'")
    if ddof is not None and ddof < 0:
        raise SettingError(f"ddof is {ddof}: it must be 0 or more")


def _equation_deviations(
    factors: Sequence[TriangularFactor], ranks: Sequence[RankAnalysis], ddof: int | None
) -> tuple[FloatArray, FloatArray]:
    """sigma_rho_j of [25] for each equation, and the level of its rounding errors.

    Alone, a homogeneous equation has the solution 0 and no residual, and one without surplus rows fits exactly. For
    these the residual is that of the joint ordinary solution. It must not be iterated: a larger weight on a homogeneous
    equation would shrink X towards 0, and with it the residual.
    """
    homogeneous = [factor.norms[-1] == 0.0 for factor in factors]
    shared = [h or f.rows <= r.rank for h, f, r in zip(homogeneous, factors, ranks, strict=True)]
    joint = np.zeros(factors[0].parameters)
    if any(shared):
        R = _stacked(factors, np.ones(len(factors)))
        joint = _solve(R, analyse_rank(R[:-1, :-1], sum(factor.rows for factor in factors)))
    sigmas, floors = np.zeros(len(factors)), np.zeros(len(factors))
    for j, (factor, alone) in enumerate(zip(factors, ranks, strict=True)):
        divisor = factor.rows - (alone.rank if ddof is None else ddof)
        (norm,) = _residual_norms([factor], joint if shared[j] else _solve(factor.R, alone))
        sigmas[j] = norm / np.sqrt(max(divisor, 1))
        size = np.append(np.abs(joint), 0.0) if homogeneous[j] else np.append(np.zeros_like(joint), 1.0)
        floors[j] = 10.0 * _EPS * float(factor.norms @ size) / np.sqrt(max(factor.rows, 1))
    return sigmas, floors


def _stacked(factors: Sequence[TriangularFactor], weights: FloatArray) -> FloatArray:
    """R of all equations together; for mixed weights, Householder's QR needs the rows with the largest norms first."""
    rows = [weight * factor.R for weight, factor in zip(weights, factors, strict=True)]
    return rows[0] if len(rows) == 1 else triangle(np.vstack(sorted(rows, key=np.linalg.norm, reverse=True)))


def _solve(R: FloatArray, rank: RankAnalysis) -> FloatArray:
    """Solution of the triangular system; if there are many, the shortest one for columns of unit norm."""
    if rank.rank == len(R) - 1:
        return np.asarray(np.linalg.solve(R[:-1, :-1], R[:-1, -1]))
    root = rank.inverse_root
    solution: FloatArray = root @ ((R[:-1, :-1] @ root).T @ R[:-1, -1])
    return solution


def _residual_norms(factors: Sequence[TriangularFactor], solution: FloatArray) -> FloatArray:
    extended = np.append(solution, -1.0)
    return np.array([math.hypot(*(factor.R @ extended).tolist()) for factor in factors])


def _with_nan(array: FloatArray, undetermined: list[int]) -> FloatArray:
    array = array.copy()
    array[undetermined] = np.nan
    return array


def fit_percent(y: FloatArray, predicted: FloatArray) -> float:
    """Fit of a prediction, 100 (1 - |y - predicted| / |y - mean y|), %: 100 where it is exact, 0 of the mean.

    >>> fit_percent(np.array([0.0, 2.0]), np.array([0.5, 1.5]))
    50.0
    """
    spread = float(np.linalg.norm(y - y.mean())) if y.size else 0.0
    return 100.0 * (1.0 - float(np.linalg.norm(y - predicted)) / spread) if spread else float("nan")
