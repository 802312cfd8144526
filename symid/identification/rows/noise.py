"""Sensor noise in the columns of W and in y, estimated from the log itself.

The noise of a signal is taken as white, with the level of the log near its Nyquist frequency, where an axis moves too
little to be seen. Every column that is linear in the signals is a chain of known gains, of which differences,
low-pass and decimation are parts; the covariance of the noise of two columns at the same time is the integral over
frequency of the product of their gains with the level.
"""

import math
from collections.abc import Mapping
from functools import cache, lru_cache, partial
from typing import NamedTuple

import numpy as np

from symid.arrays import ComplexArray, FloatArray
from symid.codegen import GeneratedModel
from symid.data import AnyLog, Log, in_memory
from symid.identification.rows.settings import Preparation
from symid.signal_names import split_derivative
from symid.signal_processing import (
    NOISE_FROM,
    LowPass,
    central_difference_gain,
    decimation_filter,
    density_of,
    incoherent_density_of,
    segment_spectra,
)

_QUIET_SHARE = 3e-3
_LEAST_WIDENING = 2.0
"""A filter that is as narrow as that of the motion moves all reversals of friction one way; noise that a wider one lets
through moves them by chance (a flexible axis at 1 kHz: Fvs +6 % at 4.4 deviations with 1, +0.4 % with 2)."""
_LONGEST_SEGMENT = 4096
_LONGEST = 1_048_576
"""Samples from which spectra are taken; of a longer log, evenly spread excerpts."""
_EXCERPTS = 8
_LINES = 2048
"""Frequencies at which gains are taken."""


