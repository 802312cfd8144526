"""Nonlinear least squares by damped Gauss-Newton steps, with derivatives by one-sided differences.

Unlike `scipy.optimize.least_squares` it takes a step for each parameter's differences, and lets a residual be
undefined: such a step is shortened.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from symid.arrays import FloatArray
from symid.errors import SymidError

_LARGEST_DAMPING = 1e12  # steps are then below rounding


@dataclass(frozen=True, eq=False)
class Minimum:
    """Last point of the iterations, and whether its step lowered the sum of squares by less than the tolerance."""

    x: FloatArray
    residual: FloatArray
    converged: bool

    @property
    def cost(self) -> float:
        """Sum of squares of the residual."""
        return float(self.residual @ self.residual)


def levenberg_marquardt(
    residual: Callable[[FloatArray], FloatArray],
    start: FloatArray,
    steps: FloatArray,
    *,
    longest: FloatArray | None = None,
    iterations: int = 50,
    tolerance: float = 1e-6,
) -> Minimum:
    """Least squares of a residual of shape (m,) from a start of shape (n,).

    The residual may raise ValueError or LinAlgError where it is undefined, but not at the start. `steps` are those of
    central differences; no argument moves further than `longest` in one iteration. The iterations end where the sum of
    squares falls by less than `tolerance`, relatively.

    >>> found = levenberg_marquardt(lambda x: np.array([x[0] - 3, x[0] * x[1] - 6]), np.ones(2), np.full(2, 1e-6))
    >>> found.x.round(6).tolist()
    [3.0, 2.0]
    """
    x, damping = np.array(start, dtype=float), 1e-3
    current = residual(x)
    for _ in range(iterations):
        slope = _forward_slope(residual, x, current, steps)
        normal, gradient = slope.T @ slope, slope.T @ current
        size = np.sqrt(np.diag(normal))
        size[size == 0] = 1.0
        cost, decrease = current @ current, 0.0
        while damping < _LARGEST_DAMPING:
            # Columns of norm 1 make the damping independent of the units of x (Marquardt's scaling).
            scaled = normal / np.outer(size, size) + damping * np.eye(x.size)
            reach = size * longest if longest is not None else np.full(x.size, np.inf)
            candidate = x + limited_step(scaled, gradient / size, reach) / size
            trial = _tried(residual, candidate)
            if trial is not None and trial @ trial <= cost:
                decrease = float(cost - trial @ trial)
                x, current, damping = candidate, trial, max(damping / 10, 1e-14)
                break
            damping *= 8
        if damping >= _LARGEST_DAMPING or decrease <= tolerance * cost:
            return Minimum(x, current, True)
    return Minimum(x, current, False)


def limited_step(normal: FloatArray, gradient: FloatArray, longest: FloatArray) -> FloatArray:
    """Minimum of step' normal step / 2 + gradient' step with each |step| up to `longest`.

    An argument whose step would be longer is held at its limit, and the step of the others is solved again: an argument
    that hardly matters does not shorten their steps.

    >>> limited_step(np.diag([1.0, 1e-6]), np.array([-0.5, -1.0]), np.full(2, 2.0)).tolist()
    [0.5, 2.0]
    """
    step, free = np.zeros(gradient.size), np.ones(gradient.size, dtype=bool)
    while free.any():
        remaining = gradient[free] + normal[np.ix_(free, ~free)] @ step[~free]
        step[free] = -np.linalg.solve(normal[np.ix_(free, free)], remaining)
        beyond = free & (np.abs(step) > longest)
        if not beyond.any():
            break
        step[beyond] = np.sign(step[beyond]) * longest[beyond]
        free &= ~beyond
    return step


def _forward_slope(
    residual: Callable[[FloatArray], FloatArray], x: FloatArray, current: FloatArray, steps: FloatArray
) -> FloatArray:
    columns = []
    for step, move in zip(steps, np.diag(steps), strict=True):
        ahead = _tried(residual, x + move)
        columns.append((residual(x - move) - current) / -step if ahead is None else (ahead - current) / step)
    return np.stack(columns, axis=1)


def central_slope(
    residual: Callable[[FloatArray], FloatArray], x: FloatArray, steps: FloatArray
) -> FloatArray:
    """Central differences, one-sided at the edge of where the residual is defined."""
    columns = []
    for i, step in enumerate(steps):
        sides = [x + side * step * np.eye(x.size)[i] for side in (1, -1)]
        ahead, behind = (_tried(residual, side) for side in sides)
        if ahead is not None and behind is not None:
            columns.append((ahead - behind) / (2 * step))
        elif ahead is not None:
            columns.append((ahead - residual(x)) / step)
        else:
            columns.append((residual(x) - residual(sides[1])) / step)
    return np.stack(columns, axis=1)


def _tried(residual: Callable[[FloatArray], FloatArray], x: FloatArray) -> FloatArray | None:
    try:
        with np.errstate(all="ignore"):
            found = residual(x)
            is_finite = np.isfinite(found @ found)
    except (SymidError, ValueError, np.linalg.LinAlgError):
        return None
    return found if is_finite else None
