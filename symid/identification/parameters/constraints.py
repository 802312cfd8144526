"""Prior knowledge of physical parameters: bounds that they keep, and priors with a deviation.

With X the estimated minimal parameters, C their covariance, m and s the means and deviations of the priors, the
parameters theta minimise

    (X - X(theta))' C^-1 (X - X(theta)) + sum_i ((theta_i - m_i) / s_i)^2   within their bounds.

Their covariance is (J' C^-1 J + P)^-1 with P the diagonal of 1/s^2, for those that are not held at a bound: the
posterior of normal priors and a normal estimate (A. Tarantola, Inverse Problem Theory, SIAM 2005, section 3.2). What a
bound costs is how much the minimum falls without it, a chi-square of one degree of freedom.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import scipy

from symid.arrays import BoolArray, FloatArray
from symid.codegen import GeneratedModel
from symid.errors import SettingError
from symid.files import is_finite_number, shortened
from symid.identification.parameters.physical import (
    PhysicalEstimate,
    Restricted,
    WhitenedMap,
    open_directions,
)

Bounds = Mapping[str, tuple[float | None, float | None]]
Priors = Mapping[str, tuple[float, float]]

_AT_BOUND = 1e-7
"""Distance from a bound, in deviations or relative to the value, that counts as zero."""


_SHARPEST, _SMALLEST = 1e-13, 1e-100
"""Least relative and absolute deviation of a prior: its inverse square must not overflow."""


@dataclass(frozen=True)
class Constraints:
    """Bounds and priors of physical parameters, SI."""

    bounds: Bounds = field(default_factory=dict)
    """Lowest and highest value; None for no bound."""
    prior: Priors = field(default_factory=dict)
    """Mean and standard deviation of the prior."""

    def __bool__(self) -> bool:
        return bool(self.bounds or self.prior)

    @classmethod
    def of(cls, model: GeneratedModel, bounds: Bounds | str | None, prior: Priors | None) -> Constraints:
        """Checked constraints of a model; ``bounds="physical"`` keeps all that must not be negative from being so.

        SettingError if a parameter is not one of the model, or a value is not possible.
        """
        if isinstance(bounds, str):
            if bounds != "physical":
                raise SettingError(
                    f"bounds {bounds!r} are not known: give 'physical', or low and high by parameter"
                )
            bounds = {name: (0.0, None) for name in model.physical_units if name not in model.signed}
        given = cls(
            {name: _pair(name, value, "bounds", "low and high") for name, value in (bounds or {}).items()},
            {name: _prior(name, value) for name, value in (prior or {}).items()},
        )
        for name in (*given.bounds, *given.prior):
            if name not in model.physical_units:
                known = " (its value is known)" if name in model.known else ""
                raise SettingError(
                    f"{name!r} is not an unknown parameter of axis {model.axis!r}{known}: "
                    f"choose from {', '.join(model.physical_units)}"
                )
        for name, (low, high) in given.bounds.items():
            if low is not None and high is not None and not low < high:
                raise SettingError(f"bounds of {name}: {low:g} is not below {high:g}")
        highest = {name: high for name, (_, high) in given.bounds.items() if high is not None}
        for name, value in (*highest.items(), *((name, mean) for name, (mean, _) in given.prior.items())):
            if value < 0 and name not in model.signed:
                claim = "bounds say" if name in highest else "prior says"
                raise SettingError(
                    f"{name} is at least 0 by its declaration, and its {claim} {value:g}: give SI values above 0"
                )
        return given

    def ranges(self, names: Sequence[str]) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest values of parameters, infinite without a bound."""
        pairs = [self.bounds.get(name, (None, None)) for name in names]
        low = [-np.inf if pair[0] is None else pair[0] for pair in pairs]
        high = [np.inf if pair[1] is None else pair[1] for pair in pairs]
        return np.array(low, dtype=float), np.array(high, dtype=float)

    def means(self, names: Sequence[str]) -> tuple[FloatArray, FloatArray]:
        """Means of priors, 0 without one, and the inverse of their deviations, 0 without one."""
        pairs = [self.prior.get(name, (0.0, math.inf)) for name in names]
        return np.array([mean for mean, _ in pairs]), np.array([1 / deviation for _, deviation in pairs])