def noise_levels(model: GeneratedModel, log: AnyLog, *, forces: bool = True) -> dict[str, float]:
    """One-sided power spectral density of the white noise of each signal, in the square of its unit by Hz.

    Levels are medians above 0.7 of the Nyquist frequency, of second differences, which keep the motion from leaking
    there. The part of the force that follows the motion is not noise of its measurement, but what the controller made
    of the encoder's: it is left out. Of a log above a million samples, evenly spread excerpts are taken; forces are
    left out on demand.

    >>> from symid.codegen import load_generated
    >>> noise = np.random.default_rng(0).standard_normal((2, 20_000))
    >>> log = Log.from_arrays({"q": 1e-6 * noise[0], "F": 3.0 * noise[1]}, sampling_period=1e-3)
    >>> levels = noise_levels(load_generated("rigid_1m"), log)
    >>> round(levels["q"] * 500 * 1e12, 1), round(levels["F"] * 500)
    (1.0, 9)
    """
    segment = min(max(16, min(_LONGEST_SEGMENT, log.n_samples // 16)), log.n_samples - 2)
    names = list(model.highest_derivatives)
    motion = tuple(name for name in names if name not in model.forces)
    spectra = cache(lambda name: _bent_spectra(log, name, segment))

    def level(name: str, beside: tuple[str, ...]) -> float:
        rate = log.sampling_frequency
        if beside:
            others = np.stack([spectra(other) for other in beside])
            frequency, density = incoherent_density_of(spectra(name), others, rate, segment)
        else:
            frequency, density = density_of(spectra(name), rate, segment)
        upper = (frequency > NOISE_FROM * rate) & (frequency < 0.5 * rate)
        gain = (2 * np.sin(np.pi * frequency[upper] / rate)) ** 4
        return float(np.median(density[upper] / gain))

    def kept(name: str) -> float:
        beside = motion if name in model.forces else ()
        found = partial(level, name, beside)
        return log.kept((noise_levels, name, beside), found) if isinstance(log, Log) else found()

    return {name: kept(name) for name in names if forces or name not in model.forces}


def _bent_spectra(log: AnyLog, name: str, segment: int) -> ComplexArray:
    """Spectra of the second differences of a signal."""

    def found() -> ComplexArray:
        return segment_spectra(np.diff(spread_excerpts(log, name), 2), segment)

    return log.kept((_bent_spectra, name, segment), found) if isinstance(log, Log) else found()


def spread_excerpts(log: AnyLog, name: str) -> FloatArray:
    """Evenly spread parts of a long signal, one a row: enough for a spectrum; a shorter signal as it is."""
    length = _LONGEST // _EXCERPTS
    if log.n_samples <= _LONGEST:
        return in_memory(log)[name][None]
    starts = np.linspace(0, log.n_samples - length, _EXCERPTS).astype(int).tolist()
    return np.stack([log.window(start, start + length)[name] for start in starts])


def noise_deviations(model: GeneratedModel, log: Log) -> dict[str, float]:
    """Standard deviation of the white noise of each signal, SI, by `noise_levels`.

    >>> from symid.codegen import load_generated
    >>> noise = np.random.default_rng(0).standard_normal((2, 20_000))
    >>> log = Log.from_arrays({"q": 2.0 * noise[0], "F": 3.0 * noise[1]}, sampling_period=1e-3)
    >>> found = noise_deviations(load_generated("rigid_1m"), log)
    >>> round(found["q"], 1), round(found["F"], 1)
    (2.0, 3.0)
    """
    half_rate = log.sampling_frequency / 2
    return {name: math.sqrt(level * half_rate) for name, level in noise_levels(model, log).items()}


def noise_of_rows(
    model: GeneratedModel, log: Log, chosen: Preparation, levels: Mapping[str, float]
) -> FloatArray:
    """Covariance of the noise of all columns and of y at one row, of shape (n_equations, n_columns + 1, n_columns + 1).

    Columns of nonlinear laws count as free of noise; the levels of the signals are those of `noise_levels`.
    """
    of_one = _noise_by_signal(model, _row_filter(log, chosen))
    return np.asarray(sum(level * of_one[name] for name, level in levels.items()))


class _RowFilter(NamedTuple):
    """Steps from the signals of a log to rows."""

    period: float
    low_pass: LowPass
    filter_force: bool
    difference_order: int
    decimation: int  # of the filter that rows pass, 1 without one


def _row_filter(log: Log, chosen: Preparation) -> _RowFilter:
    assert chosen.cutoff_hz is not None
    low_pass = LowPass(chosen.cutoff_hz, chosen.order)
    rest = chosen.filter_force, chosen.difference_order, chosen.filtered_decimation(log.sampling_period)
    return _RowFilter(log.sampling_period, low_pass, *rest)


@lru_cache(maxsize=64)  # logs of a batch are prepared alike
def _noise_by_signal(model: GeneratedModel, rows: _RowFilter) -> dict[str, FloatArray]:
    """Result of `noise_of_rows` for a noise level of 1 of each signal alone."""
    found = {}
    for name in model.highest_derivatives:
        response = _response_to(model, rows, name)
        found[name] = (response @ response.conj().swapaxes(1, 2)).real / (2 * _LINES * rows.period)
    return found


def _response_to(model: GeneratedModel, rows: _RowFilter, name: str) -> ComplexArray:
    """Response of all columns and of y to a signal, of shape (n_equations, n_columns + 1, n_lines)."""
    frequency = (np.arange(_LINES) + 0.5) / (2 * _LINES * rows.period)
    difference = 2j * np.pi * frequency * _difference_gain(rows.difference_order)
    filtered = _decimation_gain(rows.decimation) if rows.decimation > 1 else np.ones_like(frequency)
    if rows.filter_force or name not in model.forces:
        filtered = filtered * rows.low_pass.sampled_gain(frequency, 1 / rows.period)
    orders = {
        i: split_derivative(flat)[1]
        for i, flat in enumerate(model.signals)
        if split_derivative(flat)[0] == name
    }
    gains = np.stack([difference**order * filtered for order in orders.values()])
    return np.asarray(coefficients(model)[:, :, list(orders)] @ gains)


def response_of_rows(
    model: GeneratedModel,
    log: Log,
    chosen: Preparation,
    name: str,
    combination: FloatArray,
    frequency: FloatArray,
) -> ComplexArray:
    """Response of a combination of the columns and y to the noise of a signal, of shape (n_equations, n_frequencies).

    It is interpolated between the frequencies of `noise_of_rows`, and that of all rows before some are left out.
    """
    known = (np.arange(_LINES) + 0.5) * log.sampling_frequency / (2 * _LINES)
    response = np.einsum("a,jaf->jf", combination, _response_to(model, _row_filter(log, chosen), name))
    return np.stack([np.interp(frequency, known, one) for one in response])


def noise_limited_widening(
    model: GeneratedModel, log: Log, cutoff_hz: float, levels: Mapping[str, float], widest: float
) -> float:
    """Factor by which motion is filtered wider, from 2 up to `widest`, so that laws that jump keep their reversals.

    Beyond 2, the noise of a sliding velocity stays below 0.3 % of the highest speed. 1 is returned if nothing jumps.
    Levels of forces are not needed.
    """
    if not any(model.sliding):
        return 1.0
    lag = max(1, min(int(log.sampling_frequency / (4 * cutoff_hz)), log.n_samples // 4))
    still = np.zeros(log.n_samples - 2 * lag)
    noise, coarse = [], []
    for flat in model.signals:
        name, order = split_derivative(flat)
        noise.append(levels.get(name, 0.0) * (2 * np.pi) ** 2 / 3 if order == 1 else 0.0)
        moved = (log[name][2 * lag :] - log[name][: -2 * lag]) / (2 * lag * log.sampling_period)
        coarse.append(moved if order == 1 else log[name][lag:-lag] if order == 0 else still)
    factors = np.concatenate(
        [model.sliding_velocities(*unit[:, None]) for unit in np.eye(len(noise))], axis=1
    )
    allowed = (_QUIET_SHARE * np.max(np.abs(model.sliding_velocities(*coarse)), axis=1)) ** 2
    cube = np.min(allowed / np.maximum(factors**2 @ np.array(noise), np.finfo(float).tiny))
    return min(max(float(np.cbrt(cube)) / cutoff_hz, _LEAST_WIDENING), widest)


@lru_cache(maxsize=16)
def _difference_gain(order: int) -> FloatArray:
    """Share of the derivative that differences keep at the frequencies of `noise_of_rows`."""
    return np.asarray(central_difference_gain((np.arange(_LINES) + 0.5) / (2 * _LINES), 1.0, order=order))


@lru_cache(maxsize=16)
def _decimation_gain(factor: int) -> FloatArray:
    """Gain of the decimation filter at the frequencies of `noise_of_rows`, whatever the sampling frequency."""
    z = np.exp(-1j * np.pi * (np.arange(_LINES) + 0.5) / _LINES)
    powers = np.stack([np.ones_like(z), z, z**2])
    sections = decimation_filter(factor).sections
    response = (sections[:, :3] @ powers) / (sections[:, 3:] @ powers)
    return np.asarray(np.abs(np.prod(response, axis=0)) ** 2)


@lru_cache(maxsize=16)
def coefficients(model: GeneratedModel) -> FloatArray:
    """Factor of each signal in each column of W and in y, of shape (n_equations, n_columns + 1, n_signals)."""
    step = 0.0 if not model.known_laws else 1.0  # jumps of known laws cancel between two values of one sign
    units = np.eye(len(model.signals))
    return np.stack([_at(model, (1 + step) * unit) - _at(model, step * unit) for unit in units], axis=2)


def _at(model: GeneratedModel, values: FloatArray) -> FloatArray:
    W, y = model.sample({name: np.array([value]) for name, value in zip(model.signals, values, strict=True)})
    rows = np.concatenate([W[:, 0], y], axis=1)
    for equation, parameter in model.law_columns:
        rows[equation, parameter] = 0.0
    return rows
