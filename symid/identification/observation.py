"""From a log to the observation matrix W and the output y, with the rows that may be used."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.ndimage import maximum_filter1d, shift

from symid.arrays import FloatArray
from symid.codegen import GeneratedModel
from symid.data import Log, LowPass, central_difference, decimate, kept_indices
from symid.errors import SettingError
from symid.identification.settings import Preparation, completed
from symid.signals import derivative_name

BoolArray = npt.NDArray[np.bool_]

_STANDSTILL_SHARE = 0.01
"""Part of the highest speed below which the sign of a velocity is not trusted."""


@dataclass(frozen=True, eq=False)
class Observation:
    """A sampled model.

    Parameters
    ----------
    W : array of shape (n_equations, n_rows, n_parameters)
        Observation matrix.
    y : array of shape (n_equations, n_rows)
        Output.
    valid : bool array of shape (n_equations, n_rows)
        Rows that enter the estimation.
    time : array of shape (n_rows,)
        Time of each row, s.
    preparation : Preparation
        The settings used, complete.
    """

    W: FloatArray
    y: FloatArray
    valid: BoolArray
    time: FloatArray
    preparation: Preparation


def observe(model: GeneratedModel, log: Log, preparation: Preparation) -> Observation:
    """Filter and differentiate a log, evaluate the regressor, decimate, and choose the rows.

    Parameters
    ----------
    model : GeneratedModel
        Its signals must be in the log.
    log : Log
        A run of the axis.
    preparation : Preparation
        What is left open is chosen from the log.

    Raises
    ------
    LogError
        If a signal is missing.
    SettingError
        If a setting is not possible for this log.
    """
    chosen = completed(preparation, log, model)
    signals = _differentiated(model, _filtered(model, log, chosen), log.sampling_period)
    before, after = chosen.trim or (0, 0)
    if before + after >= log.n_samples:
        raise SettingError(
            f"trimming {before} and {after} of {log.n_samples} samples leaves nothing: trim less"
        )
    inner = slice(before, log.n_samples - after)
    W, y = model.sample({name: values[inner] for name, values in signals.items()})
    if chosen.filter_force:
        _filter_laws(model, W, chosen, log.sampling_frequency)
    sliding = model.sliding_velocities(*(signals[name][inner] for name in model.signals))
    factor = chosen.decimation or 1
    kept = kept_indices(y.shape[1], factor)
    usable = _usable_rows(model, sliding, chosen, log.sampling_frequency)[:, kept]
    if factor > 1:
        W = decimate(W.transpose(0, 2, 1), factor, workers=2).transpose(0, 2, 1)
        y = decimate(y, factor, workers=2)
    return Observation(W, y, usable, log.time[inner][kept], chosen)


def _filtered(model: GeneratedModel, log: Log, chosen: Preparation) -> dict[str, FloatArray]:
    """Low-passed signals; the force only if the preparation says so."""
    assert chosen.cutoff_hz is not None
    raw = {name: log[name] for name in model.highest_derivatives}
    lowpass = LowPass(chosen.cutoff_hz, chosen.order)
    names = [name for name in raw if chosen.filter_force or name != model.force]
    rows = lowpass.apply(np.stack([raw[name] for name in names]), log.sampling_frequency, workers=2)
    signals = {**raw, **dict(zip(names, rows, strict=True))}
    for name, seconds in chosen.late.items():
        signals[name] = _earlier(signals[name], seconds / log.sampling_period)
    return signals


def _filter_laws(model: GeneratedModel, W: FloatArray, chosen: Preparation, rate: float) -> None:
    """Pass the values of nonlinear laws, which are computed from filtered motion, through the filter of the force."""
    assert chosen.cutoff_hz is not None
    lowpass = LowPass(chosen.cutoff_hz, chosen.order)
    for equation, parameter in model.law_columns:
        W[equation, :, parameter] = lowpass.apply(W[equation, :, parameter], rate)


def _earlier(values: FloatArray, samples: float) -> FloatArray:
    """Signal moved to an earlier time by any number of samples, by splines of the fifth order."""
    return np.asarray(shift(values, -samples, order=5, mode="nearest"))


def _differentiated(
    model: GeneratedModel, signals: Mapping[str, FloatArray], period: float
) -> dict[str, FloatArray]:
    """Flat names with the derivatives that the model needs, by central differences."""
    flat: dict[str, FloatArray] = {}
    for name, highest in model.highest_derivatives.items():
        current = signals[name]
        for order in range(highest + 1):
            flat[derivative_name(name, order)] = current
            if order < highest:
                current = central_difference(current, period)
    return flat


def _usable_rows(model: GeneratedModel, sliding: FloatArray, chosen: Preparation, rate: float) -> BoolArray:
    """Rows of each equation that are not near the standstill of a law that jumps there.

    Besides the slow samples, those within half a period of the cutoff frequency and within one decimated sample of
    them are left out: there filtered velocity and filtered friction have different signs.
    """
    assert chosen.cutoff_hz is not None
    assert chosen.decimation is not None
    usable = np.ones((len(model.sliding), sliding.shape[1]), dtype=bool)
    if chosen.standstill == 0:
        return usable
    margin = max(math.ceil(0.5 * rate / chosen.cutoff_hz), chosen.decimation if chosen.decimation > 1 else 0)
    near = []
    for velocity in sliding:
        speed = np.abs(velocity)
        threshold = (
            chosen.standstill if chosen.standstill is not None else _STANDSTILL_SHARE * float(speed.max())
        )
        slow = speed < threshold
        slow[1:] |= np.signbit(velocity[1:]) != np.signbit(velocity[:-1])
        near.append(maximum_filter1d(slow, 2 * margin + 1))
    for equation, rows in enumerate(model.sliding):
        for row in rows:
            usable[equation] &= ~near[row]
    return usable
