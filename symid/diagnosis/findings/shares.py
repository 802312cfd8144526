"""Shares of a gap, with intervals from resampled blocks of rows."""

import numpy as np

from symid.arrays import FloatArray
from symid.diagnosis.findings.gap import Removed

_BLOCKS = 24  # of rows, drawn as wholes, since neighbouring errors are correlated
_DRAWS = 400  # of blocks with replacement
_SIDES = (0.025, 0.975)  # quantiles of a 95 % interval


def closed_fraction(before: FloatArray, after: FloatArray, floor: float = 1.0) -> float:
    """Fraction of the rms above the noise that is removed between two errors; nan if the first is only noise."""
    first, last = np.sqrt(np.mean(before)), np.sqrt(np.mean(after))
    return float(min((first - last) / (first - floor), 1.0)) if first > floor * (1 + 1e-6) else float("nan")


def _drawn(squares: FloatArray) -> FloatArray:
    """Means of squares, given as (n, n_rows), over blocks of rows drawn with replacement; shape (n_draws, n)."""
    blocks = np.array_split(np.arange(squares.shape[1]), _BLOCKS)
    means = np.array([squares[:, b].mean(axis=1) for b in blocks if b.size])
    rng = np.random.default_rng(0)
    return np.asarray(means[rng.integers(len(means), size=(_DRAWS, len(means)))].mean(axis=1))


def surely_decreases(before: FloatArray, after: FloatArray) -> bool:
    """Whether squares are smaller after than before in 97.5 % of resampled blocks of rows.

    The difference shows this even if the excess is in a few blocks that some draws do not contain.

    >>> ramp = np.linspace(1.0, 2.0, 240)
    >>> surely_decreases(ramp, 0.9 * ramp), surely_decreases(ramp, ramp[::-1])
    (True, False)
    """
    drawn = _drawn(np.stack([before, after]))
    return bool(np.quantile(drawn[:, 0] - drawn[:, 1], _SIDES[0]) > 0)


def closed_interval(before: FloatArray, after: FloatArray, floor: float) -> tuple[float, float]:
    """95 % interval of the closed fraction from resampled blocks of rows."""
    drawn = _drawn(np.stack([before, after]))
    found = [closed_fraction(np.array([b]), np.array([a]), floor) for b, a in drawn]
    finite = [x for x in found if np.isfinite(x)]
    if len(finite) < _DRAWS // 2:
        return float("nan"), float("nan")
    low, high = np.quantile(finite, _SIDES)
    return float(low), float(high)


def removed_share(squares: FloatArray, floor: float) -> Removed:
    """Decrease from the second to the third mean square, relative to the first one above the floor."""

    def share(means: FloatArray) -> FloatArray:
        excess = np.maximum(means - floor, 0.0)
        return np.asarray((excess[..., 1] - excess[..., 2]) / np.maximum(excess[..., 0], 1e-12))

    if not np.all(np.isfinite(squares)):
        return Removed(float("nan"), float("nan"), float("nan"))
    low, high = np.quantile(share(_drawn(squares)), _SIDES)
    return Removed(float(share(squares.mean(axis=1))), float(low), float(high))
