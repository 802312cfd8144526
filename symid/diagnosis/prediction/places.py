"""Names of the places of effects."""

from collections.abc import Iterable

from symid.axis import Axis, Between, Joint, Spring


def place_of(spring: Spring) -> str:
    """Name of the place of a spring."""
    return spring.name if isinstance(spring.at, Between) else spring.at.name


def place_named(axis: Axis, name: str) -> Joint:
    """Joint of the body or spring with a name."""
    springs: Iterable[Spring] = (e for e in axis.elements if isinstance(e, Spring))
    found = next((body for body in axis.bodies if body.name == name), None)
    return found if found is not None else next(s.at for s in springs if place_of(s) == name)
