"""Physical from minimal parameters: the inverse map with its branches, fitted where it is overdetermined.

The physical parameters theta minimise (X - X(theta))' C^-1 (X - X(theta)), C being the covariance of the estimated
minimal parameters X. Their covariance is (J' C^-1 J)^-1 with J = dX/dtheta. Where there are as many of one kind as
of the other this is the exact inverse map with propagated deviations; where there are more minimal parameters, the
minimum itself is a test of the structure: it follows a chi-square distribution if the model is right.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import scipy

from symid.arrays import BoolArray, FloatArray
from symid.codegen import GeneratedModel
from symid.identification.parameters.starts import starts

_RANK = 1e-9
"""Singular value of the scaled sensitivity, relative to the largest, below which a direction is not determined."""
_PART = 1e-6
"""Share in an undetermined direction above which a parameter is not determined either."""
_STEP = 1e-30
"""Complex step: the forward map is rational, so its derivative is exact to rounding."""


@dataclass(frozen=True, eq=False)
class PhysicalEstimate:
    """Physical parameters of one branch of the inverse map."""

    parameters: FloatArray
    """Values in the order of the declaration; nan for those that the sensors do not see; shape (n_physical,)."""
    sensitivity: FloatArray
    """Derivatives of these estimates by the minimal parameters; shape (n_physical, n_minimal)."""
    covariance: FloatArray
    """Propagated to first order from the covariance of the minimal parameters; shape (n_physical, n_physical)."""
    relations: int
    """Number of relations between the minimal parameters that the structure demands."""
    disagreement: float
    """Chi-square of these relations; nan without any."""
    restricted: Restricted | None = None
    """Changes by bounds and priors; None without them."""

    @property
    def standard_deviations(self) -> FloatArray:
        """Standard deviations of the parameters, shape (n_physical,)."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    def propagated(self, covariance: FloatArray) -> FloatArray:
        """Covariance that another one of the minimal parameters would give, shape (n_physical, n_physical)."""
        by_log = np.asarray(self.sensitivity @ covariance @ self.sensitivity.T)
        return by_log + self.restricted.by_prior if self.restricted else by_log

    def propagated_deviations(self, covariance: FloatArray) -> FloatArray:
        """Standard deviations that another covariance of the minimal parameters would give, shape (n_physical,)."""
        return np.asarray(np.sqrt(np.diag(self.propagated(covariance))))

    @property
    def disagreement_probability(self) -> float:
        """Probability of a disagreement as large as this if the structure is right; nan without relations."""
        return (
            float(scipy.special.chdtrc(self.relations, self.disagreement)) if self.relations else float("nan")
        )

    def negative(self, model: GeneratedModel) -> tuple[str, ...]:
        """Negative parameters that must not be negative."""
        return negative_parameters(model, self.parameters)


@dataclass(frozen=True, eq=False)
class Restricted:
    """Effect of bounds and priors on an estimate and on its covariance.

    `held` gives, for each parameter at a bound, what the bound costs, as a chi-square; `priors` gives mean and
    deviation of the priors.
    """

    free: PhysicalEstimate
    by_prior: FloatArray
    held: Mapping[int, float]
    priors: Mapping[int, tuple[float, float]] = field(default_factory=dict)

    @property
    def instead(self) -> dict[int, tuple[float, float]]:
        """Priors of parameters that the log alone leaves open."""
        return {i: prior for i, prior in self.priors.items() if np.isnan(self.free.parameters[i])}


def negative_parameters(model: GeneratedModel, physical: FloatArray) -> tuple[str, ...]:
    """Physical parameters negative against the declaration, whatever their deviations, which mean "not determined"."""
    below = zip(model.physical_units, physical < 0.0, strict=True)
    return tuple(name for name, is_below in below if is_below and name not in model.signed)


