"""Physical parameters within their bounds and beside their priors.

With X the estimated minimal parameters, C their covariance, m and s the means and deviations of the priors, the
parameters theta minimise

    (X - X(theta))' C^-1 (X - X(theta)) + sum_i ((theta_i - m_i) / s_i)^2   within their bounds.

Their covariance is (J' C^-1 J + P)^-1 with P the diagonal of 1/s^2: the posterior of normal priors and a normal
estimate (A. Tarantola, Inverse Problem Theory, SIAM 2005, section 3.2). What a bound costs is how much the minimum
falls without it, a chi-square of one degree of freedom. The posterior of a parameter that is held at a bound is the
tail of a normal one; the root mean square of its distance from the bound is its deviation, from which P follows.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np
import scipy

from symid.arrays import BoolArray, FloatArray
from symid.codegen import GeneratedModel
from symid.identification.parameters.constraints import Constraints
from symid.identification.parameters.inseparable import estimates_by_priors
from symid.identification.parameters.physical import (
    PhysicalEstimate,
    Restricted,
    WhitenedMap,
    open_directions,
    physical_estimates,
)

_AT_BOUND = 1e-7
"""Distance from a bound, in deviations or relative to the value, that counts as zero."""


_FAR = 1e3
"""Distance in deviations from which the tail of a normal distribution is that of an exponential one."""


def physical_of(
    model: GeneratedModel,
    minimal: FloatArray,
    covariance: FloatArray,
    nominal: Mapping[str, float] | None = None,
    constraints: Constraints | None = None,
) -> tuple[PhysicalEstimate, ...]:
    """Physical parameters of minimal ones as `physical_estimates`, under constraints where there are any."""
    found = physical_estimates(model, minimal, covariance, nominal)
    if not constraints:
        return found
    found = found or estimates_by_priors(model, minimal, covariance, constraints, nominal)
    return constrained_estimates(model, minimal, covariance, found, constraints) or found


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
        """Values with their posterior covariance; those that stay open are nan."""
        scale = np.where(theta == 0, 1.0, np.abs(theta))
        still_open = np.flatnonzero(
            open_directions(self.slope(theta) * scale)[1] & ~np.isfinite(free.parameters)
        )
        loose = np.setdiff1d(np.arange(theta.size), (*held, *still_open))
        theta = self._polished(theta, loose)
        costs = {i: self._cost_of_bound(free, theta, i) for i in held if i not in still_open}
        closed = np.union1d(loose, list(costs)).astype(int)
        slope, data = self.slope(theta), self.white.minimal.size
        inverse = np.linalg.pinv(np.vstack([slope, self._of_bounds(slope, loose, costs)])[:, closed])
        sensitivity, by_prior = np.zeros((theta.size, data)), np.zeros((theta.size, inverse.shape[1] - data))
        sensitivity[closed] = inverse[:, :data] @ self.white.whitening
        by_prior[closed] = inverse[:, data:]
        covariance = np.zeros((theta.size, theta.size))
        covariance[np.ix_(closed, closed)] = inverse @ inverse.T
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

    def _of_bounds(self, slope: FloatArray, loose: FloatArray, costs: Mapping[int, float]) -> FloatArray:
        """Rows of priors whose deviations are those of the parameters at bounds, by the costs of these."""
        rows = np.zeros((len(costs), slope.shape[1]))
        for row, (i, cost) in zip(rows, costs.items(), strict=True):
            inverse = np.linalg.pinv(slope[:, [*loose, i]])
            information = 1 / float(inverse[-1] @ inverse[-1])  # without the bound
            row[i] = math.sqrt(information * (1 / _tail(math.sqrt(cost)) - 1))
        return rows

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


def _tail(distance: float) -> float:
    """Mean square beyond a bound of a normal distribution with mean so far before it, both in deviations.

    >>> [round(_tail(distance), 4) for distance in (0.0, 1.0, 3.0)]
    [1.0, 0.4749, 0.1507]
    """
    if distance > _FAR:
        return 2 / distance**2
    hazard = math.sqrt(2 / math.pi) / float(scipy.special.erfcx(distance / math.sqrt(2)))
    return 1 + distance * (distance - hazard)


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