def _pair(name: str, value: object, what: str, meaning: str) -> tuple[float | None, float | None]:
    fits = isinstance(value, (tuple, list)) and len(value) == 2
    if not (fits and all(one is None or is_finite_number(one) for one in value)):  # type: ignore[attr-defined]
        raise SettingError(
            f"{what} of {name} are {shortened(value)}: give a pair of numbers, {meaning}, in SI units"
        )
    pair: tuple[float | None, float | None] = (value[0], value[1])  # type: ignore[index]
    return None if pair[0] is None else float(pair[0]), None if pair[1] is None else float(pair[1])


def _prior(name: str, value: object) -> tuple[float, float]:
    mean, deviation = _pair(name, value, "mean and deviation of the prior", "mean and deviation")
    if mean is None or deviation is None or deviation <= 0:
        raise SettingError(
            f"the prior of {name} is {shortened(value)}: give its mean and a deviation above 0, in SI units"
        )
    if deviation < max(_SHARPEST * abs(mean), _SMALLEST):
        raise SettingError(
            f"the prior of {name} has a deviation of {deviation:g}, finer than numbers are: give the value as known "
            f"(`fixed` {name}={mean:g})"
        )
    return mean, deviation


def constrained_estimates(
    model: GeneratedModel,
    minimal: FloatArray,
    covariance: FloatArray,
    free: Iterable[PhysicalEstimate],
    constraints: Constraints,
) -> tuple[PhysicalEstimate, ...]:
    """Physical parameters under constraints, one for each branch of the unconstrained ones, the likeliest first."""
    white, names = WhitenedMap.of(model, minimal, covariance), list(model.physical_units)
    if white is None:
        return ()
    problem = _Problem(white, *constraints.ranges(names), *constraints.means(names))
    found = [(problem.solved(branch), branch) for branch in free]
    found.sort(key=lambda pair: problem.cost(pair[0][0]))
    return tuple(problem.estimate(branch, *solution) for solution, branch in found)


