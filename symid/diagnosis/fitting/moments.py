"""Search for the moments of changes in a log, such as that of a payload.

The error is flat in a moment, apart from noise, while the axis rests or moves at constant speed, and has a valley as
narrow as the band allows where it accelerates. Derivatives do not lead there: a moment is found by trials.
"""

import math
from collections.abc import Iterable
from dataclasses import replace
from itertools import chain

from symid.arrays import ComplexArray
from symid.diagnosis.effects import Placed, Shape
from symid.diagnosis.fitting.acting_forces import changes_outputs
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.state import State, with_effects, with_shape
from symid.diagnosis.prediction.weighting import Weighting
from symid.diagnosis.thresholds import THRESHOLDS

_FIRST_STEP, _LAST_STEP = 0.02, 0.1
"""Steps by which a moment is moved: relative to the log, and in periods of the highest frequency used."""
NEAR, ANYWHERE = 0.06, 1.0
"""How far from the best moment found others are tried closely, relative to the log: first near it, then in all of it
where much is left."""
_GROWTH = 1.5
_POSSIBLE, _FLUCTUATES = 3.0, 4.0
"""Growth of the steps to the end of the time in which a moment may lie; its limit in standard deviations, and the rise
of the sum of squares beyond it, relative to that limit, from which on no later moment is tried: it fluctuates."""


def timed(state: State, weighting: Weighting, before: Fit | None = None) -> State:
    """The state with the best-fitting shapes of effects whose shapes belong to a log, and moments.

    The values come from a fit to another log, `before`, if one is given: where no more is left here than there, no
    moment is tried closely, and of a model that leaves a clear gap there only those near the best one are.
    """
    for i in range(len(state.placed)):
        shapes = state.placed[i].effect.shapes_of_log(state.prediction, state.placed[i])
        state = _enclosed(_best(state, weighting, i, shapes), weighting, i)
        state = _timed_closely(state, weighting, i, before)
    return state


def with_best_moments(fit: Fit) -> Fit:
    """The fit with the moments of all its effects found again, other values held."""
    state = fit.state
    for i in range(len(state.placed)):
        state = _timed_closely(_enclosed(state, fit.weighting, i), fit.weighting, i)
    return fit if state is fit.state else Fit(state, fit.weighting).after(fit)


def _timed_closely(state: State, weighting: Weighting, at: int, before: Fit | None = None) -> State:
    """The state, or one with another moment at which a body begins to ring, where that leaves far less.

    The error has a valley of some milliseconds at such a moment and does not show the way to it from outside.
    """
    item, fit = state.placed[at], Fit(state, weighting)
    for reach, enough in ((NEAR, THRESHOLDS.explained), (ANYWHERE, THRESHOLDS.clear_gap)):
        shapes = list(item.effect.close_shapes(state.prediction, item, reach))
        least = before.mean_square if before and shapes else 0.0
        if not shapes or fit.mean_square < max(enough, least / THRESHOLDS.far_less):
            break
        if reach == ANYWHERE and least > THRESHOLDS.clear_gap:
            break
        other = _enclosed(_best(state, weighting, at, shapes), weighting, at)
        if Fit(other, weighting).mean_square < THRESHOLDS.far_less * fit.mean_square:
            return other
    return state


def _enclosed(state: State, weighting: Weighting, at: int) -> State:
    """The state with the moments of an effect found by halving steps."""
    record, names = state.prediction.record, state.placed[at].effect.moments
    step = _FIRST_STEP * record.duration if names else 0.0
    while step > _LAST_STEP / record.band_hz:
        item = state.placed[at]
        moved = (_moved(item, name, d) for name in names for d in (-step, step))
        state, step = _best(state, weighting, at, moved), step / 2
    return state


def moment_deviation(fit: Fit, at: int, name: str) -> float:
    """Standard deviation of a moment of the effect at an index, s, as of a uniform distribution.

    Other values held, the moment may lie as far as the sum of squares rises by less than that of three deviations.
    """
    item, record = fit.state.placed[at], fit.state.prediction.record
    rise = _POSSIBLE**2 * fit.mean_square

    def reach(sign: float) -> float:
        step = furthest = _LAST_STEP / record.band_hz
        risen = 0.0
        while risen < _FLUCTUATES * rise and step < record.duration:
            moved = with_shape(fit.state, fit.weighting, at, _moved(item, name, sign * step))
            risen = Fit(moved, fit.weighting).cost - fit.cost
            step *= _GROWTH
            if risen < rise:
                furthest = step
        return furthest

    return min(reach(-1.0) + reach(1.0), record.duration) / math.sqrt(12.0)


def _moved(item: Placed, name: str, by: float) -> Shape:
    """The shape of an effect with one of its moments moved."""
    k = item.effect.shape_names.index(name)
    return (*item.shape[:k], item.shape[k] + by, *item.shape[k + 1 :])


def _best(state: State, weighting: Weighting, at: int, shapes: Iterable[Shape]) -> State:
    """The state, or the one with another shape of an effect, that leaves least."""
    if _adds_to_outputs(state, at):
        shapes = _best_addition(state, weighting, at, shapes)
    tried = (with_shape(state, weighting, at, shape) for shape in shapes)
    return min(chain((state,), tried), key=lambda one: Fit(one, weighting).cost)


def _adds_to_outputs(state: State, at: int) -> bool:
    """Whether an effect changes the outputs alone, and neither the motion nor the forces of other effects."""
    implicit = state.prediction.follows or any(item.effect.implicit for item in state.placed)
    return changes_outputs(state.placed[at]) and not (state.is_integrated or implicit)


def _best_addition(state: State, weighting: Weighting, at: int, shapes: Iterable[Shape]) -> list[Shape]:
    """The best shape of such an effect, or none of no shapes; the contribution of other effects is computed once."""
    item, beside = state.placed[at], with_effects(state, weighting, state.placed)
    prediction = beside.prediction

    def change(shape: Shape) -> ComplexArray:
        return prediction.passed_on(replace(item, shape=shape).change(prediction))

    without = beside.errors + change(item.shape)

    def cost(shape: Shape) -> float:
        left = weighting.projected(weighting.rows(without - change(shape)), beside.beginning)
        return float(left @ left)

    return sorted(shapes, key=cost)[:1]
