"""Errors caused by the low-pass filter alone: exact derivatives in the standard model, as in [35]."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from symid.arrays import BoolArray, FloatArray
from symid.data import LowPass
from symid.estimation import estimate, triangular_factors
from symid.tuning.exact_run import ExactRun
from symid.tuning.standard import StandardModel

_LOWEST_SHARE, _HIGHEST_SHARE = 1 / 2000, 0.4
"""Cutoffs scanned, as shares of the sampling frequency."""
_STANDSTILL_SHARE = 0.01
_EDGE_PERIODS = 3


@dataclass(frozen=True, eq=False)
class LowPassErrors:
    """Relative errors of the physical parameters by cutoff frequency.

    Parameters
    ----------
    model : StandardModel
        The standard model [5].
    run : ExactRun
        Where its signals come from.
    parameters : mapping of str to float
        True values.
    sampling_hz : float
        Sampling frequency of the data, Hz; `rate` is the nearest one of which that of the run is a multiple.
    order : int
        Order of one pass of the filter.
    filter_force : bool
        Whether the force, and with it the values of nonlinear laws, pass the filter too.
    """

    model: StandardModel
    run: ExactRun
    parameters: Mapping[str, float]
    sampling_hz: float
    order: int
    filter_force: bool

    @property
    def _every(self) -> int:
        return max(1, round(self.run.rate / self.sampling_hz))

    @property
    def rate(self) -> float:
        """Sampling frequency in use, Hz."""
        return self.run.rate / self._every

    @cached_property
    def _exact(self) -> dict[str, FloatArray]:
        return self.run.exact_signals(self._every)

    @property
    def _n_samples(self) -> int:
        return next(iter(self._exact.values())).size

    def scan(self, points: int) -> list[float]:
        """Cutoff frequencies to be scanned, Hz, from that which trims a quarter of the data."""
        duration = self._n_samples / self.rate
        lowest = max(_LOWEST_SHARE * self.rate, 8 * _EDGE_PERIODS / duration)
        return [float(f) for f in np.geomspace(lowest, _HIGHEST_SHARE * self.rate, points)]

    def errors(self, cutoff_hz: float) -> dict[str, float]:
        """Error of each physical parameter in percent; nan if its true value is 0 or not determined."""
        low_pass = LowPass(cutoff_hz, self.order)
        kept_as_is = () if self.filter_force else self.run.forces
        filtered = {
            name: values if name in kept_as_is else low_pass.apply(values, self.rate)
            for name, values in self._exact.items()
        }
        # Exact derivatives are filtered, so that neither differences nor noise play a part: the error of the filter
        # remains, which nonlinear laws of filtered motion do not commute with.
        W, y = self.model.sample(filtered)
        if self.filter_force:
            for equation, column in self.model.law_columns:
                W[equation, :, column] = low_pass.apply(W[equation, :, column], self.rate)
        kept = self._kept(filtered, cutoff_hz)
        known = self.run.axis.known_parameters
        sought = [i for i, name in enumerate(self.model.parameters) if name not in known]
        for i, name in enumerate(self.model.parameters):
            y -= known.get(name, 0.0) * W[:, :, i]
        fit = estimate(triangular_factors(W[:, kept][:, :, sought], y[:, kept]), "ols")
        found = zip((self.model.parameters[i] for i in sought), map(float, fit.parameters), strict=True)
        return {
            name: 100.0 * (value / self.parameters[name] - 1.0) if self.parameters[name] else math.nan
            for name, value in found
            if name not in self.model.per_log
        }

    def _kept(self, filtered: Mapping[str, FloatArray], cutoff_hz: float) -> BoolArray:
        """Rows that are used: not near the ends, and not near zeros of velocities at which a law jumps."""
        n_samples = self._n_samples
        kept = np.ones(n_samples, dtype=bool)
        edge = math.ceil(_EDGE_PERIODS * self.rate / cutoff_hz)
        kept[:edge] = kept[n_samples - edge :] = False
        margin = math.ceil(0.5 * self.rate / cutoff_hz)
        for velocity in self.model.sliding(filtered):
            slow = np.abs(velocity) < _STANDSTILL_SHARE * np.abs(velocity).max()
            slow[1:] |= np.signbit(velocity[1:]) != np.signbit(velocity[:-1])
            kept &= ~scipy.ndimage.maximum_filter1d(slow, 2 * margin + 1)
        return kept
