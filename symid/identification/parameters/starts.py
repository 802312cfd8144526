"""Start values of a search for physical parameters without a closed inverse map and without nominal values.

Minimal parameters are sums and quotients of products of masses, stiffnesses, dampings and frictions. The logarithm of a
product is linear in the logarithms of its factors, and that of a sum of products convex (S. Boyd et al., A tutorial on
geometric programming, Optimization and Engineering 8, 2007), so that logarithms are matched from far away.
"""

import math
from collections.abc import Callable, Iterator

import numpy as np
import scipy

from symid.arrays import BoolArray, FloatArray

Forward = Callable[[FloatArray], FloatArray]
_TRIES = 8
_DECADES = 3.0
"""Standard deviation of the starts of the starts."""
_STEPS = 400  # evaluations


def starts(
    forward: Forward, minimal: FloatArray, deviations: FloatArray, signed: BoolArray
) -> Iterator[FloatArray]:
    """Physical parameters to start from: their minimal parameters match the estimated logarithms, best match first.

    Physical parameters that are `signed` may be negative; they begin at 0.

    >>> def forward(p):
    ...     return np.array([p[0] + p[1], p[0] / p[1], p[0] * p[1]])
    >>> first = next(starts(forward, forward(np.array([2e5, 3.0])), np.full(3, 1e-9), np.zeros(2, dtype=bool)))
    >>> first.round(3).tolist()
    [200000.0, 3.0]
    """
    draw = np.random.default_rng(0)
    spread = _DECADES * math.log(10.0)

    def mismatch(x: FloatArray) -> FloatArray:
        return _mismatch(forward(_values(x, signed)), minimal, deviations)

    found = []
    for attempt in range(_TRIES):
        guess = draw.normal(scale=spread, size=signed.size) if attempt else np.zeros(signed.size)
        with np.errstate(all="ignore"):
            matched = scipy.optimize.least_squares(mismatch, np.where(signed, 0.0, guess), max_nfev=_STEPS)
        if np.isfinite(matched.cost):
            found.append((float(matched.cost), _values(matched.x, signed)))
    for _, values in sorted(found, key=lambda one: one[0]):
        yield values


def _values(x: FloatArray, signed: BoolArray) -> FloatArray:
    return np.where(signed, x, np.exp(np.clip(np.where(signed, 0.0, x), -80.0, 80.0)))


def _mismatch(found: FloatArray, minimal: FloatArray, deviations: FloatArray) -> FloatArray:
    """Differences of the logarithms; a minimal parameter of the other sign, or lost in its deviation, hardly counts."""
    size = np.maximum(np.abs(minimal), deviations)
    weight = np.abs(minimal) / (np.abs(minimal) + deviations)
    ratio = found / np.where(minimal < 0, -size, size)
    logarithm = np.where(ratio > 0, np.log(np.abs(ratio) + 1e-300), np.log1p(np.abs(ratio)) + 3.0)
    return np.nan_to_num(weight * logarithm, nan=1e3, posinf=1e3, neginf=-1e3)
