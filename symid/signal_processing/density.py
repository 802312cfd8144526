"""Power densities of signals by Welch's method.

It does what `scipy.signal.welch` does by default, whose import takes as long as the diagnosis of a rigid axis.
"""

from functools import lru_cache

import numpy as np

from symid.arrays import ComplexArray, FloatArray

NOISE_FROM = 0.35
"""Share of the sampling frequency above which a log is taken as noise only: an axis moves too little there."""


def power_density(x: FloatArray, sampling_frequency: float, segment: int) -> tuple[FloatArray, FloatArray]:
    """Frequencies in Hz and one-sided power density of `x`, of shape (segment // 2 + 1,): Welch's method.

    Means of periodograms of Hann-weighted segments that overlap by half (P. D. Welch, 1967).

    >>> frequency, density = power_density(np.sin(2 * np.pi * 50 * np.arange(4000) / 1000), 1000.0, 500)
    >>> float(frequency[density.argmax()]), round(float(density.sum() * frequency[1]), 3)
    (50.0, 0.5)
    """
    return density_of(segment_spectra(x, segment), sampling_frequency, segment)


def density_of(
    spectra: ComplexArray, sampling_frequency: float, segment: int
) -> tuple[FloatArray, FloatArray]:
    """Result of `power_density`, from the spectra of the segments."""
    return _scaled(mean_power(spectra), sampling_frequency, segment)


def incoherent_density(
    x: FloatArray, others: FloatArray, sampling_frequency: float, segment: int
) -> tuple[FloatArray, FloatArray]:
    """Frequencies in Hz and one-sided power density of the part of `x` that no linear filter makes of other signals.

    (1 - coherence) times the density, corrected for the share that any signals take from an estimate by few segments
    (J. S. Bendat, A. G. Piersol, Random Data, section 9.2); `x` has at least twice `segment` samples.

    >>> noise = np.random.default_rng(0).standard_normal((2, 20_000))
    >>> y = noise[0]  # a filter that takes a part of a segment would lower the coherence
    >>> x = 3.0 * y + 0.1 * noise[1]
    >>> _, density = incoherent_density(x, y[None], 1.0, 256)
    >>> bool(0.009 < density[1:-1].mean() / 2 < 0.011)
    True
    """
    of_others = np.stack([segment_spectra(y, segment) for y in others])
    return incoherent_density_of(segment_spectra(x, segment), of_others, sampling_frequency, segment)


def incoherent_density_of(
    spectra: ComplexArray, others: ComplexArray, sampling_frequency: float, segment: int
) -> tuple[FloatArray, FloatArray]:
    """Result of `incoherent_density`, from the spectra of the segments."""
    explained = explained_power(spectra, others)
    left = np.maximum(mean_power(spectra) - explained, 0.0)
    n_segments = len(spectra)
    return _scaled(left * (n_segments / max(n_segments - len(others), 1)), sampling_frequency, segment)


def segment_spectra(x: FloatArray, segment: int) -> ComplexArray:
    """Spectra of Hann-weighted segments that overlap by half, without their means.

    The samples are stretches of time, one a row, of at least a segment each; the segments of all rows follow each other
    in the result, of shape (n_segments, segment // 2 + 1).
    """
    step = segment - segment // 2
    shape = (*x.shape[:-1], (x.shape[-1] - segment) // step + 1, segment)
    strides = (*x.strides[:-1], step * x.strides[-1], x.strides[-1])
    segments = np.lib.stride_tricks.as_strided(x, shape, strides, writeable=False)
    level = segments - segments.mean(axis=-1, keepdims=True)
    level *= _hann(segment)
    return np.asarray(np.fft.rfft(level, axis=-1).reshape(-1, segment // 2 + 1))


def mean_power(spectra: ComplexArray) -> FloatArray:
    """Mean square of spectra of shape (n_segments, n_frequencies) at each frequency."""
    parts = spectra.view(np.float64)
    squares = np.einsum("sf,sf->f", parts, parts) / len(spectra)
    return np.asarray(squares[0::2] + squares[1::2])


def explained_power(spectra: ComplexArray, others: ComplexArray) -> FloatArray:
    """Part of the mean power of a signal that is linear in other ones; over the power it is the multiple coherence.

    The spectra are of shape (n_segments, n_frequencies), those of the others of shape (n_others, n_segments,
    n_frequencies).
    """
    cross = np.mean(others.conj() * spectra, axis=1)
    if len(others) == 1:
        power = mean_power(others[0])
        shared = np.abs(cross[0]) ** 2
        return np.asarray(np.divide(shared, power, out=np.zeros_like(power), where=power > 0))
    between = np.einsum("isf,jsf->fij", others.conj(), others) / others.shape[1]
    inverse = np.linalg.pinv(between, hermitian=True)
    return np.asarray(np.einsum("if,fij,jf->f", cross.conj(), inverse, cross).real)


def _scaled(density: FloatArray, sampling_frequency: float, segment: int) -> tuple[FloatArray, FloatArray]:
    """Frequencies and one-sided densities from mean squares of spectra."""
    density = density / (sampling_frequency * np.sum(_hann(segment) ** 2))
    density[1 : None if segment % 2 else -1] *= 2
    return np.asarray(np.fft.rfftfreq(segment, 1 / sampling_frequency)), np.asarray(density)


@lru_cache(maxsize=16)
def _hann(segment: int) -> FloatArray:
    return np.asarray(0.5 - 0.5 * np.cos(2 * np.pi * np.arange(segment) / segment))