def jacobian(model: GeneratedModel, physical: FloatArray) -> FloatArray:
    """Derivatives of the minimal by the physical parameters, of shape (n_minimal, n_physical)."""
    columns = []
    for i, value in enumerate(physical):
        step = _STEP * max(abs(value), 1.0)
        shifted = physical.astype(complex)
        shifted[i] += 1j * step
        columns.append(model.minimal_parameters(*shifted).imag / step)
    return np.stack(columns, axis=1)


@dataclass(frozen=True, eq=False)
class WhitenedMap:
    """Minimal parameters of physical ones less those estimated, in deviations and uncorrelated."""

    model: GeneratedModel
    minimal: FloatArray  # the estimate
    spread: FloatArray  # its deviations
    root: FloatArray  # Cholesky factor of its correlation matrix

    @classmethod
    def of(cls, model: GeneratedModel, minimal: FloatArray, covariance: FloatArray) -> WhitenedMap | None:
        """The map by the covariance of an estimate; None if that cannot be inverted."""
        spread = np.sqrt(np.diag(covariance))
        spread = np.where(spread > 0, spread, np.maximum(np.abs(minimal), 1.0) * np.finfo(float).eps)
        root = _root(covariance, spread)
        return None if root is None else cls(model, minimal, spread, root)

    @property
    def whitening(self) -> FloatArray:
        """Matrix that whitens differences of minimal parameters."""
        return np.asarray(np.linalg.solve(self.root, np.diag(1 / self.spread)))

    def residual(self, physical: FloatArray) -> FloatArray:
        """Differences of the minimal parameters, shape (n_minimal,)."""
        differences = self.model.minimal_parameters(*physical) - self.minimal
        return np.asarray(np.linalg.solve(self.root, differences / self.spread))

    def slope(self, physical: FloatArray) -> FloatArray:
        """Their derivatives by the physical parameters, shape (n_minimal, n_physical)."""
        return np.asarray(np.linalg.solve(self.root, jacobian(self.model, physical) / self.spread[:, None]))


