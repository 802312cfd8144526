"""Noise of coarse readings, whose rounding error is not white.

At constant speed, the error of a reading in steps is a sawtooth of frequency speed / step; near a reversal it changes
slowly. Its spectrum follows from rounding the motion itself, with zero at several points between two steps.
"""

import numpy as np

from symid.arrays import FloatArray
from symid.data.quality import step_of
from symid.signal_processing import power_density

_PLACES = (0.125, 0.375, 0.625, 0.875)
"""Assumed positions of zero between two steps, in steps; the densities are averaged over them."""
_STANDS_OUT = 2.0
"""Multiple of the white density above which the rounding error has a line; estimates scatter below it."""
_SEGMENT, _SEGMENTS = 4096, 4
_RETURNS = 0.1
"""Largest share of steps followed by a step back; with noise of the sensor it is a half."""
_FEWEST_STEPS = 200
_FINE, _BLURRED = 0.4, 1.5
"""Share of the samples with values of their own, and third differences relative to those of rounding, beyond which a
reading has noise of its sensor that blurs its steps."""
_ROUGHNESS = (20 / 12) ** 0.5
"""Root mean square of the third differences of rounding to steps of 1."""


def quantisation_lines(
    step: float, motion: FloatArray, sampling_frequency: float, noise: float, frequency: FloatArray
) -> FloatArray:
    """Density of the noise of a reading relative to white noise, of shape (n_frequencies,); 1 without lines.

    `motion` is the part of the reading in the band of the motion; `noise` the standard deviation of white noise with
    the density of the reading beyond it.

    >>> t = np.arange(8000) / 1000
    >>> path = 0.3 * t  # 30 steps a second
    >>> lines = quantisation_lines(0.01, path, 1000.0, 1e-4, np.array([30.0, 45.0]))
    >>> bool(lines[0] > 100.0 * lines[1])
    True
    """
    # Noise beyond that of rounding comes from the sensor and blurs the lines.
    blur = np.sqrt(max(noise**2 - step**2 / 12, 0.0)) * np.random.default_rng(0).standard_normal(motion.size)
    segment = min(_SEGMENT, motion.size // _SEGMENTS)
    densities = []
    for place in _PLACES:
        course = motion + place * step
        error = np.round((course + blur) / step) * step - course
        grid, density = power_density(error, sampling_frequency, segment)
        densities.append(density)
    relative = np.mean(densities, axis=0) / (2 * noise**2 / sampling_frequency)
    found = np.interp(frequency, grid, np.where(relative > _STANDS_OUT, relative, 1.0))
    return np.asarray(found)


def rounding_error(x: FloatArray) -> FloatArray | None:
    """Estimated rounding error of a reading whose steps are not blurred by noise; None for any other reading.

    Between two changes of the reading the motion is interpolated linearly, from half a step to half a step. Where the
    reading changes at every sample, the error is drawn uniformly.

    >>> path = 0.2 * np.sin(np.arange(4000) / 300)
    >>> error = rounding_error(np.round(path / 0.001) * 0.001)
    >>> bool(abs(error.std() * 12**0.5 / 0.001 - 1.0) < 0.2), rounding_error(path) is None
    (True, True)
    """
    step = step_of(x)
    changed = np.flatnonzero(np.diff(x)) if step > 0.0 else np.zeros(0, dtype=np.intp)
    if changed.size < _FEWEST_STEPS:
        return None
    way = np.sign(np.diff(x)[changed])
    if np.mean(way[1:] != way[:-1]) > _RETURNS:
        return None
    course = np.interp(np.arange(x.size), changed + 0.5, (x[changed] + x[changed + 1]) / 2)
    moving = np.diff(x) != 0.0
    fast = np.concatenate([[False], moving]) & np.concatenate([moving, [False]])
    even = np.random.default_rng(0).uniform(-step / 2, step / 2, x.size)
    # Noise of the sensor shows by steps back, or if values hardly recur, by third differences that no motion has.
    roughness = float(np.sqrt(np.mean(np.diff(x, 3) ** 2)))
    if np.unique(x).size > _FINE * x.size and roughness > _BLURRED * step * _ROUGHNESS:
        return None
    return np.where(fast, even, x - course)
