"""The declared axis fitted to a record: initial values, and restarts from other values."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress

import numpy as np

from symid.arrays import unexplained_by
from symid.axis import Axis
from symid.codegen import model_of
from symid.diagnosis.fitting.acting_forces import law_to_integrate
from symid.diagnosis.fitting.fit import Fit, masses_and_stiffnesses, stiffnesses
from symid.diagnosis.fitting.gauss_newton import converged, fitted
from symid.diagnosis.fitting.state import State, first_state, with_effects, with_shape
from symid.diagnosis.prediction.record import Record
from symid.diagnosis.prediction.weighting import Weighting
from symid.diagnosis.thresholds import THRESHOLDS
from symid.errors import SettingError, SymidError
from symid.identification import identify_by_least_squares
from symid.output_error import identify_output_error
from symid.simulation.plants import dry_level

_SAMPLES = 4000
"""Most samples of a log from which values to begin with are sought by the output error."""


def starting_parameters(axis: Axis, record: Record) -> dict[str, float]:
    """Physical parameters by weighted least squares on the minimal regressor, or else by the output error.

    The noise of a coarse encoder may hide a spring from a regressor with high derivatives, whose stiffness or mass is
    then negative. If the output error finds a negative mass too, from a force of the wrong sign or one that hardly
    accelerates the axis, its absolute value is taken; the fit from there shows the fault.
    """
    model = model_of(axis, record.signals)
    try:
        found = identify_by_least_squares(model, record.log, examine=False).physical_parameters
    except SymidError as error:
        raise SettingError(f"no values to begin with can be identified ({error}): give `nominal`") from error
    lacking = [name for name in axis.physical_parameters if not np.isfinite(found.get(name, np.nan))]
    if lacking:
        raise SettingError(
            f"no values to begin with follow from the log for {', '.join(lacking)}: give `nominal`"
        )
    positive = masses_and_stiffnesses(axis)
    if stiffnesses(axis) and any(found[name] <= 0 for name in positive):
        part = record.log.window(0, min(_SAMPLES, record.log.n_samples))
        with suppress(SymidError, ArithmeticError, np.linalg.LinAlgError):
            other = identify_output_error(axis, model, part).physical_parameters
            if all(other[name] > 0 for name in positive) and np.isfinite(list(other.values())).all():
                found = other
    masses = record.dynamics.parameters_of("mass")
    values = {name: float(found[name]) for name in axis.physical_parameters}
    return {name: abs(value) if name in masses else value for name, value in values.items()}


_OTHER = (0.6, 0.77, 1.3, 1.7)
"""Multiples of a stiffness, or of the shape of a declared imperfection, from which a fit restarts."""
_FEW = 3
"""Iterations after which a restart is given up if it leaves more error than the first fit."""
_TRIED = 4
"""Most other shapes of an effect from which a fit restarts."""


def fitted_axis(state: State, weighting: Weighting) -> Fit:
    """The axis without effects, fitted from given values.

    If dry friction is declared at hidden motion and the fit leaves a clear gap, this motion is observed instead of
    predicted where far less is left then, see `hidden_motion`.
    """
    predicted = _with_restarts(state, weighting)
    if predicted.mean_square < THRESHOLDS.clear_gap or not _has_dry_hidden_motion(state):
        return predicted
    record, parameters = state.prediction.record, state.prediction.parameters
    observed = _with_restarts(*first_state(record, parameters, weighting.allowed, follows=True))
    return observed if observed.mean_square < THRESHOLDS.follows * predicted.mean_square else predicted


def _has_dry_hidden_motion(state: State) -> bool:
    """Whether dry friction that the axis declares is integrated with hidden motion."""
    prediction = state.prediction
    joints = prediction.record.dynamics.laws
    if any(dry_level(joints[i].terms[k].code) for i, k in prediction.integrated_terms):
        return True
    laws = (law_to_integrate(prediction, item) for item in state.placed if item.integrated)
    return any(law is not None and law.dry for law in laws)


def _with_restarts(state: State, weighting: Weighting) -> Fit:
    """The axis fitted from given values and, if that fails, from other stiffnesses.

    Small steps do not find a resonance that is several bandwidths away from the initial one: the fit then increases the
    masses on the spring without bound. A restart from another stiffness is taken if it leaves only noise or a small
    share of the first error, or if it stays bounded where the first fit did not. If no restart stays bounded, the log
    does not show the spring, and masses and stiffnesses are bounded.
    """
    first = _from_other_shapes(converged(state, weighting))
    springs, values = stiffnesses(state.prediction.axis), state.prediction.parameters
    if not springs or first.mean_square < THRESHOLDS.fit_of_noise:
        return first
    astray, others = _ran_away(first, values), []
    for moved in _other_values(state):
        begun = first_state(
            state.prediction.record, moved, weighting.allowed, follows=state.prediction.follows
        )
        if astray or fitted(*begun, _FEW).mean_square < first.mean_square:
            others.append(converged(*begun))
    tame = [fit for fit in others if not _ran_away(fit, values)]
    if astray and not tame:
        names = masses_and_stiffnesses(state.prediction.axis)
        return converged(state.within(THRESHOLDS.ran_away, names), weighting)
    best = min(tame, key=lambda fit: fit.mean_square, default=first)
    return best if astray or _is_clearly_better(best, first) else first


def _is_clearly_better(found: Fit, first: Fit) -> bool:
    """Whether a fit leaves only noise, or a small share of the error of another."""
    return found.mean_square < max(THRESHOLDS.fit_of_noise, THRESHOLDS.other_stiffness * first.mean_square)


def _other_values(state: State) -> Iterator[dict[str, float]]:
    """Values with other stiffnesses; with several drives, whose equations share springs, first least squares."""
    axis, values = state.prediction.axis, dict(state.prediction.parameters)
    if len(axis.drives) > 1:
        with suppress(SettingError):
            yield starting_parameters(axis, state.prediction.record)
    for factor in _OTHER:
        yield values | {name: factor * values[name] for name in stiffnesses(axis)}


def from_other_moments(fit: Fit) -> Fit:
    """The fit with other moments of the changes found, where these leave clearly less error.

    All other values have adapted to a moment at the wrong end of a slow motion, so small steps do not leave it.
    """
    return _from_other_shapes(fit, ())


def _from_other_shapes(fit: Fit, factors: Sequence[float] = _OTHER) -> Fit:
    """The fit with other shapes of its effects, one effect at a time, where these leave clearly less error.

    Small steps from the declared values find neither a limit beyond the largest force nor a moment during a rest.
    """
    for i in range(len(fit.state.placed)):
        if fit.mean_square < THRESHOLDS.fit_of_noise:
            break
        states = list(_with_other_shapes(fit.state, fit.weighting, i, factors))
        tried = [fitted(state, fit.weighting, _FEW) for state in _most_promising(fit, i, states)]
        best = min(tried, key=lambda one: one.mean_square, default=fit)
        if _is_clearly_better(best, fit):
            fit = converged(best.state, best.weighting).after(fit)
    return fit


def _most_promising(fit: Fit, at: int, states: Sequence[State]) -> list[State]:
    """The few of many states that would leave least after a step of all other values and of the effect's size."""
    if len(states) <= _TRIED:
        return list(states)
    others = np.delete(fit.projected_columns, fit.state.values_of[at], axis=0)
    placed = fit.state.placed
    plain = Fit(
        with_effects(fit.state, fit.weighting, (*placed[:at], *placed[at + 1 :])), fit.weighting
    ).error

    def left(state: State) -> float:
        error = Fit(state, fit.weighting).error
        columns = np.concatenate([others, [plain - error]])
        return float(np.sum(unexplained_by(columns.T, error) ** 2))

    return sorted(states, key=left)[:_TRIED]


def _with_other_shapes(
    state: State, weighting: Weighting, at: int, factors: Sequence[float]
) -> Iterator[State]:
    """States with other moments in the log for an effect that has one, with multiples of its shape for others."""
    item = state.placed[at]
    shapes = list(item.effect.shapes_of_log(state.prediction, item))[1::2]
    if not shapes:
        shapes = [tuple(factor * x for x in item.shape) for factor in factors if item.shape]
    for shape in shapes:
        yield with_shape(state, weighting, at, shape)


def _ran_away(fit: Fit, start: Mapping[str, float]) -> bool:
    for name in masses_and_stiffnesses(fit.state.prediction.axis):
        low, high = sorted((start[name] / THRESHOLDS.ran_away, start[name] * THRESHOLDS.ran_away))
        if not low < fit.parameters[name] < high:
            return True
    return False