def open_directions(slope: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Determined directions of a sensitivity, scaled by their deviations, and flags of undetermined columns.

    >>> open_directions(np.array([[1.0, -1.0, 0.0], [0.0, 0.0, 2.0]]))[1].tolist()
    [True, True, False]
    """
    _, sizes, axes = np.linalg.svd(slope, full_matrices=True)
    sizes = np.append(sizes, np.zeros(axes.shape[0] - sizes.size))
    determined = sizes > _RANK * sizes[0]
    return axes[determined] / sizes[determined, None], np.any(np.abs(axes[~determined]) > _PART, axis=0)


def open_by_structure(*models: GeneratedModel) -> tuple[str, ...]:
    """Parameters that no log of these signals determines, judged at a generic point of all parameters.

    Several models of the same parameters, whose known values differ, are judged together.
    """
    names = list(models[0].physical_units)
    generic = np.exp(np.random.default_rng(0).normal(size=len(names)))
    rows = np.vstack([jacobian(model, generic) for model in models]) * generic
    size = np.max(np.abs(rows), axis=1, keepdims=True)
    is_open = open_directions(rows / np.where(size > 0.0, size, 1.0))[1]
    return tuple(name for name, it in zip(names, is_open, strict=True) if it)


def physical_estimates(
    model: GeneratedModel,
    minimal: FloatArray,
    covariance: FloatArray,
    start: Mapping[str, float] | None = None,
) -> tuple[PhysicalEstimate, ...]:
    """Physical parameters of estimated minimal ones, one record for each branch, physically possible ones first.

    Parameters
    ----------
    model : GeneratedModel
        Holds the maps.
    minimal : array of shape (n_minimal,)
        Estimated minimal parameters, all finite.
    covariance : array of shape (n_minimal, n_minimal)
        Their covariance.
    start : mapping of str to float, optional
        Nominal values, where the inverse map has no closed form; searched for without them.

    Returns
    -------
    tuple of PhysicalEstimate
        Empty if no start leads to a determined solution.
    """
    names = list(model.physical_units)
    guesses: list[FloatArray] = []
    if model.physical_parameters is not None:
        with np.errstate(all="ignore"):
            guesses += [
                model.physical_parameters(*minimal, branch=branch) for branch in range(model.branches)
            ]
    elif start is not None and all(name in start for name in names):
        guesses.append(np.array([start[name] for name in names], dtype=float))
    elif len(names) <= minimal.size:
        signed = np.array([name in model.signed for name in names])
        deviations = np.sqrt(np.diag(covariance))
        guesses += starts(lambda p: model.minimal_parameters(*p), minimal, deviations, signed)
    found = [_fitted(model, minimal, covariance, guess) for guess in guesses]
    estimates = [estimate for estimate in found if estimate is not None]
    estimates.sort(key=lambda e: (len(e.negative(model)), np.nan_to_num(e.disagreement)))
    return tuple(_distinct(estimates))


def _fitted(
    model: GeneratedModel, minimal: FloatArray, covariance: FloatArray, start: FloatArray
) -> PhysicalEstimate | None:
    """Weighted fit from a start, in parameters scaled by it; those that start as nan are not seen and stay so."""
    seen = np.isfinite(start)
    guess = start[seen]
    if guess.size > minimal.size:
        return None  # fewer minimal parameters than physical ones: no start leads to a single solution
    scale = np.where(guess == 0, 1.0, np.abs(guess))
    white = WhitenedMap.of(model, minimal, covariance)
    if white is None:
        return None

    def whole(relative: FloatArray) -> FloatArray:
        physical = np.zeros(start.size)
        physical[seen] = relative * scale
        return physical

    def weighted_residuals(relative: FloatArray) -> FloatArray:
        return white.residual(whole(relative))

    def slope(relative: FloatArray) -> FloatArray:
        return white.slope(whole(relative))[:, seen] * scale

    relations = minimal.size - guess.size
    exact = relations == 0 and model.physical_parameters is not None
    with np.errstate(all="ignore"):
        begin = np.column_stack([weighted_residuals(guess / scale), slope(guess / scale)])
        if not np.all(np.isfinite(begin)):
            return None
        relative = (
            guess / scale
            if exact
            else scipy.optimize.least_squares(weighted_residuals, guess / scale, jac=slope, method="lm").x
        )
        gradient = slope(relative)
    orthonormal, triangle = np.linalg.qr(gradient)
    if not np.all(np.isfinite(triangle)) or np.linalg.cond(triangle) > 1 / np.finfo(float).eps:
        return None
    disagreement = float(np.sum(weighted_residuals(relative) ** 2)) if relations else float("nan")
    parameters, sensitivity = np.full(start.size, np.nan), np.full((start.size, minimal.size), np.nan)
    parameters[seen] = relative * scale
    sensitivity[seen] = scale[:, None] * np.linalg.solve(triangle, orthonormal.T @ white.whitening)
    return PhysicalEstimate(
        parameters, sensitivity, sensitivity @ covariance @ sensitivity.T, relations, disagreement
    )


def _root(covariance: FloatArray, spread: FloatArray) -> FloatArray | None:
    """Cholesky factor of the correlation matrix; one that is singular to rounding (noise-free logs) gets a ridge."""
    correlation = covariance / np.outer(spread, spread)
    np.fill_diagonal(correlation, 1.0)
    for ridge in (0.0, 1e-10):
        try:
            return np.asarray(np.linalg.cholesky(correlation + ridge * np.eye(spread.size)))
        except np.linalg.LinAlgError:
            continue
    return None


def _distinct(estimates: list[PhysicalEstimate]) -> list[PhysicalEstimate]:
    """Estimates without repetitions: two starts may lead to the same minimum."""
    kept: list[PhysicalEstimate] = []
    for estimate in estimates:
        if not any(
            np.allclose(estimate.parameters, other.parameters, rtol=1e-6, equal_nan=True) for other in kept
        ):
            kept.append(estimate)
    return kept
