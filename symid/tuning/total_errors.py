"""Total errors of identified parameters, from bias and noise: noise is drawn many times and added to clean data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import cycle

import numpy as np
import scipy

from symid.arrays import FloatArray
from symid.codegen import GeneratedModel
from symid.data import Log
from symid.identification import PhysicalEstimate, Preparation, excerpts, physical_estimates
from symid.identification.bias import NoiseBias
from symid.identification.cutoff import Estimation
from symid.identification.observation import observe
from symid.identification.settings import widening_of
from symid.tuning.expected_errors import expected_errors

_LOST = 1.0
"""Relative error at which a parameter counts as lost; larger errors are clipped to it."""

_LARGE = 1e3
"""Relative deviation above which every error counts as lost."""


@dataclass(frozen=True, eq=False)
class TotalErrors:
    """Errors of the parameters from noise-free data to which noise is added.

    Parameters
    ----------
    model : GeneratedModel
        Model of the sensors.
    runs : tuple of Log
        Noise-free data of one or several simulations of the same motion.
    noise : mapping of str to float
        Standard deviation of each signal's noise.
    parameters : mapping of str to float
        True physical parameters.
    draws : int
        How many times noise is drawn, for one run after the other; all settings see the same noise.
    first_seed : int
        Seed of the first draw; the next ones follow.
    """

    model: GeneratedModel
    runs: tuple[Log, ...]
    noise: Mapping[str, float]
    parameters: Mapping[str, float]
    draws: int
    first_seed: int = 0

    @property
    def names(self) -> tuple[str, ...]:
        """Physical parameters that have a relative error."""
        return tuple(name for name in self.model.physical_units if self.parameters[name])

    @cached_property
    def noisy(self) -> tuple[Log, ...]:
        """The logs with drawn noise."""
        seeds = range(self.first_seed, self.first_seed + self.draws)
        pairs = zip(cycle(self.runs), seeds, strict=False)
        return tuple(with_noise(log, self.noise, seed) for log, seed in pairs)

    @property
    def clean(self) -> Log:
        """Noise-free data of the first run."""
        return self.runs[0]

    def relative(self, log: Log, settings: Preparation) -> FloatArray:
        """Relative error of each parameter that `identify` finds, at most 1 in magnitude, which counts as lost.

        As there friction beside the drive is taken off the force, and the bias by noise off the parameters.
        """
        trial = Estimation(self.model, (log,), settings, "wls", None).trial()
        fit = trial.fit
        found: tuple[PhysicalEstimate, ...] = ()
        if fit.status == "ok":
            parts = excerpts(self.model, (log,), [run.observation for run in trial.runs])
            minimal = fit.parameters - NoiseBias.of(self.model, parts, fit).removed
            found = physical_estimates(self.model, minimal, fit.covariance, self.parameters)
        if not found:
            return np.full(len(self.names), _LOST)
        values = dict(zip(self.model.physical_units, found[0].parameters, strict=True))
        errors = np.array([values[name] / self.parameters[name] - 1.0 for name in self.names])
        return np.asarray(np.clip(np.nan_to_num(errors, nan=_LOST), -_LOST, _LOST), dtype=np.float64)

    def rms(self, settings: Preparation) -> FloatArray:
        """Root mean square error of each parameter over the draws, bias included."""
        errors = np.array([self.relative(log, settings) for log in self.noisy], dtype=np.float64)
        squares: FloatArray = np.square(errors).mean(axis=0)
        return np.asarray(np.sqrt(squares), dtype=np.float64)

    def expected(self, settings: Preparation) -> FloatArray:
        """Root mean square error of each parameter over the runs, to first order in the noise, without draws."""
        squares = [self._expected_of(log, settings) for log in self.runs]
        return np.asarray(np.sqrt(np.mean(squares, axis=0)), dtype=np.float64)

    def _expected_of(self, log: Log, settings: Preparation) -> FloatArray:
        """Mean square error of each parameter in one run."""
        assert settings.cutoff_hz is not None
        model, values = self.model, (self.parameters[name] for name in self.model.physical_units)
        levels = {name: 2 * log.sampling_period * noise**2 for name, noise in self.noise.items()}
        minimal = model.minimal_parameters(*values)
        chosen = replace(
            settings,
            coulomb=tuple(float(minimal[parameter]) for _, parameter in model.coulomb_at_drive),
            widening=settings.widening or widening_of(log, model, settings.cutoff_hz, levels),
        )
        found = expected_errors(model, log, observe(model, log, chosen), self.parameters, levels)
        if found is None:
            return np.full(len(self.names), _LOST**2)
        return _limited_squares(*found)


def _limited_squares(mean: FloatArray, deviation: FloatArray) -> FloatArray:
    """Mean square of normally distributed errors that are clipped at `_LOST`.

    >>> _limited_squares(np.array([0.0, 0.1, 0.0]), np.array([1e-3, 1e-9, 1e9])).round(3).tolist()
    [0.0, 0.01, 0.999]
    """
    size = np.clip(deviation, np.finfo(float).tiny, _LARGE)
    low, high = (-_LOST - mean) / size, (_LOST - mean) / size
    inside = scipy.special.ndtr(high) - scipy.special.ndtr(low)
    at_low, at_high = (np.exp(-0.5 * z**2) / np.sqrt(2 * np.pi) for z in (low, high))
    ends = 2 * mean * size * (at_low - at_high) + size**2 * (low * at_low - high * at_high)
    return np.asarray((mean**2 + size**2) * inside + ends + _LOST**2 * (1.0 - inside))


def with_noise(log: Log, levels: Mapping[str, float], seed: int) -> Log:
    """The log with white noise added; the same seed gives the same noise for logs of equal length.

    Parameters
    ----------
    log : Log
        The log.
    levels : mapping of str to float
        Standard deviation of the noise by signal, SI.
    seed : int
        Seed of the noise.
    """
    random = np.random.default_rng(seed)
    signals: dict[str, FloatArray] = dict(log.signals)
    for name in sorted(levels):
        signals[name] = signals[name] + levels[name] * random.standard_normal(log.n_samples)
    return Log(log.source, log.start, log.sampling_period, signals)
