"""A log continued periodically: its spectrum, and the grids on which its courses are compared.

A smooth continuation from the end of the log to its beginning makes it periodic. Differentiation, hidden motion and
missing forces are then products with frequency responses. Models are compared on a coarse grid of *rows*, which just
holds the band; nonlinear laws are evaluated on a finer grid.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from symid.arrays import BoolArray, ComplexArray, FloatArray
from symid.data import Log
from symid.diagnosis.prediction.joined_logs import bridge, bridge_samples
from symid.diagnosis.prediction.motion_band import WIDEST

_FEWEST_CONTINUED = 64
"""Least samples of the continuation."""
_BAND_OF_MOTION = 2.0
_END_SECONDS = 0.01
FEWEST_BINS = 8
"""Least number of frequencies of a comparison."""
_FLAT = 0.65
_FINE_HZ = 1000.0
"""Rate that the grid of the laws should have: friction jumps where a velocity changes its sign."""
_FINEST = 8  # points of the fine grid for a row, at most


@dataclass(frozen=True, eq=False, kw_only=True)
class PeriodicLog:
    """A log as a period of signals, up to a frequency."""

    log: Log  # the run
    # position sensors from whose motion everything is predicted, one for each drive, then the other sensors
    signals: tuple[str, ...]
    motion_hz: float  # highest frequency at which a driven position moves by more than its noise

    @cached_property
    def n_extended(self) -> int:
        """Samples of the periodic continuation of the log."""
        pairs = [(self.log[name], self.log[name]) for name in self.signals]
        pad = bridge_samples(pairs, self.log.sampling_period, _FEWEST_CONTINUED)
        return scipy.fft.next_fast_len(self.log.n_samples + pad, real=True)

    @property
    def duration(self) -> float:
        """Duration of the log, s."""
        return self.log.n_samples * self.log.sampling_period

    @property
    def period(self) -> float:
        """Duration of the continued log, s."""
        return self.n_extended * self.log.sampling_period

    @property
    def band_hz(self) -> float:
        """Highest frequency that is used."""
        return min(_BAND_OF_MOTION * self.motion_hz, WIDEST * self.log.sampling_frequency)

    @cached_property
    def n_bins(self) -> int:
        """Number of frequencies used."""
        return max(int(self.band_hz * self.period), FEWEST_BINS)

    @cached_property
    def n_rows(self) -> int:
        """Number of rows of a period."""
        return scipy.fft.next_fast_len(2 * self.n_bins, real=True)

    @cached_property
    def fine_per_row(self) -> int:
        """Points of the fine grid for each row, an even number."""
        wanted = 2 * math.ceil(_FINE_HZ * self.period / self.n_rows / 2)
        return min(max(wanted, 2), _FINEST)

    @property
    def n_fine(self) -> int:
        """Points of the grid on which laws are evaluated."""
        return self.fine_per_row * self.n_rows

    @cached_property
    def omega(self) -> FloatArray:
        """Angular frequencies, rad/s; the first is small instead of zero, where free bodies have no response."""
        omega = np.asarray(2 * np.pi / self.period * np.arange(self.n_bins), dtype=np.float64)
        omega[0] = 1e-3 * omega[1]
        return omega

    @cached_property
    def taper(self) -> FloatArray:
        """Taper from 1 to 0 towards the end of the band; without it, jumps of friction would ring in the rows."""
        place = np.linspace(0, 1, self.n_bins)
        return 0.5 + 0.5 * np.cos(np.pi * np.clip((place - _FLAT) / (1 - _FLAT), 0, 1))

    @cached_property
    def freedom(self) -> float:
        """Independent values in a row: less than 1 because of the taper."""
        return float(np.mean(self.taper**2))

    @cached_property
    def row_time(self) -> FloatArray:
        """Time of each row of the period, s, of shape (n_rows,)."""
        return np.asarray(np.arange(self.n_rows) * (self.period / self.n_rows), dtype=np.float64)

    @cached_property
    def fine_time(self) -> FloatArray:
        """Time of the fine grid, s."""
        return np.asarray(np.arange(self.n_fine) * (self.period / self.n_fine), dtype=np.float64)

    @cached_property
    def rows_in_log(self) -> BoolArray:
        """Flags of the rows within the log, of shape (n_rows,)."""
        return np.asarray(self.row_time < self.duration)

    @cached_property
    def in_log(self) -> BoolArray:
        """Points of the fine grid within the log."""
        return np.asarray(self.fine_time < self.duration)

    def from_grid(self, values: FloatArray) -> ComplexArray:
        """Spectrum of a signal given at any number of evenly spaced points of a period, of shape (..., n_points)."""
        whole = np.asarray(scipy.fft.rfft(values)[..., : self.n_bins], dtype=np.complex128)
        return np.asarray(whole * (self.n_extended / values.shape[-1]))

    def fine(self, spectrum: ComplexArray) -> FloatArray:
        """Signal on the fine grid."""
        return self.grid(spectrum, self.n_fine)

    def resampled(self, values: FloatArray) -> FloatArray:
        """Values at any number of evenly spaced points of a period, on the fine grid."""
        return np.asarray(scipy.fft.irfft(scipy.fft.rfft(values) / values.size, self.n_fine, norm="forward"))

    def rows(self, spectrum: ComplexArray) -> FloatArray:
        """Signal of a spectrum at the rows, of shape (..., n_rows)."""
        return self.grid(spectrum, self.n_rows)

    def grid(self, spectrum: ComplexArray, n: int) -> FloatArray:
        """Signal at any number of evenly spaced points of a period."""
        return np.asarray(scipy.fft.irfft(spectrum * (1 / self.n_extended), n, norm="forward"))

    def continued(self, x: FloatArray, *, smoothly: bool) -> FloatArray:
        """A signal with a continuation to its beginning: linear, or `smoothly` with the slopes at both ends."""
        n = self.n_extended - x.size
        u = np.arange(1, n + 1) / (n + 1)
        if not smoothly:
            return np.concatenate([x, x[-1] * (1 - u) + x[0] * u])
        m = max(8, int(_END_SECONDS * self.log.sampling_frequency))
        (v0, x0), (v1, x1) = (
            np.polyfit(k, part, 2)[1:] for k, part in ((np.arange(1 - m, 1), x[-m:]), (np.arange(m), x[:m]))
        )
        return np.concatenate([x, bridge((x0, v0), (x1, v1), n)])
