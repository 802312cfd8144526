"""How rows are made of recorded signals: as the paper does it, and a sharper way to compare it with."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from symid.arrays import FloatArray
from symid.data import central_difference


@dataclass(frozen=True)
class Scheme:
    """How derivatives and the values of nonlinear laws are made.

    Parameters
    ----------
    difference : callable
        From a vector of samples and the sampling period, s, to the first derivative at each sample; higher ones are
        taken one after the other.
    reach : int
        Samples on either side that it needs.
    widening : float
        Motion is filtered at so many times the cutoff before the model is sampled; if that is more than 1, all columns
        are filtered at the cutoff afterwards. Reversals then stay where they were in the laws that jump there.
    """

    difference: Callable[[FloatArray, float], FloatArray]
    reach: int
    widening: float = 1.0


def sharp_difference(x: FloatArray, sampling_period: float) -> FloatArray:
    """First derivative by the central difference over seven samples, of order 6; by that over three at the ends.

    At the angular frequency w it gives 1 - (w T)^6/140 of the derivative, where the central difference over three
    samples gives 1 - (w T)^2/6.

    Parameters
    ----------
    x : array of shape (n_samples,)
        Signal.
    sampling_period : float
        Time between two samples, s.

    Examples
    --------
    >>> import numpy as np
    >>> sharp_difference(np.arange(9.0) ** 5, 1.0)[4].item() == 5 * 4**4
    True
    """
    slope = central_difference(x, sampling_period)
    if x.size > 6:
        near, middle, far = (x[3 + k : x.size - 3 + k] - x[3 - k : x.size - 3 - k] for k in (1, 2, 3))
        slope[3:-3] = (45.0 * near - 9.0 * middle + far) / (60.0 * sampling_period)
    return slope


PAPER = Scheme(central_difference, reach=1)
SHARP = Scheme(sharp_difference, reach=3, widening=4.0)
