"""Damped Gauss-Newton steps that fit the values of a model, within the bounds of machines."""

import math
from collections.abc import Sequence, Set
from dataclasses import replace

import numpy as np

from symid.arrays import BoolArray, FloatArray, norms_or_one
from symid.diagnosis.effects import Key, Placed, declared_effects
from symid.diagnosis.fitting.fit import Fit, stiffnesses
from symid.diagnosis.fitting.moments import with_best_moments
from symid.diagnosis.fitting.state import State, evaluated, leveled
from symid.diagnosis.prediction.weighting import Weighting, with_restarts
from symid.diagnosis.thresholds import THRESHOLDS
from symid.errors import SettingError, SymidError

_LARGEST_SHAPE_STEP = 0.3
_LARGEST_MOMENT_STEP = 0.01
"""Largest step of the moment of a change, relative to the log: its derivative is valid only nearby."""
_SMALLER = 0.3
"""Least factor by which a mass or stiffness may change in a step, which keeps it positive."""
_DAMPINGS = (0.0, 1e-4, 1e-2, 0.3, 5.0)
"""Damping relative to the squares of the columns; the last one leaves a sixth of the steepest-descent step."""
_SETTLED = 1e-5
"""Least relative decrease of the sum of squares in a step; with thousands of rows, a few percent of likelihood."""
RANK = 1e-10
"""Relative singular value of unit columns below which a combination of them counts as undetermined."""
ITERATIONS = 10
"""Most iterations of a fit that may begin far off."""
_MOST_FITS, _FALLS = 6, 0.98
"""Most fits that continue another, as long as each leaves less than this share of the error before it."""
_HALVINGS = 10
"""Halvings of the way to a bound, which is then missed by a thousandth of a step."""


def fitted(state: State, weighting: Weighting, iterations: int = 6, free: BoolArray | None = None) -> Fit:
    """Fit a state and its effects by Gauss-Newton steps; `free` marks the values that may change."""
    return continued(Fit(state, weighting), iterations, free)


def continued(fit: Fit, iterations: int, free: BoolArray | None = None) -> Fit:
    """A fit after further Gauss-Newton steps."""
    for _ in range(iterations):
        found = _step_within_bounds(fit, free)
        if found is None:
            break
        before, fit = fit.cost, found
        if fit.cost > before * (1 - _SETTLED):
            break
    return fit


def with_shapes_held(fit: Fit) -> Fit:
    """A fit after a step of all values but the shapes of effects; the error is mostly linear in these."""
    moves = np.ones(len(fit.columns), dtype=bool)
    for item, values in zip(fit.state.placed, fit.state.values_of, strict=True):
        moves[values.stop - len(item.shape) : values.stop] = False
    return continued(fit, 1, moves)


def refitted(fit: Fit, iterations: int = 3) -> Fit:
    """Fit again with an unknown state of the hidden motion after each standstill."""
    weighting = with_restarts(fit.weighting, fit.state.hidden)
    return continued(fit.with_weights(fit.state.weighted(weighting), weighting), iterations)


def converged(state: State, weighting: Weighting) -> Fit:
    """Fit from a state, then fit again with the weights of the result, see `settled`.

    A model that has lost its inertia keeps the first weights: its own would allow for more noise of the position, which
    would lower the inertia further, down to nothing.
    """
    start = settled(Fit(state, weighting))
    first = continued(start, ITERATIONS)
    again = first
    if keeps_inertia(first.state, state.inertia):
        again = refitted(settled(first))
    kept = keeps_inertia(again.state, state.inertia)
    return replace(again if kept else first, initial_inertia=state.inertia)


def fitted_on(fit: Fit) -> Fit:
    """A fit continued with its own weights until the error hardly falls, from the best moments of changes.

    The selection stops fitting a model as soon as it can choose.
    """
    fit = with_best_moments(fit)
    for _ in range(_MOST_FITS):
        try:
            after = converged(fit.state, fit.weighting).after(fit)
        except (SymidError, ArithmeticError, np.linalg.LinAlgError):
            return fit
        if not after.mean_square < fit.mean_square:
            return fit
        before, fit = fit, after
        if not after.mean_square < _FALLS * before.mean_square:
            break
    return fit


def settled(fit: Fit) -> Fit:
    """The same values with weights computed from them, which allow for the remaining error."""
    state, weighting = leveled(fit.state, fit.weighting.allowed, fit.levels)
    weighting = with_restarts(weighting, state.hidden)
    return fit.with_weights(state.weighted(weighting), weighting)


def keeps_inertia(found: State, *plain: float, tolerance: float = 0.0) -> bool:
    """Whether the inertia that the drive moves is within a factor of two of the range `plain` of other models.

    `tolerance` is a further relative deviation, allowed where the log does not determine the inertia.
    """
    low, high = min(plain) / THRESHOLDS.least_inertia, max(plain) * THRESHOLDS.least_inertia
    return low / (1 + tolerance) < found.inertia < high * (1 + tolerance)


def _step_within_bounds(fit: Fit, free: BoolArray | None) -> Fit | None:
    """The next step of a fit, with declared effects within the bounds of machines; None if no step lowers the cost.

    Where a step leaves a bound, the effect goes to its bound and the other values take a step again (active set).
    """
    found = _stepped(fit, free)
    if found is None or not (outside := beyond_bounds(found.state)):
        return found
    held = _free_without(fit, free, outside)
    placed = moved_to_bounds(fit.state, found.state.placed, outside)
    bound = Fit(evaluated(fit.state, fit.weighting, fit.parameters, placed), fit.weighting)
    after = _stepped(bound, held) or bound
    return after if after.cost < fit.cost else _stepped(fit, held)


