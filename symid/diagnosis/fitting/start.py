"""The axis as it is declared, fitted to a record: where to begin, and from where to restart."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from symid.axis import Axis
from symid.codegen import model_of
from symid.diagnosis.fitting.fit import Fit, converged, fitted, masses_and_stiffnesses, stiffnesses
from symid.diagnosis.fitting.state import State, first_state, with_effects
from symid.diagnosis.prediction.record import Record
from symid.diagnosis.prediction.weighting import Weighting
from symid.diagnosis.thresholds import THRESHOLDS
from symid.errors import SettingError, SymidError
from symid.identification import identify


def starting_parameters(axis: Axis, record: Record) -> dict[str, float]:
    """Physical parameters by weighted least squares on the minimal regressor.

    A mass that comes out negative, as the force has the wrong sign or hardly accelerates the axis, begins with its
    absolute value: what is wrong is said of the fit from there.
    """
    try:
        found = identify(model_of(axis, record.signals), record.log, examine=False).physical_parameters
    except SymidError as error:
        raise SettingError(f"no values to begin with can be identified ({error}): give `nominal`") from error
    lacking = [name for name in axis.physical_parameters if not np.isfinite(found.get(name, np.nan))]
    if lacking:
        raise SettingError(
            f"no values to begin with follow from the log for {', '.join(lacking)}: give `nominal`"
        )
    masses = record.dynamics.parameters_of("mass")
    values = {name: float(found[name]) for name in axis.physical_parameters}
    return {name: abs(value) if name in masses else value for name, value in values.items()}


_OTHER = (0.6, 0.77, 1.3, 1.7)
"""Multiples of a stiffness, or of the shape of a declared imperfection, from which a fit restarts."""
_FEW = 3
"""Iterations after which a fit from another stiffness that leaves more than the first is given up."""


def fitted_axis(state: State, weighting: Weighting) -> Fit:
    """The axis without effects, fitted from given values and, where these lead astray, from other stiffnesses.

    A mode that lies some widths of its resonance away from where it is sought is not found by small steps: the fit
    then lets the masses behind it grow without bound. A fit from another stiffness is taken if it leaves noise alone or
    a small share of what the first one leaves, or if it stays where the other ran away. Where none stays, the log does
    not show the spring: masses and stiffnesses are then held within the range of fits that stay.
    """
    first = _from_other_shapes(converged(state, weighting))
    springs, values = stiffnesses(state.prediction.axis), state.prediction.parameters
    if not springs or first.mean_square < THRESHOLDS.fit_of_noise:
        return first
    astray, others = _ran_away(first, values), []
    for moved in _other_values(state):
        begun = first_state(state.prediction.record, moved, weighting.allowed)
        if astray or fitted(*begun, _FEW).mean_square < first.mean_square:
            others.append(converged(*begun))
    tame = [fit for fit in others if not _ran_away(fit, values)]
    if astray and not tame:
        names = masses_and_stiffnesses(state.prediction.axis)
        return converged(state.within(THRESHOLDS.ran_away, names), weighting)
    best = min(tame, key=lambda fit: fit.mean_square, default=first)
    return best if astray or _is_clearly_better(best, first) else first


def _is_clearly_better(found: Fit, first: Fit) -> bool:
    """Whether a fit leaves noise alone, or a small share of what another leaves."""
    return found.mean_square < max(THRESHOLDS.fit_of_noise, THRESHOLDS.other_stiffness * first.mean_square)


def _other_values(state: State) -> Iterator[dict[str, float]]:
    """Values with other stiffnesses; of several drives, whose balances share springs, also those of least squares."""
    axis, values = state.prediction.axis, dict(state.prediction.parameters)
    if len(axis.drives) > 1:
        with suppress(SettingError):
            yield starting_parameters(axis, state.prediction.record)
    for factor in _OTHER:
        yield values | {name: factor * values[name] for name in stiffnesses(axis)}


def from_other_moments(fit: Fit) -> Fit:
    """The same with other moments of changes that were found, where these leave clearly less.

    All else has adapted itself to a moment at the wrong end of a slow motion, so that small steps stay there.
    """
    return _from_other_shapes(fit, ())


def _from_other_shapes(fit: Fit, factors: Sequence[float] = _OTHER) -> Fit:
    """The same with other shapes of its effects, one after the other, where these leave clearly less.

    A limit beyond the largest force and a moment at a rest are not found by small steps from the values declared.
    """
    for i in range(len(fit.state.placed)):
        if fit.mean_square < THRESHOLDS.fit_of_noise:
            break
        states = _with_other_shapes(fit.state, fit.weighting, i, factors)
        tried = [fitted(state, fit.weighting, _FEW) for state in states]
        best = min(tried, key=lambda one: one.mean_square, default=fit)
        if _is_clearly_better(best, fit):
            fit = converged(best.state, best.weighting).after(fit)
    return fit


def _with_other_shapes(
    state: State, weighting: Weighting, at: int, factors: Sequence[float]
) -> Iterator[State]:
    """States with the moments of a log for an effect that has one, with multiples of its shape for others."""
    item, others = state.placed[at], state.placed
    shapes = list(item.effect.shapes_of_log(state.prediction.record, item.shape))[1::2]
    if not shapes:
        shapes = [tuple(factor * x for x in item.shape) for factor in factors if item.shape]
    for shape in shapes:
        yield with_effects(state, weighting, (*others[:at], replace(item, shape=shape), *others[at + 1 :]))


def _ran_away(fit: Fit, start: Mapping[str, float]) -> bool:
    for name in masses_and_stiffnesses(fit.state.prediction.axis):
        low, high = sorted((start[name] / THRESHOLDS.ran_away, start[name] * THRESHOLDS.ran_away))
        if not low < fit.parameters[name] < high:
            return True
    return False