@dataclass(frozen=True, eq=False)
class _Problem:
    """The weighted least squares problem in the physical parameters."""

    white: WhitenedMap
    low: FloatArray
    high: FloatArray
    mean: FloatArray
    precision: FloatArray

    def residual(self, theta: FloatArray) -> FloatArray:
        """Residual of the estimate and of the priors, in deviations; not finite where a divisor is at a bound of 0."""
        with np.errstate(all="ignore"):
            return np.concatenate([self.white.residual(theta), self.precision * (theta - self.mean)])

    def slope(self, theta: FloatArray) -> FloatArray:
        """Derivatives of the residual."""
        return np.vstack([self.white.slope(theta), np.diag(self.precision)])

    def cost(self, theta: FloatArray) -> float:
        """Sum of squares of the estimate and the priors."""
        return float(np.sum(self.residual(theta) ** 2))

    def solved(self, free: PhysicalEstimate) -> tuple[FloatArray, tuple[int, ...]]:
        """Parameters of least cost within the bounds, and which of them are held at one."""
        deviation, begun = free.standard_deviations, self._begun(free.parameters)
        unit = np.where(deviation > 0, deviation, np.maximum(np.abs(begun), 1e-12))
        theta = self._within(begun, unit, self.low, self.high)
        near = _AT_BOUND * np.maximum(unit, np.abs(theta))
        at_low, at_high = theta - self.low <= near, self.high - theta <= near
        force = -2 * self.slope(theta).T @ self.residual(theta)  # points where the cost falls
        held = np.flatnonzero((at_low & (force < 0)) | (at_high & (force > 0)))
        theta[held] = np.where(at_low, self.low, self.high)[held]
        return theta, tuple(map(int, held))

    def _begun(self, free: FloatArray) -> FloatArray:
        """Values to begin with: those that the log does not determine from their prior, or within their bounds."""
        within = np.clip(np.where(self.precision > 0, self.mean, 1.0), self.low, self.high)
        return np.asarray(np.where(np.isfinite(free), free, within))

    def _within(self, start: FloatArray, unit: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
        def residual(x: FloatArray) -> FloatArray:
            return self.residual(x * unit)

        def slope(x: FloatArray) -> FloatArray:
            return self.slope(x * unit) * unit

        # scipy wants its start inside: a hair of the unit, or of the range
        inner = np.minimum(1e-6 * unit, 0.25 * (high - low))
        found = scipy.optimize.least_squares(
            residual,
            np.clip(start, low + inner, high - inner) / unit,
            jac=slope,
            bounds=(low / unit, high / unit),
            xtol=1e-14,
            ftol=1e-14,
            gtol=1e-14,
        )
        return np.asarray(found.x * unit)

    def estimate(self, free: PhysicalEstimate, theta: FloatArray, held: tuple[int, ...]) -> PhysicalEstimate:
        """Values with their posterior covariance; those that are held have none, those that stay open are nan."""
        scale = np.where(theta == 0, 1.0, np.abs(theta))
        still_open = np.flatnonzero(
            open_directions(self.slope(theta) * scale)[1] & ~np.isfinite(free.parameters)
        )
        loose = np.setdiff1d(np.arange(theta.size), (*held, *still_open))
        theta = self._polished(theta, loose)
        slope, data = self.slope(theta)[:, loose], self.white.minimal.size
        inverse = np.linalg.pinv(slope)
        sensitivity, by_prior = np.zeros((theta.size, data)), np.zeros((theta.size, theta.size))
        sensitivity[loose] = inverse[:, :data] @ self.white.whitening
        by_prior[loose] = inverse[:, data:]
        covariance = np.zeros((theta.size, theta.size))
        covariance[np.ix_(loose, loose)] = inverse @ inverse.T
        costs = {i: self._cost_of_bound(free, theta, i) for i in held if i not in still_open}
        by_log = free
        if free.restricted is not None:  # priors stand in for what the log leaves open
            by_log = _alone(free, open_directions(self.slope(theta)[:data] * scale)[1])
        theta = theta.copy()
        theta[still_open] = sensitivity[still_open] = covariance[still_open] = covariance[:, still_open] = (
            np.nan
        )
        return replace(
            free,
            parameters=theta,
            sensitivity=sensitivity,
            covariance=covariance,
            restricted=Restricted(
                free=by_log,
                by_prior=by_prior @ by_prior.T,
                held=costs,
                priors={
                    int(i): (float(self.mean[i]), float(1 / self.precision[i]))
                    for i in np.flatnonzero(self.precision > 0)
                },
            ),
        )

    def _polished(self, theta: FloatArray, loose: FloatArray) -> FloatArray:
        """One Gauss-Newton step in the free parameters, clipped to the bounds; no step if the cost would rise."""
        step = np.zeros(theta.size)
        step[loose] = -np.linalg.pinv(self.slope(theta)[:, loose]) @ self.residual(theta)
        moved = np.clip(theta + step, self.low, self.high)
        return moved if self.cost(moved) <= self.cost(theta) else theta

    def _cost_of_bound(self, free: PhysicalEstimate, theta: FloatArray, i: int) -> float:
        """Decrease of the cost if the bound of one parameter is removed."""
        unit = np.fmax(free.standard_deviations, 1e-12 * np.fmax(np.abs(theta), 1e-300))
        low, high = self.low.copy(), self.high.copy()
        low[i], high[i] = -np.inf, np.inf
        return max(self.cost(theta) - self.cost(self._within(theta, unit, low, high)), 0.0)


def _alone(free: PhysicalEstimate, is_open: BoolArray) -> PhysicalEstimate:
    """Information of the log alone: none on the parameters that it does not determine."""
    closed = np.where(is_open, np.nan, 1.0)
    return replace(
        free,
        parameters=free.parameters * closed,
        sensitivity=free.sensitivity * closed[:, None],
        covariance=free.covariance * np.outer(closed, closed),
        restricted=None,
    )