def _free_without(fit: Fit, free: BoolArray | None, keys: set[Key]) -> BoolArray:
    """The values that may change, without those of some effects."""
    moves = np.ones(len(fit.columns), dtype=bool) if free is None else free.copy()
    for item, values in zip(fit.state.placed, fit.state.values_of, strict=True):
        moves[values] &= item.key not in keys
    return moves


def _stepped(fit: Fit, free: BoolArray | None) -> Fit | None:
    """The least damped Levenberg-Marquardt step that lowers the cost; None if no step lowers it noticeably.

    Damping restrains only directions to which the rows are hardly sensitive, such as a stiffness and the mass on it in
    a fixed ratio; a shorter step would restrain all directions.
    """
    state, weighting, error, flat = fit.state, fit.weighting, fit.error, fit.projected_columns
    if not (np.isfinite(flat).all() and np.isfinite(error).all()):
        return None
    moves = ~_damping_held_at_zero(state, flat @ error)
    moves = moves if free is None else moves & free
    flat = flat[moves]
    scale = norms_or_one(flat, axis=1)
    flat /= scale[:, None]
    normal, gradient = flat @ flat.T, flat @ error
    try:
        undamped = np.linalg.lstsq(flat.T, error, rcond=RANK)[0] / scale
    except np.linalg.LinAlgError:
        undamped = np.zeros(len(flat))
    # The undamped step predicts the largest possible decrease of the cost.
    if (gradient * scale) @ undamped < _SETTLED * fit.cost:
        return None
    for damping in _DAMPINGS:
        try:
            left = normal + damping * np.eye(len(normal))
            step = np.linalg.lstsq(left, gradient, rcond=RANK)[0] / scale if damping else undamped
            whole = np.zeros(moves.size)
            whole[moves] = step
            with np.errstate(over="ignore", invalid="ignore"):  # a motion without bound costs more
                found = Fit(evaluated(state, weighting, *_moved(state, whole)), weighting)
                if found.cost < fit.cost:
                    return found
        except (SettingError, np.linalg.LinAlgError, OverflowError):  # masses not positive, motion unbounded
            continue
    return None


def _damping_held_at_zero(state: State, downhill: FloatArray) -> BoolArray:
    """Dampings at zero that the steepest descent would lower; the others step without them (active set).

    A mass at its bound marks a model that has lost its inertia, which no step needs to improve.
    """
    held = np.zeros(downhill.size, dtype=bool)
    for i, name in enumerate(state.prediction.record.dynamics.parameters):
        at_zero = state.prediction.parameters[name] == state.bounds.get(name, (-math.inf, 0.0))[0] == 0.0
        held[i] = at_zero and downhill[i] < 0
    return held


def _moved(state: State, step: FloatArray) -> tuple[dict[str, float], tuple[Placed, ...]]:
    parameters = dict(state.prediction.parameters)
    names = state.prediction.record.dynamics.parameters
    masses = state.prediction.record.dynamics.parameters_of("mass")
    positive = {*masses, *stiffnesses(state.prediction.axis)}
    for name, change in zip(names, step, strict=False):
        moved_to = parameters[name] + float(change)
        if name in positive and parameters[name] > 0:
            moved_to = max(moved_to, _SMALLER * parameters[name])
        if name in state.bounds:
            low, high = state.bounds[name]
            moved_to = min(max(moved_to, low), high)
        parameters[name] = moved_to
    placed = []
    for item, values in zip(state.placed, state.values_of, strict=True):
        limits = [math.inf] * (item.n_free - len(item.shape)) + [
            _LARGEST_MOMENT_STEP * state.prediction.record.duration
            if name in item.effect.moments
            else _LARGEST_SHAPE_STEP * abs(x)
            for name, x in zip(item.effect.shape_names, item.shape, strict=True)
        ]
        changes = np.clip(step[values], np.negative(limits), limits)
        moved = item.with_free([float(x + c) for x, c in zip(item.free, changes, strict=True)])
        bounded = item.effect.bounded(state.prediction, item.at, moved.shape)
        # A shape that was declared beyond the bounds of a search is not brought back to them.
        within = item.effect.bounded(state.prediction, item.at, item.shape) == item.shape
        placed.append(replace(moved, shape=bounded) if within else moved)
    return parameters, tuple(placed)


def beyond_bounds(state: State) -> set[Key]:
    """Declared effects with values that no machine has."""
    declared = {item.key for item in declared_effects(state.prediction)}
    return {
        item.key
        for item in state.placed
        if item.key in declared and not item.effect.is_possible(state.prediction, item)
    }


def moved_to_bounds(state: State, moved: Sequence[Placed], outside: Set[Key]) -> tuple[Placed, ...]:
    """Effects of a state, those `outside` with the last possible values on their way to the `moved` ones."""
    return tuple(
        _to_bound(state, own, target) if own.key in outside else own
        for own, target in zip(state.placed, moved, strict=True)
    )


def _to_bound(state: State, possible: Placed, impossible: Placed) -> Placed:
    """The last possible values between two, by bisection."""
    for _ in range(_HALVINGS):
        middle = possible.with_free(
            [(a + b) / 2 for a, b in zip(possible.free, impossible.free, strict=True)]
        )
        if middle.effect.is_possible(state.prediction, middle):
            possible = middle
        else:
            impossible = middle
    return possible
