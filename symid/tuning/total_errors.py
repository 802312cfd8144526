"""Total errors of identified parameters, from bias and noise: noise is drawn many times and added to clean data."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import cycle

import numpy as np
import scipy

from symid.arrays import FloatArray
from symid.codegen import GeneratedModel
from symid.data import Log
from symid.identification import (
    Estimation,
    Observation,
    PhysicalEstimate,
    Preparation,
    excerpts,
    observe,
    physical_estimates,
)
from symid.identification.deviations import MOST_TAKEN, NoiseBias
from symid.identification.rows import noise_of_rows, response_of_rows, widening_of

_HIGHEST_CONDITION = 1e10
"""Condition of the scaled normal matrix beyond which parameters are not determined."""


def expected_errors(
    model: GeneratedModel,
    log: Log,
    seen: Observation,
    parameters: Mapping[str, float],
    levels: Mapping[str, float],
) -> tuple[FloatArray, FloatArray] | None:
    """Relative bias and relative deviation of each physical parameter; None where they are not determined.

    `seen` are the rows of a noise-free log, with friction beside the drive taken off as large as it is, `parameters`
    the true ones, `levels` the one-sided power spectral densities of the white noise of each signal, in the square of
    its unit by Hz.
    """
    true = np.array([parameters[name] for name in model.physical_units])
    X = np.asarray(model.minimal_parameters(*true), dtype=np.float64)
    W, rest = (np.where(seen.valid[..., None], x, 0.0) for x in (seen.W, (seen.y - seen.W @ X)[..., None]))
    rows = seen.valid.sum(axis=1)
    noise, error = noise_of_rows(model, log, seen.preparation, levels), np.append(X, -1.0)
    # Equations are weighted by the residual that the fit will leave: noise, and what rows of a setting are off.
    squares = np.einsum("a,jab,b->j", error, noise, error)
    squares += np.sum(rest[..., 0] ** 2, axis=1) / np.maximum(rows, 1)
    weights = 1.0 / np.maximum(squares, np.finfo(float).tiny)
    size = np.sqrt(np.einsum("j,jta,jta->a", weights, W, W))
    if rows.sum() <= X.size or not np.all(size > 0.0):
        return None
    W = W / size
    slopes = np.einsum("j,jta->ajt", weights, W).reshape(X.size, -1)
    by_noise = np.einsum("j,jab->ab", weights * rows, noise)[:-1] / size[:, None]
    directions, shares = _directions(slopes @ W.reshape(-1, X.size), by_noise[:, :-1] / size)
    if directions is None:
        return None
    # `identify` takes the bias by noise off where its share is not too large: there errors grow, elsewhere it stays.
    taken = shares < MOST_TAKEN
    growth = np.where(taken, 1.0 / (1.0 - np.where(taken, shares, 0.0)), 1.0)
    inverse = (directions * growth) @ directions.T / size[:, None]
    left = directions @ np.where(taken, 0.0, -directions.T @ (by_noise @ error)) / size
    bias = inverse @ (slopes @ rest.ravel()) + left
    # Products of the noise of W with that of y add as much variance again as the noise has a share in W.
    G = (directions * growth**1.5) @ directions.T / size[:, None] @ slopes
    covariance = _covariance(model, log, seen, G.reshape(X.size, *seen.y.shape), X, levels)
    found = physical_estimates(model, X + bias, covariance, parameters)
    if not found:
        return None
    counts = true != 0.0
    relative = (
        found[0].parameters[counts] / true[counts] - 1.0,
        found[0].standard_deviations[counts] / abs(true[counts]),
    )
    return relative if np.all(np.isfinite(relative)) else None


def _directions(normal: FloatArray, by_noise: FloatArray) -> tuple[FloatArray | None, FloatArray]:
    """Directions D with D'(W'S^2 W) D = 1 for noisy rows, and the share of noise in each; None for dependent rows."""
    # W'S^2 W of noisy rows is the clean one plus that of the noise. Two eigenvalue problems diagonalise both at once.
    values, vectors = np.linalg.eigh(normal + by_noise)
    if not values[0] > values[-1] / _HIGHEST_CONDITION:
        return None, values
    root = vectors / np.sqrt(values)
    shares, turned = np.linalg.eigh(root.T @ by_noise @ root)
    return root @ turned, shares


def _covariance(
    model: GeneratedModel,
    log: Log,
    seen: Observation,
    G: FloatArray,
    X: FloatArray,
    levels: Mapping[str, float],
) -> FloatArray:
    """Covariance of G e, with G of shape (n_parameters, n_equations, n_rows)."""
    factor, rate = seen.preparation.decimation or 1, log.sampling_frequency
    # One row is one sample of the log: between the rows that are kept, G is zero.
    n = scipy.fft.next_fast_len(2 * G.shape[2] * factor, real=True)
    spread = np.zeros((*G.shape[:2], G.shape[2], factor))
    spread[..., 0] = G
    frequency: FloatArray = np.linspace(0.0, rate * (n // 2) / n, n // 2 + 1)
    gains = np.fft.rfft(spread.reshape(*G.shape[:2], -1), n)
    covariance = np.zeros((X.size, X.size))
    for name, level in levels.items():
        response = response_of_rows(model, log, seen.preparation, name, np.append(X, -1.0), frequency)
        passed = np.einsum("ajf,jf->af", gains.conj(), response)
        covariance += level * rate / n * (passed @ passed.conj().T).real
    return covariance


_LOST = 1.0
"""Relative error at which a parameter counts as lost; larger errors are clipped to it."""

_LARGE = 1e3
"""Relative deviation above which every error counts as lost."""


@dataclass(frozen=True, eq=False)
class TotalErrors:
    """Errors of the parameters from noise-free data to which noise is added."""

    model: GeneratedModel  # model of the sensors
    runs: tuple[Log, ...]  # noise-free data of one or several simulations of the same motion
    noise: Mapping[str, float]  # standard deviation of each signal's noise
    parameters: Mapping[str, float]  # true physical parameters
    draws: int  # how many times noise is drawn, for one run after the other; all settings see the same noise
    first_seed: int = 0  # seed of the first draw; the next ones follow

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
    """The log with white noise of these deviations, SI; the same seed gives the same noise for logs of equal length."""
    random = np.random.default_rng(seed)
    signals: dict[str, FloatArray] = dict(log.signals)
    for name in sorted(levels):
        signals[name] = signals[name] + levels[name] * random.standard_normal(log.n_samples)
    return Log(log.source, log.start, log.sampling_period, signals)
