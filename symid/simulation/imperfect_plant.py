"""Plants with imperfections: laws that depend on time, on a memory, or on the drive force."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np

from symid.arrays import FloatArray
from symid.axis import (
    Axis,
    CoulombFriction,
    Imperfection,
    JointImperfection,
    PayloadChange,
    PreslidingFriction,
)
from symid.simulation.forward_dynamics import plant_of
from symid.simulation.law_functions import array_function, code_of, law_function
from symid.simulation.plant import JointLaw, Plant, ScaledLaw, direction_of

_FINE, _MOST_STEPS = 0.5, 50
"""Largest phase advance in a step, rad, of a joint vibrating on its presliding stiffness; and most steps."""


@dataclass(eq=False)
class Moment:
    """State on which laws depend besides the motion: time, s, load, and memories of presliding friction.

    The load is the force of the drive; with several drives, the sum of the magnitudes of their forces.
    """

    time: float = 0.0
    load: float = 1.0
    memories: list[Dahl] = field(default_factory=list)

    def begin(self, displacements: FloatArray) -> None:
        """Begin a run at given displacements, with empty memories."""
        for memory in self.memories:
            memory.place, memory.state = float(memory.direction @ displacements), 0.0

    def recall(self, memories: FloatArray) -> None:
        """Set place and state of each memory from the rows of an array."""
        for memory, known in zip(self.memories, memories.tolist(), strict=True):
            memory.place, memory.state = known

    def settle(self, displacements: FloatArray) -> None:
        """Remember the displacements at the end of a sample."""
        for memory in self.memories:
            memory.settle(float(memory.direction @ displacements))


@dataclass(eq=False)
class Dahl:
    """Dahl friction in a joint, which builds up over `reach`; exact along a motion that does not reverse.

    `state` is z at the displacement `place` of the last update.

    >>> friction = Dahl(np.ones(1), 1.0)
    >>> for place in (1.0, 2.0, 1.0):
    ...     friction.settle(place)
    >>> round(friction.state, 3)
    -0.314
    """

    direction: FloatArray
    reach: float
    place: float = 0.0
    state: float = 0.0

    def at(self, q: float) -> float:
        """State z of the friction at a displacement."""
        side = 1.0 if q >= self.place else -1.0
        return side - (side - self.state) * math.exp(-abs(q - self.place) / self.reach)

    def settle(self, q: float) -> None:
        """Update the state at a displacement."""
        self.state, self.place = self.at(q), q


def stages(axis: Axis, parameters: Mapping[str, float], moment: Moment) -> list[tuple[float, Plant]]:
    """Plants of an axis, each with the time from which it is valid, s; `moment` receives the state of their laws."""
    values = axis.known_parameters | dict(parameters)
    changes = [e for e in axis.elements if isinstance(e, PayloadChange)]
    plant, added = plant_of(axis, values), []
    for element in axis.elements:
        if isinstance(element, JointImperfection):
            direction = direction_of(element.at, plant.bodies)
            added.append((direction, _law(axis, element, direction, values, moment)))
    found = [(0.0, _with_laws(plant, added))]
    for change in sorted(changes, key=lambda change: change.time):
        values[change.body.inertial] += change.change
        found.append((change.time, _with_laws(plant_of(axis, values), added)))
    return found


def misread_code(axis: Axis, signal: str) -> str | None:
    """Reading of a sensor with ripple, as NumPy code in terms of the exact value y; None without ripple."""
    if not axis.imperfections:
        return None
    from symid.symbolic.expressions import misread  # sympy takes half a second to load

    law = misread(axis, signal)
    return None if law is None else code_of(law)


def misreading(axis: Axis, signal: str) -> Callable[[FloatArray], FloatArray] | None:
    """Function that adds a sensor's ripple to exact readings; None without ripple."""
    code = misread_code(axis, signal)
    if code is None:
        return None
    function = array_function(code, ("y",))
    return lambda values: function(values, values, values)


def _law(
    axis: Axis,
    element: JointImperfection,
    direction: FloatArray,
    values: Mapping[str, float],
    moment: Moment,
) -> ScaledLaw:
    memory = None
    if isinstance(element, PreslidingFriction):
        memory = Dahl(direction, element.reach)
        moment.memories.append(memory)
        element = replace(element, level=presliding_level(axis, element, values))
    law = scalar_law(element)

    def force(q: float, v: float) -> float:
        return law(q, v, moment.load, moment.time, memory.at(q) if memory else 0.0)

    return ScaledLaw(1.0, force, imperfection_code(element), len(moment.memories) - 1 if memory else -1)


@cache
def scalar_law(element: Imperfection) -> Callable[..., float]:
    """Law of an imperfection as a function of numbers q, v, F, t and z."""
    return law_function(imperfection_code(element), ("F", "t", "z"))


def imperfection_code(element: Imperfection) -> str:
    """NumPy code of the law of an imperfection in terms of q, v, F, t and z."""
    from symid.symbolic.expressions import imperfection_law  # sympy takes half a second to load

    return code_of(imperfection_law(element))


def presliding_level(axis: Axis, element: PreslidingFriction, values: Mapping[str, float]) -> float:
    """Part of the declared Coulomb friction that builds up over a displacement: at most all of it."""
    levels = [
        law.named("level") for law in axis.laws if isinstance(law, CoulombFriction) and law.at == element.at
    ]
    return min(element.level, sum(values[name] for name in levels))


def steps_for(axis: Axis, plant: Plant, parameters: Mapping[str, float], period: float) -> int:
    """Steps in a sample that resolve the stiffness of presliding friction, at most 2 level/reach after a reversal."""
    most = 1.0
    for element in axis.elements:
        if isinstance(element, PreslidingFriction):
            direction = direction_of(element.at, plant.bodies)
            mobility = float(direction @ np.linalg.solve(plant.mass, direction))
            stiffness = 2.0 * presliding_level(axis, element, parameters) / element.reach
            most = max(most, period * math.sqrt(max(stiffness * mobility, 0.0)) / _FINE)
    return math.ceil(min(most, _MOST_STEPS))


def _with_laws(plant: Plant, added: list[tuple[FloatArray, ScaledLaw]]) -> Plant:
    """The plant with more laws, each added to those in the same joint."""
    laws = list(plant.laws)
    for direction, term in added:
        same = next((i for i, law in enumerate(laws) if np.allclose(law.direction, direction)), len(laws))
        terms = laws[same].terms if same < len(laws) else ()
        laws[same : same + 1] = [
            JointLaw(laws[same].direction if terms else direction, (*terms, term), timed=True)
        ]
    return replace(plant, laws=tuple(laws))
