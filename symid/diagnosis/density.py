"""Power density of a signal by Welch's method.

It does what `scipy.signal.welch` does by default, whose import takes as long as the diagnosis of a rigid axis.
"""

from __future__ import annotations

import numpy as np
import scipy.fft

from symid.arrays import FloatArray


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
    window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(segment) / segment)
    parts = np.lib.stride_tricks.sliding_window_view(x, segment)[:: segment - segment // 2]
    spectra = scipy.fft.rfft((parts - parts.mean(axis=1, keepdims=True)) * window)
    density = np.mean(np.abs(spectra) ** 2, axis=0) / (sampling_frequency * np.sum(window**2))
    density[1 : None if segment % 2 else -1] *= 2
    return np.asarray(np.fft.rfftfreq(segment, 1 / sampling_frequency)), np.asarray(density)
