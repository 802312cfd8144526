"""Where effects sit: names of places, and joints as directions over the displacements of the bodies."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from symid.arrays import FloatArray
from symid.axis import Axis, Between, Body, Ground, Spring
from symid.axis.elements import Joint


def place_of(spring: Spring) -> str:
    """Name of the place of a spring."""
    return spring.name if isinstance(spring.at, Between) else spring.at.name


def place_named(axis: Axis, name: str) -> Joint:
    """Body or spring of an axis that an effect sits at."""
    springs: Iterable[Spring] = (e for e in axis.elements if isinstance(e, Spring))
    found = next((body for body in axis.free_bodies if body.name == name), None)
    return found if found is not None else next(s.at for s in springs if place_of(s) == name)


def direction_of(at: Body | Between, bodies: tuple[str, ...]) -> FloatArray:
    """Displacement in a joint as a product with those of the free bodies."""
    if isinstance(at, Between):
        return np.asarray(_absolute(at.second, bodies) - at.ratio * _absolute(at.first, bodies))
    if at.gears:
        return np.asarray(sum(gear.ratio * direction_of(gear.to, bodies) for gear in at.gears))
    own = np.eye(len(bodies))[bodies.index(at.name)]
    return np.asarray(own - _absolute(at.on, bodies)) if _is_carried(at) else own


def _absolute(body: Body | Ground, bodies: tuple[str, ...]) -> FloatArray:
    """Displacement of a body against the ground as such a product."""
    if isinstance(body, Ground):
        return np.zeros(len(bodies))
    relative = direction_of(body, bodies)
    return np.asarray(relative + _absolute(body.on, bodies)) if _is_carried(body) else relative


def _is_carried(body: Body) -> bool:
    """Whether the motion of what a body is on adds to its own: a turning body on a sliding one turns by its own."""
    return isinstance(body.on, Body) and body.on.turns == body.turns
