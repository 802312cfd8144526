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
Status: TypeAlias = Literal["ok", "rank_deficient", "too_few_rows"]

_EPS = float(np.finfo(np.float64).eps)


@dataclass(frozen=True)
class LeastSquares:
    """Parameters of least residual, with all that is needed to judge them. Arrays are read-only.

    Attributes
    ----------
    status : str
        "ok"; "rank_deficient": some parameters are not determined; "too_few_rows": no row is left over to
        estimate the residual's deviation from, so that there are no standard deviations.
    method : str
        "ols" [20] or "wls" [26]; "iv" for an estimate by instrumental variables that began as one of these.
    parameters : array, shape (n_parameters,)
        In the caller's units; nan where not determined.
    covariance : array, shape (n_parameters, n_parameters)
        Classical covariance [22]; nan where not determined.
    solution : array, shape (n_parameters,)
        A solution without nan. Where parameters are not determined, one of many with the same residual.
    weights : array, shape (n_equations,)
        S_j = 1/sigma_rho_j, or 1 for "ols".
    sigma_rho : float
        Deviation of the residual of the system that was solved: in units of y for "ols", near 1 for "wls".
    sigma_rho_equation : array, shape (n_equations,)
        sigma_rho_j of [25], of each equation by itself; of a homogeneous one in the joint ordinary solution.
    residual_norm, y_norm : array, shape (n_equations,)
        Norms of the unweighted residual and of y of each equation.
    rows : tuple of int
        Rows of each equation.
    condition_number : float
        2-norm condition of the unweighted W in the caller's units.
    condition_number_scaled : float
        The same of the system that was solved, with columns of unit norm.
    rank : RankAnalysis
        Which parameters, and which combinations of the others, are determined.
    combination_values, combination_covariance : array, shape (n_combinations,) and its square
        Value and covariance of `rank.combinations`.
    """

    status: Status
    method: Method | Literal["iv"]
    parameters: FloatArray
    covariance: FloatArray
    solution: FloatArray
    weights: FloatArray
    sigma_rho: float
    sigma_rho_equation: FloatArray
    residual_norm: FloatArray
    y_norm: FloatArray
    rows: tuple[int, ...]
    condition_number: float
    condition_number_scaled: float
    rank: RankAnalysis
    combination_values: FloatArray
    combination_covariance: FloatArray

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
        """Parameters that the rows do not determine."""
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
        Weighted with 1/sigma_rho_j of each equation by itself [24]-[30], or with 1 [20]-[22].
    ddof : int, optional
        What is subtracted from the number of rows in the divisor of sigma_rho; the number of parameters (the
        rank, if lower) by default. Published figures sometimes use 1.

    Returns
    -------
    LeastSquares
        Its status and values state rank deficiency, too few rows and exact fits.

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
    weights = np.ones(len(factors)) if method == "ols" else _weights(sigmas, floors)
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
    combinations = rank.combinations
    free = list(rank.undetermined)
    return LeastSquares(
        status=_status(rows, rank),
        method=method,
        parameters=read_only(_with_nan(solution, free)),
        covariance=read_only(_with_nan(_with_nan(covariance, free).T, free).T),
        solution=read_only(solution),
        weights=read_only(weights),
        sigma_rho=float(sigma),
        sigma_rho_equation=read_only(sigmas),
        residual_norm=read_only(residual_norm),
        y_norm=read_only(np.array([factor.norms[-1] for factor in factors])),
        rows=tuple(factor.rows for factor in factors),
        condition_number=_unscaled_condition(factors),
        condition_number_scaled=rank.condition_number,
        rank=rank,
        combination_values=read_only(combinations @ solution),
        combination_covariance=read_only(combinations @ covariance @ combinations.T),
    )


def relative_standard_deviation(parameters: FloatArray, standard_deviations: FloatArray) -> FloatArray:
    """Return 100 sigma_X / |X| in percent, equation [23]; inf for a parameter that is 0.

    Parameters
    ----------
    parameters, standard_deviations : array
        Of the same shape and units.

    Examples
    --------
    >>> import numpy as np
    >>> relative_standard_deviation(np.array([-4.0]), np.array([1.0])).tolist()
    [25.0]
    """
    return 100.0 * _ratio(standard_deviations, np.abs(parameters))


def residuals(W: FloatArray, y: FloatArray, fit: LeastSquares) -> FloatArray:
    """Return rho = y - W X, shape (n_equations, n_samples), in the units of y.

    Examples
    --------
    >>> import numpy as np
    >>> from symid.estimation.triangular import triangular_factors
    >>> W, y = np.ones((1, 2, 1)), np.array([[0.0, 2.0]])
    >>> residuals(W, y, estimate(triangular_factors(W, y))).round(12).tolist()
    [[-1.0, 1.0]]
    """
    return np.stack([y[j] - (fit.solution @ W[j].T) for j in range(len(W))])


