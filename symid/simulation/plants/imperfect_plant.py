"""Plants with imperfections: laws that depend on time, on a memory, or on the drive force."""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from symid.arrays import FloatArray
from symid.axis import (
    Axis,
    CoulombFriction,
    EncoderRipple,
    ForceConstantRipple,
    Imperfection,
    JointImperfection,
    PayloadChange,
    PreslidingFriction,
    ripples_of,
)
from symid.simulation.plants.forward_dynamics import forward_dynamics, plant_of
from symid.simulation.plants.law_code import array_function, law_code
from symid.simulation.plants.plant import JointLaw, Plant, ScaledLaw, direction_of

_FINE, _MOST_STEPS = 0.5, 50
"""Largest phase advance in a step, rad, of a joint vibrating on its presliding stiffness; and most steps."""


class DahlMemory(NamedTuple):
    """Dahl friction in a joint, whose state the displacement builds up."""

    direction: FloatArray  # of the joint, as in `JointLaw`
    reach: float  # displacement over which it builds up, m or rad


class PlantStage(NamedTuple):
    """A plant, and the time from which it is valid, s."""

    begin: float
    plant: Plant


def stages(axis: Axis, parameters: Mapping[str, float]) -> tuple[list[PlantStage], tuple[DahlMemory, ...]]:
    """Plants of an axis, one after each change of a mass, and the memories on which their laws depend."""
    values = axis.known_parameters | dict(parameters)
    plant = plant_of(axis, values)
    scales = [values[drive.constant] if drive.constant else 1.0 for drive in axis.drives]
    added: list[tuple[FloatArray, ScaledLaw]] = []
    memories: list[DahlMemory] = []
    for element in axis.elements:
        if isinstance(element, JointImperfection):
            direction = direction_of(element.at, plant.bodies)
            if isinstance(element, PreslidingFriction):
                memory = len(memories)
                memories.append(DahlMemory(direction, element.reach))
                limited = replace(element, level=presliding_level(axis, element, values))
                added.append((direction, _law(limited, memory)))
            else:
                added.append((direction, _under_load(_law(element), scales)))
    for i, (drive, scale) in enumerate(zip(axis.drives, scales, strict=True)):
        direction = direction_of(drive.at, plant.bodies)
        added += [(direction, _ripple(e, i, scale)) for e in ripples_of(axis.imperfections_of(drive))]
    found = [PlantStage(0.0, _with_laws(plant, added))]
    changes = (element for element in axis.elements if isinstance(element, PayloadChange))
    dynamics = forward_dynamics(axis)
    for change in sorted(changes, key=lambda change: change.time):
        name = change.body.inertial
        values[name] += change.change
        if name in axis.known_parameters:
            dynamics = replace(dynamics, axis=dynamics.axis.with_known({name: values[name]}))
        found.append(PlantStage(change.time, _with_laws(dynamics.at(values), added)))
    return found, tuple(memories)


def misread_code(axis: Axis, signal: str) -> str | None:
    """Reading of a sensor with ripple, as NumPy code in terms of the exact value y; None without ripple."""
    ripples = [e for e in axis.imperfections if isinstance(e, EncoderRipple) and e.signal == signal]
    if not ripples:
        return None
    first, *others = map(imperfection_code, ripples)
    return " + ".join([first, *(f"({other} - y)" for other in others)])


def misreading(axis: Axis, signal: str) -> Callable[[FloatArray], FloatArray] | None:
    """Function that adds a sensor's ripple to exact readings; None without ripple."""
    code = misread_code(axis, signal)
    if code is None:
        return None
    function = array_function(code, ("y",))
    return lambda values: function(values, values, values)


def _law(element: JointImperfection | ForceConstantRipple, memory: int = -1) -> ScaledLaw:
    """The law of an imperfection; as a function of the motion alone that under a unit load, without memory."""
    law = imperfection_function(element)
    return ScaledLaw(1.0, lambda q, v: law(q, v, 1.0, 0.0, 0.0), imperfection_code(element), memory)


def _under_load(law: ScaledLaw, scales: Sequence[float]) -> ScaledLaw:
    """A law that depends on the force of the drives, of which `scales` are the forces per unit of their signals."""
    if all(scale == 1.0 for scale in scales):
        return law
    load = " + ".join(f"{abs(scale)!r}*np.abs(F{i})" for i, scale in enumerate(scales))
    return law._replace(code=re.sub(r"\bF\b", f"({load})", law.code))


def _ripple(element: ForceConstantRipple, drive: int, scale: float) -> ScaledLaw:
    """Force that a ripple takes from that of a drive, of which `scale` is the force per unit of the signal."""
    law = _law(element)
    return law._replace(parameter=scale, code=re.sub(r"\bF\b", f"F{drive}", law.code))


@cache
def imperfection_function(element: Imperfection) -> Callable[..., Any]:
    """Law of an imperfection as a function of q, v, F, t and z."""
    return array_function(imperfection_code(element), ("F", "t", "z"))


def imperfection_code(element: Imperfection) -> str:
    """NumPy code of the law of an imperfection in terms of q, v, F, t and z, or of y."""
    return law_code(element.in_numbers(element.law))


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
