"""Force laws as effects that a model may lack: forces, units and elements follow from the formula of the law."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product

import numpy as np

from symid.arrays import ComplexArray, FloatArray
from symid.axis import (
    Body,
    Damper,
    Hypothesis,
    Joint as Place,
    Law,
    PendulumWeight,
    ShapeParameter,
    Spring,
    SpringDamping,
    Term,
    ViscousFriction,
    laws,
)
from symid.diagnosis.effects.effect import (
    JointEffect,
    LinearEffect,
    MatchedFilter,
    Placed,
    Shape,
    joint_units,
    sampled,
)
from symid.diagnosis.prediction.hidden_motion import Pointwise
from symid.diagnosis.prediction.joint import RecordedJoint
from symid.diagnosis.prediction.places import place_named, place_of
from symid.diagnosis.prediction.prediction import Prediction
from symid.simulation.plants import array_function, has_jumps, law_code, level_code, not_below_zero
from symid.units import Unit

_STRONG = (0.3, 1.0, 2.5, 5.0)
"""Forces of a law in a spring, or its dead zone, relative to the spring where it is deflected most."""
HOLDING = (0.03, 0.1, 0.3, 1.0)
"""Levels of dry friction, relative to the same."""
_HIDDEN_SHAPES = (0.2, 1.0)
"""Shapes of dry friction that holds a hidden joint, relative to the size of its motion."""


@dataclass(frozen=True, eq=False)
class LawFunctions:
    """A formula as functions of q, v, its shape parameters and, but for `arrays`, its amplitudes."""

    arrays: tuple[Callable[..., FloatArray], ...]  # each term for arrays and a unit amplitude
    force: str  # the whole force as NumPy code, in q, v and `names`
    names: tuple[str, ...]  # of shape parameters and amplitudes
    level: str | None  # factor of sign(v) in dry friction; it does not fall below 0 along the stroke
    jumps: tuple[bool, ...]  # whether each term jumps where the velocity changes its sign


@cache
def functions_of(formula: tuple[Term, ...], numbers: tuple[str, ...]) -> LawFunctions:
    """Functions of the terms of a formula, with some of its numbers as arguments."""
    terms = [law_code(term.expression) for term in formula]
    levels = [level_code(term.expression) for term in formula]
    amplitudes = tuple(f"amplitude_{i}" for i in range(len(terms)))

    def whole(parts: Sequence[str | None]) -> str:
        return " + ".join(f"{a} * ({part})" for a, part in zip(amplitudes, parts, strict=True))

    level = None if None in levels else not_below_zero(whole(levels))
    arrays = tuple(array_function(term, numbers) for term in terms)
    jumps = tuple(has_jumps(term.expression) for term in formula)
    return LawFunctions(arrays, whole(terms), (*numbers, *amplitudes), level, jumps)


class LawEffect(JointEffect):
    """A force law that a model lacks, together with the laws that its hypothesis adds.

    Parameters
    ----------
    law : Law class
        The missing law.
    hypothesis : Hypothesis
        How it is considered, one of those of the law.
    """

    def __init__(self, law: type[Law], hypothesis: Hypothesis) -> None:
        self.law, self.hypothesis = law, hypothesis
        self.laws = (*hypothesis.together, law)
        self.name, self.amplitudes = hypothesis.effect, hypothesis.symbols
        self.shape_parameters = tuple(number for each in self.laws for number in each.shape)
        self.shape_names = tuple(number.symbol for number in self.shape_parameters)
        formula = tuple(term for each in self.laws for term in each.formula)
        self.formula = formula[: len(self.amplitudes)]
        self.advice = law.advice
        self.refines = tuple(each.hypotheses[0].effect for each in law.refines)
        self.positive = not (hypothesis.together or self.formula[0].signed)

    @property
    def functions(self) -> LawFunctions:
        """The formula as functions."""
        return functions_of(self.formula, tuple(number.field for number in self.shape_parameters))

    def joint(self, prediction: Prediction, place: str) -> RecordedJoint:
        return prediction.springs[place] if self.law.in_spring else prediction.joints[place]

    def places(self, prediction: Prediction) -> Iterable[str]:
        """Springs for a law in a spring; else bodies in whose joint neither the law nor its like is declared."""
        if self.law.in_spring:
            damped = damped_springs(prediction) if self.law.once else set()
            return [name for name in prediction.springs if name not in damped]
        taken: set[str] = set(prediction.springs) if any(t.expression == "q" for t in self.formula) else set()
        taken = taken.union(*(joints_with(prediction, each) for each in self.laws if each.once))
        taken = taken.union(*(joints_with(prediction, each) for each in self.hypothesis.without))
        beside = [joints_with(prediction, each) for each in self.hypothesis.beside]
        joints = prediction.joints.items()
        seen = (name for name, joint in joints if joint.moves_both_ways or not self.law.by_direction)
        free = (name for name in seen if name not in taken)
        return [
            name
            for name in free
            if all(name in names for names in beside) and self._is_allowed(place_named(prediction.axis, name))
        ]

    def _is_allowed(self, place: Place) -> bool:
        """Whether its laws may be declared at a place: a weight of unknown angle needs a body that turns."""
        unit = (1.0,) * len(self.shape_parameters), (1.0,) * len(self.amplitudes)
        return not any(fault for law in self.elements(place, "", *unit)[0] for fault in law.faults())

    def is_plausible(self, prediction: Prediction, placed: Placed) -> bool:
        """A spring leaves its dead zone at times."""
        joint = self.joint(prediction, placed.at)
        widths = zip(self.shape_parameters, placed.shape, strict=True)
        return all(x / 2 < _scale(number, joint) for number, x in widths if number.scale == "deflection")

    def shapes(self, prediction: Prediction, place: str, matched_filter: MatchedFilter) -> Iterable[Shape]:
        joint = self.joint(prediction, place)
        return product(*(_trials(number, joint) for number in self.shape_parameters))

    def bounded(self, prediction: Prediction, place: str, shape: Shape) -> Shape:
        joint = self.joint(prediction, place)
        return tuple(_bounded(n, joint, x) for n, x in zip(self.shape_parameters, shape, strict=True))

    def courses(self, joint: RecordedJoint, shape: Shape) -> tuple[FloatArray, ...]:
        """Forces on the fine grid for unit amplitudes; a constant one acts within the log."""
        inside = joint.record.in_log
        return tuple(
            inside.astype(float) if term.expression == "1" else function(joint.q, joint.v, *shape)
            for term, function in zip(self.formula, self.functions.arrays, strict=True)
        )

    def forces(self, prediction: Prediction, joint: RecordedJoint, shape: Shape) -> ComplexArray:
        jumps = self.functions.jumps
        courses = zip(self.courses(joint, shape), jumps, strict=True)
        return sampled(prediction, *(joint.averaged(force) if jump else force for force, jump in courses))

    def pointwise(
        self, prediction: Prediction, shape: Shape, amplitudes: tuple[float, ...]
    ) -> Pointwise | None:
        return self.point_by_point(shape, amplitudes) if self.law.moves_hidden else None

    def point_by_point(self, shape: Shape, amplitudes: tuple[float, ...]) -> Pointwise:
        """The force for numbers; of dry friction the level."""
        functions = self.functions
        values = dict(zip(functions.names, (*shape, *amplitudes), strict=True))
        if functions.level is None:
            return Pointwise(functions.force, values)
        return Pointwise(functions.level, values, dry=True)

    def force_at(
        self, q: FloatArray, v: FloatArray, shape: Shape, amplitudes: tuple[float, ...]
    ) -> FloatArray:
        """Force for displacements and velocities of the joint."""
        terms = zip(amplitudes, self.functions.arrays, strict=True)
        return np.asarray(sum(c * term(q, v, *shape) for c, term in terms))

    @property
    def varies_along_stroke(self) -> bool:
        """Whether it is dry friction whose level depends on the place."""
        return self.functions.level is not None and any("q" in term.expression for term in self.formula)

    def level(self, joint: RecordedJoint, shape: Shape, amplitudes: tuple[float, ...]) -> FloatArray:
        """Course of the level of dry friction, on the fine grid, for motion at unit speed."""
        unit = np.ones_like(joint.q)
        courses = [function(joint.q, unit, *shape) for function in self.functions.arrays]
        return np.asarray(np.tensordot(amplitudes, courses, 1))

    def strong_starts(
        self, spring: RecordedJoint, stiffness: float
    ) -> Iterable[tuple[Shape, tuple[float, ...]]]:
        largest = max(map(abs, spring.range))
        if not self.law.in_spring:
            scales = (_scale(number, spring) for number in self.shape_parameters)
            shapes = product(*(tuple(x * scale for x in _HIDDEN_SHAPES) for scale in scales))
            levels = HOLDING if self.is_one_level else ()
            return [(shape, (x * stiffness * largest,)) for shape, x in product(shapes, levels)]
        if self.shape_names:
            return [((x * largest,), (stiffness,)) for x in _STRONG]
        (unit,) = np.abs(self.functions.arrays[0](np.array([largest]), np.zeros(1)))
        return [((), (x * stiffness * largest / unit,)) for x in _STRONG]

    @property
    def is_one_level(self) -> bool:
        """Whether it is one level that opposes the motion, at all speeds or at some."""
        return self.functions.level is not None and len(self.formula) == 1

    def units(self, prediction: Prediction, place: str) -> tuple[str, ...]:
        force, length = joint_units(prediction, place)
        speed = length / Unit.of("s")
        of_shape = (speed if number.scale == "speed" else length for number in self.shape_parameters)
        return (*(str(term.unit(force, length)) for term in self.formula), *map(str, of_shape))

    def elements(
        self, place: Place, prefix: str, shape: Shape, amplitudes: tuple[float, ...]
    ) -> tuple[tuple[Law, ...], dict[str, float]]:
        """The laws as elements of an axis, whose parameters begin with a prefix, and the values of these."""
        numbers, values = dict(zip(self.shape_parameters, shape, strict=True)), {}
        given = iter(zip(self.amplitudes, amplitudes, strict=True))
        found = []
        for law in self.laws:
            fields: dict[str, str | float] = {n.field: numbers[n] for n in law.shape}
            for term, symbol in zip(law.formula, law.hypotheses[0].symbols[-len(law.formula) :], strict=True):
                name, value = next(given, (symbol, 0.0))
                fields[term.parameter] = f"{prefix}_{name}"
                values[f"{prefix}_{name}"] = value
            found.append(law(at=place, **fields))
        return tuple(found), values


class LinearLawEffect(LinearEffect, LawEffect):
    """A law that is linear in the motion: q or v."""

    def stiffness(self, omega: FloatArray, shape: Shape) -> ComplexArray:
        (term,) = self.formula
        return np.asarray(1j * omega if term.expression == "v" else np.ones(omega.size, dtype=complex))

    def pointwise(self, prediction: Prediction, shape: Shape, amplitudes: tuple[float, ...]) -> None:
        return None

    def strong_starts(
        self, spring: RecordedJoint, stiffness: float
    ) -> Iterable[tuple[Shape, tuple[float, ...]]]:
        return ()


def effects_of(law: type[Law], kind: type[LawEffect] = LawEffect) -> tuple[LawEffect, ...]:
    """The effects that stand for a law, one for each of its hypotheses.

    Examples
    --------
    >>> from symid.axis import StribeckFriction
    >>> [(effect.name, effect.amplitudes, effect.shape_names) for effect in effects_of(StribeckFriction)]
    [('stribeck_friction', ('dF',), ('vs',))]
    """
    is_linear = all(term.is_linear for term in law.formula)
    return tuple((LinearLawEffect if is_linear else kind)(law, each) for each in law.hypotheses)


def library_of_laws(own: Mapping[type[Law], type[LawEffect]]) -> tuple[LawEffect, ...]:
    """The effects of all laws of symid; `own` has the classes of those that need more than their formula."""
    declared = (getattr(laws, name) for name in laws.__all__)
    known = [law for law in declared if isinstance(law, type) and issubclass(law, Law)]
    return tuple(effect for law in known for effect in effects_of(law, own.get(law, LawEffect)))


def joints_with(prediction: Prediction, kind: type[Law | PendulumWeight]) -> set[str]:
    """Bodies in whose joint a law or a weight is declared."""
    found = (e for e in prediction.axis.elements if isinstance(e, kind))
    places = (e.body if isinstance(e, PendulumWeight) else e.at for e in found)
    return {place.name for place in places if isinstance(place, Body)}


def damped_springs(prediction: Prediction) -> set[str]:
    """Places of springs in whose joint damping or viscous friction is declared, or whose force a sensor reads."""
    elements = prediction.axis.elements
    damped = [e.at for e in elements if isinstance(e, Damper | ViscousFriction | SpringDamping)]
    springs = (e for e in elements if isinstance(e, Spring))
    read = prediction.record.springs_read
    return {place_of(e) for e in springs if e.damping is not None or e.at in damped} | {*read}


def _scale(number: ShapeParameter, joint: RecordedJoint) -> float:
    """Size of the motion by which a shape parameter is scaled."""
    if number.scale == "deflection":
        return max(map(abs, joint.range))
    return joint.top_speed if number.scale == "speed" else joint.stroke


def _trials(number: ShapeParameter, joint: RecordedJoint) -> list[float]:
    assert number.trials is not None, f"{number.field} has no trials: its effect needs its own search"
    low, high, count = number.trials
    return [float(x * _scale(number, joint)) for x in np.geomspace(low, high, count)]


def _bounded(number: ShapeParameter, joint: RecordedJoint, value: float) -> float:
    if number.bounds is None:
        return value
    low, high = (bound * _scale(number, joint) for bound in number.bounds)
    return float(np.clip(value, low, high))
