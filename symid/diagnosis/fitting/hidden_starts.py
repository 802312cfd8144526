"""Initial values of a fit whose effect acts on hidden motion.

Hidden motion depends on the model and the effect together, so that the error has many minima. A fit begins with the
values of the same effect at a measured joint, and at the best points of a grid over the stiffness and mass of the
hidden body and the size of the effect, each integrated once.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain, product

import numpy as np

from symid.axis import Between, Body, Spring
from symid.diagnosis.effects import BacklashEffect, Effect, JointEffect, Key, Placed, Shape
from symid.diagnosis.fitting.acting_forces import law_to_integrate
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.gauss_newton import with_shapes_held
from symid.diagnosis.fitting.moments import NEAR
from symid.diagnosis.fitting.state import State, evaluated, first_state, stable_with_effects, with_effects
from symid.diagnosis.prediction.joint import RecordedJoint
from symid.diagnosis.prediction.places import place_of
from symid.diagnosis.prediction.prediction import Prediction
from symid.diagnosis.prediction.weighting import Weighting
from symid.diagnosis.thresholds import THRESHOLDS
from symid.simulation.plants import direction_of

_STIFFNESSES = (0.75, 0.87, 1.0, 1.15, 1.3)
_MASSES = (0.9, 1.1)
_SHARES = (1.0, 0.3, 0.1, 0.03)
"""Shares of the projected amplitudes with which a fit may begin."""
_MULTIPLES = (30.0, 10.0, 3.0)
"""Multiples of them with which a fit of integrated motion may begin too: a projection does not contain the change of
the motion by the effect and may be far too small."""
_LOWERED = 0.97
"""Ratio of the sums of squares below which a change during the log is a start."""
_KEPT = 2
"""Number of starts of the grid that are fitted for each effect at each place."""


@dataclass(frozen=True, eq=False)
class Start:
    """A model without the effect, and the effect with its initial values."""

    state: State  # parameters to begin with
    weighting: Weighting  # of the errors
    placed: Placed  # the effect
    to_the_end: bool = False  # whether it is fitted to the end even where it leaves far more than others

    @classmethod
    def of(cls, fit: Fit, placed: Placed) -> Start:
        """Start of a fit that adds an effect to a fitted model."""
        return cls(fit.state, fit.weighting, placed)

    @classmethod
    def with_values_of(cls, other: Fit, fit: Fit, placed: Placed) -> Start:
        """The same with the parameters of another fitted model, unless hidden motion grows without bound with them."""
        state = stable_with_effects(other.state, fit.weighting, fit.state.placed)
        return cls(state or fit.state, fit.weighting, placed)

    def placed_state(self) -> State:
        """The model with the effect."""
        return self._with(self.placed)

    def best_state(self) -> State | None:
        """The model with the effect at the size to begin with; None if no size gives finite errors.

        The amplitudes of a projection may be many times too large where the effect changes the motion or where the
        parameters are far off without it, and many times too small where the effect holds hidden motion; a fit does not
        recover from that. The largest size that lowers the error is taken; where the motion is integrated, the one with
        the least error. The first steps would change the shape of a small effect arbitrarily: its amplitudes and the
        parameters are first fitted with the shape held.
        """
        item, plain = self.placed, Fit(self.state, self.weighting).cost
        free = (1.0,) if item.effect.fixed else _SHARES
        shares = (*free, *_MULTIPLES) if item.integrated and not item.effect.fixed else free
        enough = (THRESHOLDS.far_less if item.integrated else 1.0) * plain
        begun: list[tuple[float, Fit]] = []
        for share in shares:
            state = self._with(replace(item, amplitudes=tuple(share * x for x in item.amplitudes)))
            if np.isfinite(state.rows).all():
                begun.append((share, Fit(state, self.weighting)))
                if begun[-1][1].cost < enough:
                    break
        if not begun:
            return None
        share, best = min(begun, key=lambda one: one[1].cost)
        if not item.integrated and best.cost >= plain:
            return begun[0][1].state
        return with_shapes_held(best).state if share != 1.0 and item.shape else best.state

    def _with(self, placed: Placed) -> State:
        return with_effects(self.state, self.weighting, (*self.state.placed, placed))


def from_other_places(fit: Fit, found: Sequence[Fit]) -> Iterator[Start]:
    """The effects of fitted models moved to hidden joints, with the values found elsewhere."""
    prediction = fit.state.prediction
    for other in found:
        item = other.state.placed[-1]
        if not isinstance(item.effect, JointEffect):
            continue
        for place in item.effect.places(prediction):
            moved = replace(item, at=place, integrated=True)
            if moved != item and law_to_integrate(prediction, moved):
                yield Start.with_values_of(other, fit, moved)


def of_changes(fit: Fit, library: Sequence[Effect]) -> Iterator[Start]:
    """Changes during the log after which the fitted values hold, at the best of some sizes and moments.

    Values are fitted to the longer part of a log, which may follow the change.
    """
    if fit.mean_square < 1:
        return
    prediction = fit.state.prediction
    present = {item.key for item in fit.state.placed}
    for own in library:
        for place in (at for at in own.places(prediction) if (own.name, at) not in present):
            tried = (_after(fit, own, place, *change) for change in own.changes_to(prediction, place))
            cost, start = min(chain.from_iterable(tried), key=lambda one: one[0], default=(math.inf, None))
            if start is None or not cost < _LOWERED * fit.cost:
                continue
            close = own.close_shapes(start.state.prediction, start.placed, NEAR)
            closely = _after(fit, own, place, start.state.prediction.parameters, close)
            yield min((cost, start), *closely, key=lambda one: one[0])[1]


def _after(
    fit: Fit, effect: Effect, place: str, parameters: Mapping[str, float], shapes: Iterable[Shape]
) -> Iterator[tuple[float, Start]]:
    """Changes by an effect from given parameters on, with the sum of squares that each leaves."""
    weighting = fit.weighting
    state = evaluated(fit.state, weighting, parameters, fit.state.placed)
    kept = state.released(weighting)
    for change in (Placed(effect, place, shape, (1.0,)) for shape in shapes):
        rows = weighting.rows(state.prediction.passed_on(change.change(state.prediction)))
        left = weighting.projected(state.rows - rows, state.beginning)
        yield float(left @ left), Start(kept, weighting, change)


def of_play(fit: Fit, nominal: Fit, library: Sequence[Effect]) -> Iterator[Start]:
    """Play in hidden springs from fitted and nominal values, at the best of some widths and stiffnesses.

    A spring passes a narrow play at its reversals. Within a wide one a body rattles: it is free, and its motion, which
    depends on its beginning for ever, follows the measured force.
    """
    present = {item.key for item in fit.state.placed}
    for play, model in product((own for own in library if isinstance(own, BacklashEffect)), (fit, nominal)):
        for spring, _ in _hidden_springs(model.state.prediction):
            at, joint, stiffness = _deflected(model.state.prediction, spring)
            if (play.name, at) in present or not any(joint.range):
                continue
            for rattles in (False, True):
                state = model.state.following() if rattles else model.state
                begun = with_effects(state, model.weighting, fit.state.placed)
                values = play.hidden_starts(joint, stiffness, rattles=rattles)
                placed = (Placed(play, at, *own, integrated=True) for own in values)
                tried = (Start(begun, model.weighting, own, to_the_end=True) for own in placed)
                yield min(tried, key=_sum_of_squares)


def of_grid(fit: Fit, nominal: Fit, library: Sequence[Effect]) -> Iterator[Start]:
    """Strong effects in the spring of a hidden body, on a grid of values near the nominal ones.

    The re-identified model `fit` gives all values that are not hidden; `nominal` is the model before re-identification.
    """
    for spring, body in _hidden_springs(nominal.state.prediction):
        places, found = dict.fromkeys((place_of(spring), body.name)), dict[Key, list[tuple[float, Start]]]()
        for near in _near_nominal(fit, nominal, spring, body):
            kept = near.released(nominal.weighting)  # a start holds no arrays that follow from it
            for effect, place in product(library, places):
                for placed in _placed(effect, place, near.prediction, spring):
                    if law_to_integrate(near.prediction, placed):
                        left = _sum_of_squares(Start(near, nominal.weighting, placed))
                        own = left, Start(kept, nominal.weighting, placed)
                        found.setdefault(placed.key, []).append(own)
        for starts in found.values():
            yield from (start for _, start in sorted(starts, key=lambda own: own[0])[:_KEPT])


def _deflected(prediction: Prediction, spring: Spring) -> tuple[str, RecordedJoint, float]:
    """Place and joint of a spring, and its stiffness."""
    values, at = prediction.axis.with_known_values(prediction.parameters), place_of(spring)
    return at, prediction.springs[at], values[spring.named("stiffness")]


def _placed(effect: Effect, place: str, prediction: Prediction, spring: Spring) -> Iterable[Placed]:
    if isinstance(effect, JointEffect) and place in effect.places(prediction):
        _, joint, stiffness = _deflected(prediction, spring)
        if not any(joint.range):  # the spring became rigid
            return
        for shape, amplitudes in effect.strong_starts(joint, stiffness):
            yield Placed(effect, place, shape, amplitudes, integrated=True)


def _sum_of_squares(start: Start) -> float:
    """Sum of squares that a start leaves, apart from unknown initial states; infinite if the motion diverges."""
    with np.errstate(over="ignore", invalid="ignore"):
        try:
            state = start.placed_state()
        except OverflowError:
            return math.inf
        cost = Fit(state, start.weighting).cost if np.isfinite(state.rows).all() else math.inf
    return cost if math.isfinite(cost) else math.inf


def _near_nominal(fit: Fit, nominal: Fit, spring: Spring, body: Body) -> Iterator[State]:
    """Models near the nominal one, with re-identified values of everything that is not hidden."""
    prediction, weighting = nominal.state.prediction, nominal.weighting
    axis, mass = prediction.axis, body.inertial
    stiffness = spring.named("stiffness")
    hidden = {mass, stiffness, *([spring.named("damping")] if spring.damping is not None else [])}
    hidden |= {term.parameter for law in axis.laws if law.at == body for term in law.terms()}
    values = {
        n: (prediction if n in hidden else fit.state.prediction).parameters[n] for n in prediction.parameters
    }
    for stiffer, heavier in product(_STIFFNESSES, _MASSES):
        factors = {stiffness: stiffer, mass: heavier}
        near = values | {name: values[name] * factor for name, factor in factors.items() if name in values}
        state, _ = first_state(prediction.record, near, weighting.allowed, follows=prediction.follows)
        yield state.weighted(weighting)


def _hidden_springs(prediction: Prediction) -> Iterator[tuple[Spring, Body]]:
    """Springs with hidden deflection, and the hidden body on each."""
    bodies = prediction.response.plant.bodies
    for spring in (e for e in prediction.axis.elements if isinstance(e, Spring)):
        if not prediction.record.is_hidden(prediction.springs[place_of(spring)].direction):
            continue
        ends = (spring.at.first, spring.at.second) if isinstance(spring.at, Between) else (spring.at,)
        hidden = [
            b
            for b in ends
            if isinstance(b, Body)
            and (b.gears or b.name in bodies)
            and prediction.record.is_hidden(direction_of(b, bodies))
        ]
        if hidden:
            yield spring, hidden[0]
