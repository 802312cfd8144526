"""Zero-phase low-pass filters and decimation.

The conventions are those of MATLAB's ``filtfilt`` and ``decimate``, with which published results were made:
odd padding of three times the filter order, and kept samples counted so that the last one is among them.
Signals are vectors, or matrices of one signal per row: time runs along the last axis.
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
import numpy.typing as npt

from symid.arrays import FloatArray, fast_length
from symid.errors import SettingError
from symid.signal_processing.sections import butterworth, chebyshev
from symid.signal_processing.zero_phase import ZeroPhaseFilter, odd_extension

_PERIODS: Final = 5.0  # of the cutoff, by which a signal is continued where its spectrum is filtered
_DECIMATION_ORDER: Final = 8  # as MATLAB's decimate, as are ripple and cutoff
_DECIMATION_RIPPLE_DB: Final = 0.05
_DECIMATION_CUTOFF: Final = 0.8  # of the Nyquist frequency after decimation


@dataclass(frozen=True)
class LowPass:
    """Butterworth low-pass filter run forward and backward, so that it shifts no phase.

    Parameters
    ----------
    cutoff_hz : float
        Cutoff frequency of one pass, Hz; there the two passes together halve the amplitude.
    order : int
        Order of one pass.

    Raises
    ------
    SettingError
        If the cutoff or the order is not positive.

    Examples
    --------
    >>> float(LowPass(100.0).gain(100.0))
    0.5
    """

    cutoff_hz: float
    order: int = 4

    def __post_init__(self) -> None:
        if not (math.isfinite(self.cutoff_hz) and self.cutoff_hz > 0.0):
            raise SettingError(f"cutoff {self.cutoff_hz:g} Hz is not possible: give a positive frequency")
        if self.order < 1:
            raise SettingError(f"filter order {self.order} is not possible: give 1 or more")

    @property
    def padding(self) -> int:
        """Samples by which the signal is continued at each end; a signal must be longer than this."""
        return 3 * self.order

    def apply(self, x: npt.ArrayLike, sampling_frequency: float, *, workers: int = 1) -> FloatArray:
        """Low-passed signal.

        Parameters
        ----------
        x : array_like of shape (..., n_samples)
            Signal, or one signal per row.
        sampling_frequency : float
            Samples per second, Hz.
        workers : int
            Threads that share the signal.

        Returns
        -------
        array of shape (..., n_samples)

        Raises
        ------
        SettingError
            If the cutoff is not below half the sampling frequency, or the signal not longer than the padding.
        """
        values = np.asarray(x, dtype=np.float64)
        n_samples = values.shape[-1] if values.ndim else 1
        filtered = np.empty(values.shape)
        self.run_over(n_samples, sampling_frequency).apply_rows(values, filtered, slice(None), workers)
        return filtered

    def run_over(self, n_samples: int, sampling_frequency: float) -> ZeroPhaseFilter:
        """Filter that `apply` runs over a signal of a length, with the errors of `apply`."""
        if not 0.0 < self.cutoff_hz < sampling_frequency / 2:
            raise SettingError(
                f"cutoff {self.cutoff_hz:g} Hz is not below half the sampling frequency of "
                f"{sampling_frequency:g} Hz: choose a cutoff under {sampling_frequency / 2:g} Hz"
            )
        if n_samples <= self.padding:
            raise SettingError(
                f"{n_samples} samples are too few for the low-pass filter: more than {self.padding} are required"
            )
        return self.zero_phase(sampling_frequency)

    def by_spectrum(self, x: FloatArray, sampling_frequency: float) -> FloatArray:
        """Vector low-passed by `gain` in the frequency domain, after an odd extension of its ends.

        Examples
        --------
        >>> t = np.arange(2000) / 1000
        >>> slow, fast = np.sin(2 * np.pi * 2 * t), np.sin(2 * np.pi * 200 * t)
        >>> error = LowPass(20.0).by_spectrum(slow + fast, 1000.0) - slow
        >>> float(np.abs(error[100:-100]).max()) < 5e-3
        True
        """
        n = min(x.size - 1, math.ceil(_PERIODS * sampling_frequency / self.cutoff_hz))
        extended = odd_extension(x, n)
        size = fast_length(extended.size)
        gain = self.gain(np.fft.rfftfreq(size, 1 / sampling_frequency))
        return np.fft.irfft(np.fft.rfft(extended, size) * gain, size)[n : n + x.size]

    def zero_phase(self, sampling_frequency: float) -> ZeroPhaseFilter:
        """Filter that `apply` runs over a signal sampled at `sampling_frequency` (Hz), above twice the cutoff."""
        return _low_pass(self.order, self.cutoff_hz, sampling_frequency)

    def gain(self, frequency: npt.ArrayLike) -> FloatArray:
        """Amplitude left at `frequency` (Hz) by both passes: 1 / (1 + (f / cutoff)^(2 order)), as [34].

        This is the analogue filter that the sampled one approaches well below half the sampling frequency.
        """
        ratio = np.asarray(frequency, dtype=np.float64) / self.cutoff_hz
        return _squared_butterworth(ratio, self.order)

    def sampled_gain(self, frequency: npt.ArrayLike, sampling_frequency: float) -> FloatArray:
        """Amplitude that `apply` leaves at `frequency` (Hz), with the warping of the bilinear transform."""
        warped = np.tan(np.pi * np.asarray(frequency, dtype=np.float64) / sampling_frequency)
        ratio = warped / np.tan(np.pi * self.cutoff_hz / sampling_frequency)
        return _squared_butterworth(ratio, self.order)


@lru_cache(maxsize=64)  # a design takes as long as filtering ten thousand samples
def _low_pass(order: int, cutoff_hz: float, sampling_frequency: float) -> ZeroPhaseFilter:
    return ZeroPhaseFilter(butterworth(order, 2.0 * cutoff_hz / sampling_frequency), 3 * order)


def _squared_butterworth(ratio: FloatArray, order: int) -> FloatArray:
    with np.errstate(over="ignore"):  # far above the cutoff the power may overflow: the gain is then 0
        return np.asarray(1.0 / (1.0 + np.abs(ratio) ** (2 * order)))[()]


def kept_indices(n_samples: int, factor: int) -> slice:
    """Samples that decimation keeps, as a slice: every `factor`-th so that the last sample is among them.

    This is MATLAB's choice, n_beg = r - (r ceil(n / r) - n) counted from 1.

    Parameters
    ----------
    n_samples : int
        Samples of the signal.
    factor : int
        Samples per kept sample, 1 or more.

    Examples
    --------
    >>> list(range(10))[kept_indices(10, 4)]
    [1, 5, 9]
    """
    return slice((n_samples - 1) % factor, n_samples, factor)


@lru_cache(maxsize=64)
def decimation_filter(factor: int) -> ZeroPhaseFilter:
    """Low-pass that a signal passes before every `factor`-th sample is kept, 2 or more: that of MATLAB's ``decimate``.

    It is a Chebyshev filter of type I, order 8, 0.05 dB ripple, with its cutoff at 0.8 of the new Nyquist frequency,
    run forward and backward. Its even order lowers slow signals by the ripple of both passes (factor 0.9886), which a
    regression does not see if both of its sides pass it.
    """
    sections = chebyshev(_DECIMATION_ORDER, _DECIMATION_RIPPLE_DB, _DECIMATION_CUTOFF / factor)
    return ZeroPhaseFilter(sections, 3 * _DECIMATION_ORDER)