def _check(factors: Sequence[TriangularFactor], method: str, ddof: int | None) -> None:
    if not factors:
        raise SettingError("no equation to estimate from; give one triangular factor for each equation")
    sizes = sorted({factor.parameters for factor in factors})
    if len(sizes) > 1:
        raise SettingError(f"the equations have {sizes} columns; all must have a column for each parameter")
    if method not in ("ols", "wls"):
        raise SettingError(f"method {method!r} is unknown; choose 'ols' or 'wls'")
    if ddof is not None and ddof < 0:
        raise SettingError(f"ddof is {ddof}; it must be 0 or more")


def _equation_deviations(
    factors: Sequence[TriangularFactor], ranks: Sequence[RankAnalysis], ddof: int | None
) -> tuple[FloatArray, FloatArray]:
    """sigma_rho_j of [25] for each equation, and the level below which it is only rounding.

    By itself a homogeneous equation has the solution 0 and no residual, and one with no row to spare fits
    exactly: for these the residual is that of the joint ordinary solution. It must not be iterated: a larger
    weight on a homogeneous equation draws X to 0, which makes its residual smaller still.
    """
    homogeneous = [factor.norms[-1] == 0.0 for factor in factors]
    shared = [h or f.rows <= r.rank for h, f, r in zip(homogeneous, factors, ranks, strict=True)]
    joint = _joint(factors) if any(shared) else np.zeros(factors[0].parameters)
    sigmas, floors = np.zeros(len(factors)), np.zeros(len(factors))
    for j, (factor, alone) in enumerate(zip(factors, ranks, strict=True)):
        divisor = factor.rows - (alone.rank if ddof is None else ddof)
        (norm,) = _residual_norms([factor], joint if shared[j] else _solve(factor.R, alone))
        sigmas[j] = norm / np.sqrt(max(divisor, 1))
        size = np.append(np.abs(joint), 0.0) if homogeneous[j] else np.append(np.zeros_like(joint), 1.0)
        floors[j] = 10.0 * _EPS * float(factor.norms @ size) / np.sqrt(max(factor.rows, 1))
    return sigmas, floors


def _joint(factors: Sequence[TriangularFactor]) -> FloatArray:
    """Ordinary solution of all equations together."""
    R = _stacked(factors, np.ones(len(factors)))
    return _solve(R, analyse_rank(R[:-1, :-1], sum(factor.rows for factor in factors)))


def _weights(sigmas: FloatArray, floors: FloatArray) -> FloatArray:
    """S_j = 1/sigma_rho_j, an exact fit counting as rounding; 1 for an equation without information."""
    levels = np.maximum(sigmas, floors)
    return 1.0 / np.where(levels > 0.0, levels, 1.0)


def _stacked(factors: Sequence[TriangularFactor], weights: FloatArray) -> FloatArray:
    """R of all equations together, the heaviest rows first, as Householder's QR needs for mixed weights."""
    rows = [weight * factor.R for weight, factor in zip(weights, factors, strict=True)]
    return rows[0] if len(rows) == 1 else triangle(np.vstack(sorted(rows, key=np.linalg.norm, reverse=True)))


def _solve(R: FloatArray, rank: RankAnalysis) -> FloatArray:
    """Solution of the triangular system; the shortest one on columns of unit norm if there are many."""
    if rank.rank == len(R) - 1:
        return np.asarray(np.linalg.solve(R[:-1, :-1], R[:-1, -1]))
    root = rank.inverse_root
    solution: FloatArray = root @ ((R[:-1, :-1] @ root).T @ R[:-1, -1])
    return solution


def _residual_norms(factors: Sequence[TriangularFactor], solution: FloatArray) -> FloatArray:
    extended = np.append(solution, -1.0)
    return np.array([math.hypot(*(factor.R @ extended).tolist()) for factor in factors])


def _unscaled_condition(factors: Sequence[TriangularFactor]) -> float:
    R = _stacked(factors, np.ones(len(factors)))[:-1, :-1]
    return condition_number(np.asarray(np.linalg.svd(R, compute_uv=False), dtype=np.float64))


def _status(rows: int, rank: RankAnalysis) -> Status:
    if rows <= len(rank.singular_values):
        return "too_few_rows"
    return "ok" if not rank.undetermined else "rank_deficient"


def _with_nan(array: FloatArray, undetermined: list[int]) -> FloatArray:
    array = array.copy()
    array[undetermined] = np.nan
    return array


def _ratio(numerator: FloatArray, denominator: FloatArray) -> FloatArray:
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.divide(numerator, denominator))
