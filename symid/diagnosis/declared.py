"""The effects that were found as elements of a new axis: what is derived, generated and identified like any other."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TypeAlias

from symid.axis import Axis, Between, Body, Law, Spring
from symid.axis.elements import Joint as Place
from symid.diagnosis.effects import LawEffect, Placed
from symid.diagnosis.result import Diagnosis
from symid.diagnosis.scene import Scene, place_of
from symid.diagnosis.state import State
from symid.errors import SettingError

Values: TypeAlias = dict[str, float]
"""Value of each new parameter, SI."""


@dataclass(frozen=True)
class ExplainedAxis:
    """An axis with the effects that a diagnosis found.

    Parameters
    ----------
    axis : Axis
        The axis diagnosed with the elements of the effects added.
    values : dict of str to float
        Values of its physical parameters, SI.
    left_out : tuple of str
        A sentence for each effect that is no element of an axis: what depends on time or on the drive force, or lies
        in a signal.
    """

    axis: Axis
    values: Values
    left_out: tuple[str, ...]


def explained_axis(found: Diagnosis) -> ExplainedAxis:
    """The axis with the effects of a diagnosis added, and the values of its parameters.

    Parameters
    ----------
    found : Diagnosis
        With at least one effect.

    Raises
    ------
    SettingError
        If no effect was found, or none of them is an element of an axis.
    """
    accepted = [turn for turn in found.search if turn.accepts] if found.effects else []
    if not accepted:
        raise SettingError("no effect was found: the axis stays as it is declared")
    explained = axis_of(accepted[len(found.effects) - 1].confirmed[0].fit.state)
    if explained.axis.elements == found.axis.elements:
        raise SettingError("; ".join(explained.left_out))
    return explained


def axis_of(state: State) -> ExplainedAxis:
    """The axis of a model with the effects that it holds as elements, and the values of its parameters.

    Parameters
    ----------
    state : State
        The model, under any record.
    """
    axis, values = state.scene.axis, dict(state.scene.parameters)
    left_out = []
    for item in state.placed:
        if item.effect.name == "flexible_mode":
            axis = _with_mode(axis, item, values)
        elif isinstance(item.effect, LawEffect):
            place = _place(state.scene.axis, item.at)
            laws, added = _elements(item.effect, place, item, item.at)
            if added.keys() & values.keys():  # two effects of a joint may call an amplitude alike
                laws, added = _elements(item.effect, place, item, f"{item.at}_{item.effect.name}")
            axis = axis.with_effect(*laws)
            values |= added
        else:
            left_out.append(_left_out(state.scene, item))
    return ExplainedAxis(axis, {name: values[name] for name in axis.physical_parameters}, tuple(left_out))


def _elements(effect: LawEffect, place: Place, item: Placed, prefix: str) -> tuple[tuple[Law, ...], Values]:
    return effect.elements(place, prefix, item.shape, item.amplitudes)


def _left_out(scene: Scene, item: Placed) -> str:
    """What an axis file cannot say of an effect."""
    found = {name: (value, unit) for name, value, unit in item.values(scene) if name != "share"}
    numbers = ", ".join(f"{name} = {value:.4g} {unit}" for name, (value, unit) in found.items())
    if item.effect.name in ("delay", "actuator_lag"):
        late = f"--late {scene.axis.drive.signal}={-1e6 * found['T'][0]:.4g}us"
        return f"{item.effect.name} ({numbers}) is no element of an axis: identify with {late}"
    where = "depends on time or force, or lies in a signal"
    return f"{item.effect.name} at {item.at} ({numbers}) is no element of an axis: it {where}"


def _with_mode(axis: Axis, item: Placed, values: Values) -> Axis:
    """The axis with a part of a body's mass hung on a spring."""
    (mass,), (frequency, ratio) = item.amplitudes, item.shape
    body = next(b for b in axis.free_bodies if b.name == item.at)
    own = 2 * math.pi * frequency
    names = [f"{item.at}_mode_{letter}" for letter in ("m", "k", "c")]
    slides = body.mass is not None
    added = Body(
        f"{item.at}_mode",
        mass=names[0] if slides else None,
        inertia=None if slides else names[0],
    )
    spring = Spring(
        f"{added.name}_spring", Between(first=body, second=added), stiffness=names[1], damping=names[2]
    )
    values |= dict(zip(names, (mass, mass * own**2, 2 * ratio * own * mass), strict=True))
    known = axis.known_parameters
    if body.inertial in known:
        axis = axis.with_known({body.inertial: known[body.inertial] - mass})
    else:
        values[body.inertial] -= mass
    return axis.with_effect(added, spring)


def _place(axis: Axis, name: str) -> Place:
    springs: Iterable[Spring] = (e for e in axis.elements if isinstance(e, Spring))
    found = next((body for body in axis.free_bodies if body.name == name), None)
    return found if found is not None else next(s.at for s in springs if place_of(s) == name)
