"""A model with values on a record: physical parameters, effects, and the errors that they leave.

A law in a joint without a sensor is evaluated at the hidden motion of the model. This motion follows from the measured
motion and the forces of the previous state.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import accumulate, chain, pairwise

import numpy as np

from symid.arrays import BoolArray, ComplexArray, FloatArray
from symid.diagnosis.effects import FreeForce, Placed, Shape, declared_effects
from symid.diagnosis.fitting.acting_forces import changes_by_others, law_to_integrate, next_prediction
from symid.diagnosis.prediction.prediction import Prediction, prediction_of
from symid.diagnosis.prediction.record import Record
from symid.diagnosis.prediction.weighting import Weighting, starting_pulses, weighting_of
from symid.errors import LogError

_TAKES_PART = 0.2
_LEAST_ROWS, _LEAST_HELD_OUT = 20, 8
_BALANCED = 3
"""Further iterations for an implicit force: friction of half the load is then accurate to 6 %, and the next step
continues from there. One is enough for nearby values, which begin at the balance of the others."""


@dataclass(frozen=True, eq=False)
class State:
    """A model with values, under a record."""

    prediction: Prediction  # motion and prediction
    placed: tuple[Placed, ...]  # effects with values
    weighting: Weighting  # of the errors
    # least and largest values of parameters that a fit may take, SI
    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def with_least(self, share: float, nominal: Mapping[str, float]) -> State:
        """The state with lower bounds of the masses: a share of their values, or of smaller nominal ones."""
        own = self.prediction.parameters
        names = self.prediction.record.dynamics.parameters_of("mass")
        least = {name: min(abs(own[name]), abs(nominal.get(name, own[name]))) for name in names}
        bounds = {name: (share * value, math.inf) for name, value in least.items()}
        return replace(self, bounds=dict(self.bounds) | bounds)

    def within(self, factor: float, names: Iterable[str]) -> State:
        """The state with parameters bounded to within a factor of their values."""
        own = self.prediction.parameters
        bounds = {name: (own[name] / factor, own[name] * factor) for name in names}
        return replace(self, bounds=dict(self.bounds) | bounds)

    @property
    def inertia(self) -> float:
        """Inertia that the drive moves, see `Response.inertia`."""
        return self.prediction.response.inertia

    @property
    def values_of(self) -> tuple[slice, ...]:
        """Places of the free values of each effect among the columns of a fit, after those of the parameters."""
        first = len(self.prediction.record.dynamics.parameters)
        edges = accumulate((item.n_free for item in self.placed), initial=first)
        return tuple(slice(begin, end) for begin, end in pairwise(edges))

    @property
    def is_integrated(self) -> bool:
        """Whether hidden motion is integrated in time."""
        return bool(self.prediction.integrated_terms) or any(item.integrated for item in self.placed)

    def following(self) -> State:
        """The state whose hidden motion is observed with the measured force from the next evaluation on.

        Dampings are then bounded at 0: with a negative one, much weaker friction oscillates as much, and fits end
        there.
        """
        names = self.prediction.record.dynamics.parameters_of("damping")
        bounds = dict(self.bounds) | dict.fromkeys(names, (0.0, math.inf))
        return replace(self, prediction=replace(self.prediction, follows=True), bounds=bounds)

    def weighted(self, weighting: Weighting) -> State:
        """The state with other weights."""
        return with_errors(replace(self, weighting=weighting), self.errors)

    def released(self, weighting: Weighting) -> State:
        """The state without cached arrays, which are recomputed on demand, and with weights that have none."""
        return replace(self, prediction=self.prediction.released(), weighting=weighting)

    @cached_property
    def errors(self) -> ComplexArray:
        """Measured less predicted outputs, of shape (n_outputs, n_bins)."""
        return output_errors(self.prediction, self.placed)

    @cached_property
    def rows(self) -> FloatArray:
        """Weighted errors, of shape (n_outputs, n_rows)."""
        return self.weighting.rows(self.errors)

    @property
    def hidden(self) -> tuple[ComplexArray, ...]:
        """Outputs for forces on hidden motion, after delays and lags."""
        return tuple(map(self.prediction.passed_on, self.prediction.hidden))

    @cached_property
    def beginning(self) -> FloatArray:
        """Contribution of an unknown state at the beginning of the log to the rows, (n_starts, n_outputs, n_rows)."""
        response = self.prediction.response
        free = (
            self.prediction.passed_on(spectrum * response.of_force(direction))
            for direction, spectrum in free_forces(self.prediction, self.placed)
        )
        return self.weighting.rows(starting_pulses(self.prediction.record, tuple(free)))


def free_forces(prediction: Prediction, placed: Iterable[Placed]) -> tuple[FreeForce, ...]:
    """Forces that excite hidden motion, of effects too: directions over the bodies, and spectra."""
    unit = np.ones(prediction.record.n_bins, dtype=complex)
    of_effects = (item.effect.free_forces(prediction, item) for item in placed)
    return (
        *((direction, unit) for direction in prediction.free_directions),
        *chain.from_iterable(of_effects),
    )


def first_state(
    record: Record,
    parameters: Mapping[str, float],
    allowed: BoolArray | None = None,
    *,
    held_out: bool = False,
    follows: bool = False,
) -> tuple[State, Weighting]:
    """The axis at given parameters with its declared imperfections, and its weighting on allowed parts of the log.

    A `held_out` record needs fewer rows: a gap is measured on it, and nothing is fitted. Hidden motion `follows` the
    measured force, or not.
    """
    prediction = prediction_of(record, parameters)
    prediction = prediction_of(record, parameters, before=prediction)
    weighting = weighting_in(prediction, allowed)
    least = _LEAST_HELD_OUT if held_out else _LEAST_ROWS
    if weighting.kept.sum() < least:
        raise LogError(
            f"log {record.log.source!r} has {weighting.kept.sum()} independent rows of motion, {least} are "
            f"needed: it is compared up to {record.band_hz:.3g} Hz, where its position still exceeds its noise, and "
            "rests are left out; take a longer log, one that moves more or is read finer, or a second one for the "
            "validation"
        )
    first = State(prediction, (), weighting)
    first = first.following() if follows else first
    declared = tuple(
        replace(item, integrated=law_to_integrate(prediction, item) is not None)
        for item in declared_effects(prediction)
    )
    return with_effects(first, weighting, declared) if declared or record.hidden_terms else first, weighting


def leveled(state: State, allowed: BoolArray | None, levels: Sequence[float]) -> tuple[State, Weighting]:
    """The state with weights computed from its parameters, which allow for errors of the model.

    `levels` are the errors of the outputs in multiples of their noise; `allowed` are parts of the log that may be used.
    """
    prediction = state.prediction.leveled(levels)
    weighting = weighting_in(prediction, allowed)
    found = replace(state, prediction=prediction, weighting=weighting)
    return with_errors(found, state.errors), weighting


def with_errors(state: State, errors: ComplexArray) -> State:
    """The state with errors that are known already, or with others."""
    found = replace(state)
    vars(found)["errors"] = errors
    return found


def weighting_in(prediction: Prediction, allowed: BoolArray | None) -> Weighting:
    """Weights of a prediction: all joints that take part in the drives' motion must move."""
    driven = prediction.record.fine(prediction.record.motions)[:, prediction.record.in_log]
    least = _TAKES_PART * np.ptp(driven, axis=1).max()
    speeds = [joint.v for joint in prediction.joints.values() if joint.stroke > least]
    return weighting_of(prediction.record, prediction.density, speeds, allowed)


