"""Power densities of signals by Welch's method.

It does what `scipy.signal.welch` does by default, whose import takes as long as the diagnosis of a rigid axis.
"""

from __future__ import annotations

import numpy as np
import scipy.fft

from symid.arrays import ComplexArray, FloatArray


def power_density(x: FloatArray, sampling_frequency: float, segment: int) -> tuple[FloatArray, FloatArray]:
    """One-sided power density: means of periodograms of Hann-weighted segments that overlap by half.

    Parameters
    ----------
    x : array of shape (n,)
        Samples; n at least `segment`.
    sampling_frequency : float
        Hz.
    segment : int
        Samples of a segment.

    Returns
    -------
    tuple of array of shape (segment // 2 + 1,)
        Frequencies in Hz and densities in the square of the signal's unit per Hz (P. D. Welch, 1967).

    Examples
    --------
    >>> frequency, density = power_density(np.sin(2 * np.pi * 50 * np.arange(4000) / 1000), 1000.0, 500)
    >>> float(frequency[density.argmax()]), round(float(density.sum() * frequency[1]), 3)
    (50.0, 0.5)
    """
    density = np.mean(np.abs(_spectra(x, segment)) ** 2, axis=0)
    return _scaled(density, sampling_frequency, segment)


def incoherent_density(
    x: FloatArray, y: FloatArray, sampling_frequency: float, segment: int
) -> tuple[FloatArray, FloatArray]:
    """One-sided power density of what no linear filter makes of another signal: (1 - coherence) times the density.

    Parameters
    ----------
    x, y : array of shape (n,)
        Samples of the signal and of the other one; n at least twice `segment`.
    sampling_frequency : float
        Hz.
    segment : int
        Samples of a segment.

    Returns
    -------
    tuple of array of shape (segment // 2 + 1,)
        Frequencies in Hz and densities in the square of the unit of `x` per Hz, corrected for the share that any
        signal takes from an estimate by so few segments (J. S. Bendat, A. G. Piersol, Random Data, section 9.2).

    Examples
    --------
    >>> noise = np.random.default_rng(0).standard_normal((2, 20_000))
    >>> y = noise[0]  # a filter that takes a part of a segment would lower the coherence
    >>> x = 3.0 * y + 0.1 * noise[1]
    >>> _, density = incoherent_density(x, y, 1.0, 256)
    >>> bool(0.009 < density[1:-1].mean() / 2 < 0.011)
    True
    """
    of_x, of_y = _spectra(x, segment), _spectra(y, segment)
    cross = np.abs(np.mean(of_x * of_y.conj(), axis=0)) ** 2
    other = np.mean(np.abs(of_y) ** 2, axis=0)
    shared = np.divide(cross, other, out=np.zeros_like(cross), where=other > 0)
    left = np.maximum(np.mean(np.abs(of_x) ** 2, axis=0) - shared, 0.0)
    return _scaled(left * (len(of_x) / max(len(of_x) - 1, 1)), sampling_frequency, segment)


def _spectra(x: FloatArray, segment: int) -> ComplexArray:
    """Spectra of Hann-weighted segments without their means, of shape (n_segments, segment // 2 + 1)."""
    parts = np.lib.stride_tricks.sliding_window_view(x, segment)[:: segment - segment // 2]
    return np.asarray(scipy.fft.rfft((parts - parts.mean(axis=1, keepdims=True)) * _hann(segment)))


def _scaled(density: FloatArray, sampling_frequency: float, segment: int) -> tuple[FloatArray, FloatArray]:
    """Frequencies and one-sided densities from mean squares of spectra."""
    density = density / (sampling_frequency * np.sum(_hann(segment) ** 2))
    density[1 : None if segment % 2 else -1] *= 2
    return np.asarray(np.fft.rfftfreq(segment, 1 / sampling_frequency)), np.asarray(density)


def _hann(segment: int) -> FloatArray:
    return np.asarray(0.5 - 0.5 * np.cos(2 * np.pi * np.arange(segment) / segment))
