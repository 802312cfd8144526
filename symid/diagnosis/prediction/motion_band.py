"""The highest frequency of the motion in a log, and the noise of readings and forces above it."""

import numpy as np
import scipy

from symid.arrays import FloatArray
from symid.diagnosis.prediction.quantisation import rounding_error
from symid.signal_processing import NOISE_FROM, incoherent_density, power_density

WIDEST = 0.3
"""Share of the sampling frequency up to which motion may reach."""
_HIGHEST = 0.4
"""Share of the sampling frequency up to which spectra are examined: differences and means distort them beyond."""
_ABOVE_NOISE = 3.0
_RISES = 3.0
_WIDTH_OF_LINES = 9
_QUARTER = 2**0.125
_FEWEST_BINS = 8
_TINY = 1e-300
_SEGMENT = 4096
_SEGMENTS = 8
"""Least number of segments, without overlap, of a coherence."""
_BINS_OF_MOTION = 5
"""Number of neighbouring frequencies, most of which must exceed the noise where the axis moves."""


def motion_band(position: FloatArray, sampling_frequency: float) -> float:
    """Frequency at which the motion falls to the noise of its reading: the minimum of the acceleration density.

    The acceleration of a machine falls with frequency; the second derivative of noise rises up to the end of the
    spectrum. If a reading is too smooth for such a minimum, motion ends where its spectrum falls to the level at the
    end. In a coarse reading it ends where the spectrum falls to that of the rounding error.
    """
    if (error := rounding_error(position)) is not None:
        frequency, rounding = _density(error, sampling_frequency)
        sunk = _last_octave_above(_density(position, sampling_frequency)[1] / (rounding + _TINY))
        return _within(frequency, sunk, sampling_frequency)
    frequency, density = _density(np.diff(position), sampling_frequency)
    density = density / (4 * np.sin(np.pi * frequency / sampling_frequency) ** 2 + 1e-30)
    without_lines = scipy.ndimage.median_filter(density * frequency**4, _WIDTH_OF_LINES)
    end = _least_from_above(_smoothed(without_lines)[frequency < _HIGHEST * sampling_frequency])
    if end is None:
        floor = np.median(density[frequency > NOISE_FROM * sampling_frequency])
        stands_out = scipy.ndimage.median_filter(density, _BINS_OF_MOTION) > _ABOVE_NOISE * floor
        end = int(np.flatnonzero(stands_out).max(initial=0))
    return _within(frequency, end, sampling_frequency)


def _last_octave_above(ratio: FloatArray) -> int:
    """Middle of the first octave whose median does not exceed the noise; single lines of rounding still may."""
    middle = float(_FEWEST_BINS)
    while 2**0.5 * middle < ratio.size:
        octave = ratio[int(middle / 2**0.5) : int(middle * 2**0.5) + 1]
        if np.median(octave) < _ABOVE_NOISE:
            break
        middle *= _QUARTER
    return min(int(middle), ratio.size - 1)


def _within(frequency: FloatArray, end: int, sampling_frequency: float) -> float:
    return float(np.clip(frequency[end], 8 * frequency[1], WIDEST * sampling_frequency))


def _least_from_above(acceleration: FloatArray) -> int | None:
    """First minimum of a density, searched from its end downwards; None if the density does not fall there."""
    least = np.minimum.accumulate(acceleration[::-1])[::-1]
    rises = np.flatnonzero(acceleration > _RISES * least)
    beyond = int(rises.max(initial=0)) + 1
    if beyond >= acceleration.size:
        return None
    end = beyond + int(np.argmin(acceleration[beyond:]))
    return end if acceleration[end:].max() > _RISES * acceleration[end] else None


def _smoothed(density: FloatArray) -> FloatArray:
    """Mean over a quarter of an octave."""
    sums = np.concatenate([[0.0], np.cumsum(density)])
    at = np.arange(density.size)
    low = np.minimum((at / _QUARTER).astype(int), np.maximum(at - 1, 0))
    high = np.minimum((at * _QUARTER).astype(int) + 2, density.size)
    return np.asarray((sums[high] - sums[low]) / (high - low))


def noise_beyond(x: FloatArray, sampling_frequency: float, end_hz: float) -> float:
    """Standard deviation of white noise with the density of a reading beyond its motion.

    The lower of two octaves counts: motion may reach into the first. Further up, filters of the sensor take noise away.
    """
    frequency, density = _density(x, sampling_frequency)
    levels = []
    for low in (end_hz, 2 * end_hz):
        octave = (frequency > low) & (frequency < 2 * low)
        if octave.sum() >= _FEWEST_BINS:
            levels.append(float(np.median(density[octave])))
    level = min(levels, default=float(np.median(density[-_FEWEST_BINS:])))
    return float(np.sqrt(max(level * sampling_frequency / 2, np.finfo(float).tiny)))


def force_noise(
    force: FloatArray, positions: FloatArray, sampling_frequency: float, above_hz: float
) -> float:
    """Standard deviation of white noise with the least density of a force within the octave beyond a frequency.

    The lower of two densities counts: that of the force, and that of its part incoherent with the accelerations, whose
    spectra are as flat, from shorter segments.
    """
    segment = min(_SEGMENT, force.size // _SEGMENTS)
    densities = (
        _density(force, sampling_frequency),
        incoherent_density(force[1:-1], np.diff(positions, 2), sampling_frequency, segment),
    )
    least = min(_least_beyond(above_hz, *density) for density in densities)
    return float(np.sqrt(max(least * sampling_frequency / 2, np.finfo(float).tiny)))


def _least_beyond(above_hz: float, frequency: FloatArray, density: FloatArray) -> float:
    """Least moving average of a density in the octave above a frequency."""
    beyond = density[(frequency > above_hz) & (frequency < 2 * above_hz)]
    if beyond.size < 4:
        beyond = density[-8:]
    width = max(4, beyond.size // 6)
    return float(np.convolve(beyond, np.ones(width) / width, "valid").min())


def _density(x: FloatArray, sampling_frequency: float) -> tuple[FloatArray, FloatArray]:
    return power_density(x, sampling_frequency, min(_SEGMENT, x.size // 4))