def with_effects(state: State, weighting: Weighting, placed: tuple[Placed, ...]) -> State:
    """The state with other effects."""
    return evaluated(state, weighting, state.prediction.parameters, placed)


def stable_with_effects(state: State, weighting: Weighting, placed: tuple[Placed, ...]) -> State | None:
    """The same; None if the hidden motion grows without bound."""
    try:
        return with_effects(state, weighting, placed)
    except OverflowError:
        return None


def with_shape(state: State, weighting: Weighting, at: int, shape: Shape) -> State:
    """The state with another shape of the effect at an index."""
    placed = state.placed
    moved = replace(placed[at], shape=shape)
    return with_effects(state, weighting, (*placed[:at], moved, *placed[at + 1 :]))


def evaluated(
    state: State, weighting: Weighting, parameters: Mapping[str, float], placed: tuple[Placed, ...]
) -> State:
    """The state with other parameters and effects, whose forces are computed from the motion of the given state."""
    prediction, errors = predicted(state, parameters, placed)
    return with_errors(State(prediction, placed, weighting, state.bounds), errors)


def predicted(
    state: State, parameters: Mapping[str, float], placed: tuple[Placed, ...], *, nearby: bool = False
) -> tuple[Prediction, ComplexArray]:
    """The prediction with other parameters and effects, and the errors that it leaves.

    For `nearby` values the frequency response is kept; it matters little where hidden motion is integrated.
    """
    prediction = next_prediction(state.prediction, parameters, placed, nearby=nearby)
    if any(item.effect.implicit and not item.integrated for item in placed):
        for _ in range(1 if nearby else _BALANCED):
            prediction = next_prediction(prediction, parameters, placed, nearby=nearby)
    return prediction, output_errors(prediction, placed)


def output_errors(prediction: Prediction, placed: Sequence[Placed]) -> ComplexArray:
    """Measured less predicted outputs with effects, of shape (n_outputs, n_bins)."""
    errors = prediction.record.measured - prediction.passed_on(as_read(prediction, placed))
    return errors if prediction.path is None else errors - prediction.path.withheld


def as_read(prediction: Prediction, placed: Sequence[Placed]) -> ComplexArray:
    """Outputs with errors of the readings and changes of masses in them, before delays and lags."""
    integrates = prediction.of_integrated is not None
    return prediction.outputs + changes_by_others(prediction, placed, integrates=integrates)
