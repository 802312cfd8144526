"""Reversals of a velocity, with the corners that it has there, and the samples near them.

Dry friction changes its sign at a reversal, so that the acceleration jumps and the velocity has a corner. In a limited
band the corner is rounded, and the velocity crosses zero late at every reversal.
"""

from typing import NamedTuple

import numpy as np
import scipy

from symid.arrays import BoolArray, FloatArray, IntArray

_BEYOND, _WIDTH = 0.5, 1.0
"""Distance from a reversal, and length of the spans on either side that show the acceleration, in periods of the
highest frequency: over a whole period, the ringing of a step averages out."""
_REACH = 3.0
"""Distance up to which a rounded corner is sharpened, in the same periods."""
_SURE = 4.0
"""Deviations by which the mean jump has to differ from zero."""
_FEWEST = 4
_RESOLVED = 0.2
"""Change of the acceleration within a span, relative to the jump, up to which the jump stands out of the motion."""

SLOW = 0.002
"""Speed, relative to the highest, below which an axis counts as standing."""
_NEAR = 0.05
"""Seconds before and after a reversal that count as near."""


class Reversals(NamedTuple):
    """A velocity, the points after which it changes sign, and the share of the step at which it does."""

    velocity: FloatArray
    before: IntArray
    passed: FloatArray


def reversals_of(velocity: FloatArray) -> Reversals:
    """Reversals of a velocity by linear interpolation."""
    before = np.flatnonzero(np.signbit(velocity[:-1]) != np.signbit(velocity[1:]))
    return Reversals(velocity, before, velocity[before] / (velocity[before] - velocity[before + 1]))


def with_corners(velocity: FloatArray, highest: float, moving: BoolArray) -> Reversals:
    """A velocity that was cut off at a frequency, in rad per point, with the corners that its reversals have.

    `moving` are the points with more than noise; where the axis rests between two motions, it does not reverse.

    The jump of acceleration J has the same size at all reversals, against the motion that begins: it is the mean
    difference of the accelerations behind and before them. A corner |t| J/2 that is cut off at w is too high by
    J/pi r(w t)/w with r(x) = cos x - x (pi/2 - Si x), which is the error of the velocity near the reversal.
    """
    rounded = reversals_of(velocity)
    period = 2 * np.pi / highest
    quick = round((_BEYOND + _WIDTH) * period)
    fast = _apart(rounded, quick)
    fast[fast] = moving[rounded.before[fast] - quick] & moving[rounded.before[fast] + quick]
    clear = fast & _apart(rounded, quick + round(_WIDTH * period) + 1)
    if clear.sum() < _FEWEST:
        return rounded
    jumps, changes = _jumps(velocity, rounded.before[clear], period)
    jump = float(np.mean(jumps))
    is_sure = jump > _SURE * float(np.std(jumps, ddof=1)) / np.sqrt(jumps.size)
    if not is_sure or abs(float(np.mean(changes))) > _RESOLVED * jump:
        return rounded
    before, towards = rounded.before[fast], _towards(velocity, rounded.before[fast])
    # where the rounded velocity takes the height of the rounded corner instead of zero
    off = -towards * jump / (np.pi * highest)
    points = np.arange(-round(_REACH * period), 2)
    near = (velocity[before[:, None] + points] - off[:, None]) * towards[:, None]
    last = near.shape[1] - 1 - np.argmax(near[:, ::-1] < 0, axis=1)
    found = np.take_along_axis(near, np.stack([last, np.minimum(last + 1, points.size - 1)], axis=1), axis=1)
    crossed = (found[:, 0] < 0) & (found[:, 1] >= 0)
    before, off, found = (before + points[last])[crossed], off[crossed], found[crossed]
    passed = found[:, 0] / (found[:, 0] - found[:, 1])
    around = np.arange(-round(_REACH * period), round(_REACH * period) + 1)
    distance = highest * np.abs(around - passed[:, None])
    sharpened = velocity.copy()
    places = (before[:, None] + around) % velocity.size  # a record is periodic
    np.subtract.at(sharpened, places, off[:, None] * _rounding(distance))
    sharp = reversals_of(sharpened)
    _, at, own = np.intersect1d(sharp.before, before, return_indices=True)
    sharp.passed[at] = passed[own]
    return sharp


def _apart(found: Reversals, reach: int) -> BoolArray:
    """Which reversals have no other one, and no end, within reach."""
    ends = np.concatenate([[0], found.before, [found.velocity.size - 1]])
    apart = np.diff(ends)
    return np.asarray(np.minimum(apart[:-1], apart[1:]) > reach)


def _towards(velocity: FloatArray, before: IntArray) -> FloatArray:
    """Direction of the motion that begins at each reversal."""
    return np.where(velocity[before + 1] > 0, 1.0, -1.0)


def _jumps(velocity: FloatArray, before: IntArray, period: float) -> tuple[FloatArray, FloatArray]:
    """Acceleration before each reversal less that behind it, along the motion that begins there.

    Both are extrapolated to the reversal from two spans, between which their difference changes as returned second.
    """
    first, width = round(_BEYOND * period), max(round(_WIDTH * period), 1)

    def difference(nearest: int) -> FloatArray:
        ahead = velocity[before - nearest] - velocity[before - nearest - width]
        behind = velocity[before + 1 + nearest + width] - velocity[before + 1 + nearest]
        return np.asarray(_towards(velocity, before) * (ahead - behind) / width)

    near, far = difference(first), difference(first + width)
    return 2 * near - far, far - near


def _rounding(x: FloatArray) -> FloatArray:
    """r of `with_corners`."""
    return np.asarray(np.cos(x) - x * (np.pi / 2 - scipy.special.sici(x)[0]))


def near_reversals(turns: BoolArray, rate: float, around: float = _NEAR) -> BoolArray:
    """Samples within some time, s, of those at which the axis turns or stands; `rate` in Hz.

    >>> near_reversals(np.array([True, False, False, False]), 20.0).tolist()
    [True, True, False, False]
    """
    if not turns.any():
        return np.zeros(turns.size, dtype=bool)
    return np.asarray(scipy.ndimage.distance_transform_edt(~turns) / rate <= around)
