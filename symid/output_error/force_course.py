"""Course of the forces of a log between its samples."""

from typing import Literal

import numpy as np
import scipy

from symid.arrays import FloatArray
from symid.signal_processing import NOISE_FROM, QuinticSpline

Course = Literal["held", "smooth"]
"""Course of the drive force between two samples: held from each to the next, or the smooth one through all values."""

_INTERPOLATION_REACH = 24
"""Samples on either side that the band-limited interpolation of a force uses."""
_RESOLUTION = 300  # parts of the band in each of which a force is separated from its noise


def force_between(
    forces: FloatArray, course: Course, parts: int, late: float
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Forces at the middle of each part of the intervals and at the samples, and the change of both with `late`."""
    n = len(forces)
    if course == "held":
        places = np.arange(n)[:, None] + (np.arange(parts) + 0.5) / parts + late
        held = forces[np.clip(np.floor(places).astype(int), 0, n - 1)]
        before = forces[np.clip(np.ceil(np.arange(n) + late).astype(int) - 1, 0, n - 1)]
        return held, before, np.zeros_like(held), np.zeros_like(before)
    moved = [QuinticSpline(force).earlier(late) if late else force for force in forces.T]
    rates = [_rate(one) for one in moved]
    within, change = ([_upsampled(one, parts) for one in some] for some in (moved, rates))
    return (
        np.stack(within, axis=-1),
        np.stack(moved, axis=-1),
        np.stack(change, axis=-1),
        np.stack(rates, axis=-1),
    )


def _rate(force: FloatArray) -> FloatArray:
    """Change of a force from sample to sample, without its white noise (Wiener's filter).

    Noise in the derivative would count as information on the timing, and bias the delay towards zero.

    >>> k = np.arange(4000)
    >>> noise = np.random.default_rng(0).standard_normal(k.size)
    >>> error = _rate(100 * np.sin(0.05 * k) + noise) - 5 * np.cos(0.05 * k)
    >>> bool(np.std(error) < 0.3 * np.std(np.gradient(noise)))
    True
    """
    line = np.linspace(force[0], force[-1], force.size)  # without it the ends would be a jump
    spectrum = scipy.fft.rfft(force - line)
    power = scipy.ndimage.uniform_filter1d(np.abs(spectrum) ** 2, 2 * (force.size // _RESOLUTION) + 5)
    floor = np.median(power[int(2 * NOISE_FROM * power.size) :])
    kept = 1.0 - np.divide(floor, power, out=np.ones_like(power), where=power > floor)
    pace = 2j * np.pi * scipy.fft.rfftfreq(force.size)
    return np.asarray(scipy.fft.irfft(pace * kept * spectrum, force.size) + (line[1] - line[0]))


def _upsampled(values: FloatArray, parts: int) -> FloatArray:
    """Band-limited course of a signal at the middle of each part of the interval after each sample."""
    n, fine = values.size, 2 * parts
    taps = scipy.signal.firwin(2 * fine * _INTERPOLATION_REACH + 1, 1 / fine, window=("kaiser", 8.0))
    edge = min(2 * _INTERPOLATION_REACH, n - 1)
    extended = np.pad(values, edge, mode="reflect", reflect_type="odd")
    first = (_INTERPOLATION_REACH + edge) * fine
    fine_course = scipy.signal.upfirdn(fine * taps, extended, up=fine)[first : first + n * fine]
    return np.asarray(fine_course).reshape(n, fine)[:, 1::2]
