"""A fitted model on another record: its errors there, and the values that belong to a log."""

from collections.abc import Sequence

import numpy as np

from symid.arrays import BoolArray, FloatArray, unexplained_by
from symid.diagnosis.effects import Placed
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.gauss_newton import ITERATIONS, RANK, fitted
from symid.diagnosis.fitting.moments import timed
from symid.diagnosis.fitting.sensitivity import prediction_jacobian
from symid.diagnosis.fitting.state import State, first_state, leveled, with_effects
from symid.diagnosis.prediction.record import Record
from symid.diagnosis.prediction.weighting import Weighting, with_restarts

_SETTLING = 4  # rounds in which effects that depend on each other's motion settle


def applied(
    model: State, record: Record, allowed: BoolArray | None = None, placed: Sequence[Placed] | None = None
) -> tuple[State, Weighting]:
    """A model with its values on another record, with its own or other effects, and the weighting there."""
    effects = model.placed if placed is None else tuple(placed)
    state, weighting = first_state(
        record, model.prediction.parameters, allowed, held_out=True, follows=model.prediction.follows
    )
    if model.prediction.levels:
        state, weighting = leveled(state, allowed, _levels_on(record, model))
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(_SETTLING if effects else 0):
            state = with_effects(state, weighting, effects)
        state = timed(state, weighting, Fit(model, model.weighting))
    weighting = with_restarts(weighting, state.hidden)
    return state.weighted(weighting), weighting


def applied_or_none(
    model: State | None, record: Record, allowed: BoolArray | None, weighting: Weighting
) -> State | None:
    """A model under a record; None without a model, or if its hidden motion diverges there."""
    if model is None:
        return None
    try:
        return applied(model, record, allowed)[0].weighted(weighting)
    except OverflowError:
        return None


def _levels_on(record: Record, model: State) -> list[float]:
    """Errors of a model that weights allow for, in multiples of the noise of another record, which may be lower."""
    own = model.prediction.record
    errors = dict(zip(own.outputs, np.array(model.prediction.levels) * own.noise_of_outputs, strict=True))
    levels = [errors[name] for name in record.outputs] / record.noise_of_outputs
    return [float(x) for x in np.maximum(levels, 1.0)]


def errors_of(state: State, weighting: Weighting) -> FloatArray:
    """Weighted errors without the part of unknown initial states and values of the log; nan in rows not kept."""
    error = weighting.projected(state.rows, state.beginning)
    of_log = belongs_to_log(state)
    if of_log.any():
        columns = weighting.projected(weighting.rows(prediction_jacobian(state)[of_log]), state.beginning)
        error = unexplained_by(columns.T, error, RANK)
    rows = np.full(state.rows.shape, np.nan)
    rows[:, weighting.kept] = error.reshape(len(rows), -1)
    return rows


def fitted_to_log(state: State, weighting: Weighting) -> State:
    """The state with phases, moments and zeros fitted to its log; all other values stay."""
    of_log = belongs_to_log(state)
    return fitted(state, weighting, ITERATIONS, of_log).state if of_log.any() else state


def belongs_to_log(state: State) -> BoolArray:
    """Free values that belong to the log, shape (n_columns,): parameters declared so, and effects in time."""
    dynamics = state.prediction.record.dynamics
    own = [name in dynamics.axis.log_parameters for name in dynamics.parameters]
    for item in state.placed:
        free = 0 if item.effect.fixed else len(item.amplitudes)
        own += [item.effect.per_log] * (free + len(item.shape))
    return np.array(own, dtype=bool)
