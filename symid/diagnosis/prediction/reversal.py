"""Samples near a reversal or a standstill, where friction and backlash show."""

import numpy as np
import scipy

from symid.arrays import BoolArray

SLOW = 0.002
"""Speed, relative to the highest, below which an axis counts as standing."""
_AROUND = 0.05
"""Seconds before and after a reversal that count as near."""


def near(turns: BoolArray, rate: float, around: float = _AROUND) -> BoolArray:
    """Samples within some time, s, of those at which the axis turns or stands; `rate` in Hz.

    >>> near(np.array([True, False, False, False]), 20.0).tolist()
    [True, True, False, False]
    """
    if not turns.any():
        return np.zeros(turns.size, dtype=bool)
    return np.asarray(scipy.ndimage.distance_transform_edt(~turns) / rate <= around)
