"""Least deviations of the parameters of the paper's axis by any estimator without bias, computed densely."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, signal

FloatArray = NDArray[np.float64]


def responses(p: Mapping[str, float], n: int, period: float) -> tuple[FloatArray, FloatArray]:
    """Position after a force held over one interval, and after each initial state, without Coulomb friction."""
    Ms, Fvs, Ks, Mm, Fvm = (p[name] for name in ("Ms", "Fvs", "Ks", "Mm", "Fvm"))
    generator = np.zeros((5, 5))  # q1, q2, their speeds, force: [3] and [4] of the paper
    generator[0, 2] = generator[1, 3] = 1.0
    generator[2] = [-Ks / Ms, 0.0, -Fvs / Ms, Fvm / Ms, -1 / Ms]
    generator[3] = [Ks / Ms, 0.0, Fvs / Ms, -Fvm * (1 / Ms + 1 / Mm), 1 / Ms + 1 / Mm]
    whole = linalg.expm(generator * period)
    impulse, free, state = np.zeros(n), np.zeros((n, 4)), np.eye(4)
    for k in range(n):
        free[k] = state[1]
        impulse[k] = state[1] @ whole[:4, 4]
        state = whole[:4, :4] @ state
    return impulse, free


def moments(
    p: Mapping[str, float], force: FloatArray, noise: FloatArray, period: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Mean and covariance of the second differences of the readings, and the effect of the initial state on them.

    The logged force is held, and white noise adds to it. Differences hold the same information, as the rigid motion's
    first state is unknown; without them the covariance is that of a random walk, beyond the reach of 16 digits.
    """
    n, twice = force.size, np.array([1.0, -2.0, 1.0])
    impulse, free = responses(p, n, period)
    first = signal.lfilter(twice, 1.0, np.append(0.0, impulse[:-1]))
    covariance = np.outer(first, first)  # G G', G being lower triangular and Toeplitz
    for k in range(1, n):
        covariance[k, 1:] += covariance[k - 1, :-1]
    read = linalg.toeplitz(np.concatenate([[6.0, -4.0, 1.0], np.zeros(n - 5)]))
    mean = signal.lfilter(first, 1.0, force)
    return mean[2:], noise[0] ** 2 * covariance[2:, 2:] + noise[1] ** 2 * read, np.diff(free, 2, axis=0)


def cramer_rao(
    truth: Mapping[str, float], force: FloatArray, noise: tuple[float, float], period: float
) -> dict[str, float]:
    """Least standard deviations in percent; initial state and both noise levels are unknown too."""
    names = [name for name, value in truth.items() if value]
    levels = np.array(noise)
    _, S, free = moments(truth, force, levels, period)
    factor = linalg.cholesky(S, lower=True)
    slopes: list[FloatArray] = []
    spreads: list[FloatArray] = []
    for i in range(len(names) + 2):
        sides = []
        for step in (1e-4, -1e-4):
            moved, loud = dict(truth), levels.copy()
            if i < len(names):
                moved[names[i]] *= 1 + step
            else:
                loud[i - len(names)] *= 1 + step
            sides.append(moments(moved, force, loud, period))
        slopes.append(linalg.solve_triangular(factor, (sides[0][0] - sides[1][0]) / 2e-4, lower=True))
        change = linalg.solve_triangular(factor, (sides[0][1] - sides[1][1]) / 2e-4, lower=True)
        spreads.append(linalg.solve_triangular(factor, change.T, lower=True))
    white = linalg.solve_triangular(factor, free, lower=True)
    start = linalg.orth(white / np.maximum(np.linalg.norm(white, axis=0), 1e-9), rcond=1e-6)
    means = np.stack(slopes, axis=1)
    means -= start @ (start.T @ means)
    information = means.T @ means
    information += 0.5 * np.array([[np.sum(a * b) for b in spreads] for a in spreads])
    bound = np.sqrt(np.diag(np.linalg.inv(information)))
    return {name: 100 * float(std) for name, std in zip(names, bound, strict=False)}
