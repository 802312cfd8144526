"""Correction of the fitted values for the bias of the fit (indirect inference).

The fit uses motion up to a frequency, and does not know the initial state of hidden motion. Its bias, which arises
mostly at reversals, is the same in a simulation of the axis that was found, where the true values are known. The errors
of that simulation are subtracted from those of the log, and the values are fitted again (Gourieroux, Monfort and
Renault, J. Applied Econometrics 8, 1993).
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symid.arrays import BoolArray, ComplexArray
from symid.data import Log
from symid.diagnosis.effects import Placed
from symid.diagnosis.findings.comparison import Comparison
from symid.diagnosis.findings.diagnosis_result import Diagnosis
from symid.diagnosis.findings.parameter_changes import effect_values, parameter_changes
from symid.diagnosis.fitting.applied import applied, applied_or_none, belongs_to_log
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.gauss_newton import continued
from symid.diagnosis.fitting.state import State, with_effects
from symid.diagnosis.in_motion.declared import axis_with_effects
from symid.diagnosis.in_motion.motion import drivers_of
from symid.diagnosis.in_motion.replayed import Driver, Part, replayed
from symid.diagnosis.prediction.data import Controllers
from symid.diagnosis.prediction.joined_logs import JoinedLogs
from symid.diagnosis.prediction.record import Record
from symid.errors import SymidError


def with_corrected_values(
    found: Diagnosis, comparison: Comparison, fits: Sequence[Fit], run: JoinedLogs, controller: Controllers
) -> tuple[Diagnosis, Comparison]:
    """A diagnosis with corrected values of its last model, and the comparison with that model to be simulated.

    The gap of the force stays that which the fit leaves. Without effects, or where the axis with the corrected values
    would not move nearer to the machine, both stay as they are.
    """
    n = len(found.effects)
    better = corrected(fits[n], run, controller) if n else None
    if better is None:
        return found, comparison
    models = comparison.with_effects(n)
    last = applied_or_none(better.state, models.record, models.weighting.allowed, models.weighting)
    if last is None:
        return found, comparison
    values = effect_values(better)[-n:]
    moments = (own.effect.moments for own in better.state.placed[-n:])
    effects = (
        replace(own, parameters={name: own.parameters[name] if name in kept else new[name] for name in new})
        for own, new, kept in zip(found.effects, values, moments, strict=True)
    )
    parameters = parameter_changes((fits[0], better), fits[0].nominal)
    found = replace(found, effects=tuple(effects), parameters=parameters)
    return found, replace(models, states=(*models.states[:-1], last))


def corrected(fit: Fit, run: JoinedLogs, controller: Controllers = None) -> Fit | None:
    """A fit with corrected values; None if its axis cannot be simulated or would move no nearer to the machine."""
    try:
        with np.errstate(all="ignore"):
            return _corrected(fit, run, controller)
    except (SymidError, ArithmeticError, ValueError, np.linalg.LinAlgError):
        return None


def _corrected(fit: Fit, run: JoinedLogs, controller: Controllers) -> Fit | None:
    record = fit.state.prediction.record
    whole = [Part(log, np.ones(log.n_samples, dtype=bool), record) for log in run.parts]
    parts = [[replace(part, drive=d) for d in range(record.n_drives)] for part in whole]
    if whole[0].factor > 1 or (len(parts) > 1 and belongs_to_log(fit.state).any()):
        return None  # the force would change within a sample; values of one log would be those of all
    if axis_with_effects(fit.state).left_out:
        return None
    drivers = drivers_of(record, whole, [fit.state], controller)
    moved = _replays(fit.state, parts, drivers)
    off = applied(fit.state, _as_simulated(record, run, moved), fit.weighting.allowed)[0].errors
    for i, name in enumerate(record.readings, record.n_drives):
        if record.dynamics.sensors[name][1] == 2:  # jumps with the force, before which it is read
            off[i] = 0.0
    model, weighting = applied(fit.state, _less(record, off), fit.weighting.allowed)
    model = with_effects(replace(model, bounds=fit.state.bounds), weighting, _at_moments_of(fit, model))
    after = continued(Fit(model, weighting), 1, ~_moments(model)).after(fit)
    nearer = _distance(parts, _replays(after.state, parts, drivers)) < _distance(parts, moved)
    return after if nearer else None


def _at_moments_of(fit: Fit, model: State) -> tuple[Placed, ...]:
    """Effects of a model at the moments of a fit, which trials on the measured motion have found."""
    return tuple(
        replace(
            item,
            shape=tuple(
                before if name in item.effect.moments else x
                for name, before, x in zip(item.effect.shape_names, own.shape, item.shape, strict=True)
            ),
        )
        for item, own in zip(model.placed, fit.state.placed, strict=True)
    )


def _moments(state: State) -> BoolArray:
    """Free values that are moments, shape (n_columns,): these are found by trials, and no step leads to them."""
    found = np.zeros(len(state.prediction.parameters) + sum(item.n_free for item in state.placed), dtype=bool)
    for item, values in zip(state.placed, state.values_of, strict=True):
        names = item.effect.shape_names
        found[values.stop - len(names) : values.stop] = [name in item.effect.moments for name in names]
    return found


def _replays(state: State, parts: Sequence[Sequence[Part]], drivers: Sequence[Driver]) -> list[Log]:
    explained = axis_with_effects(state)
    return [replayed(explained, own, drivers) for own in parts]


def _distance(parts: Sequence[Sequence[Part]], moved: Sequence[Log]) -> float:
    """Square of the distances of simulated positions next to the drives, in multiples of the noise of the readings."""
    return math.fsum(
        float(np.sum((part.position - log[part.signal]) ** 2) / part.record.noise_of_motions[part.drive] ** 2)
        for own, log in zip(parts, moved, strict=True)
        for part in own
    )


def _as_simulated(record: Record, run: JoinedLogs, moved: Sequence[Log]) -> Record:
    """The record of simulated logs, with the noise of the measured ones in its weights."""
    signals = dict(record.log.signals)
    for name in (*record.forces, *record.signals):
        signals[name] = signals[name].copy()
        signals[name][run.recorded] = np.concatenate([log[name] for log in moved])
    log, axis = replace(record.log, signals=signals), record.dynamics.axis
    late = {sensor.signal: sensor.delay for sensor in axis.sensors if sensor.delay}
    holds = dict.fromkeys(record.forces, log.sampling_period)
    return _with_noise(replace(record, log=log, late=late, holds=holds), record)


def _less(record: Record, off: ComplexArray) -> Record:
    """The record with errors taken off the measured outputs."""
    found = _with_noise(replace(record), record)
    vars(found).update(measured=record.measured - off)
    return found


def _with_noise(record: Record, measured: Record) -> Record:
    """The record with the noise of another one, which its own signals do not show."""
    vars(record).update(noise=measured.noise, noise_spread=measured.noise_spread)
    return record
