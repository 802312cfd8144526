"""Elements between the bodies of an axis, as links with a symbol and a label for its schematic."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from symid.axis import (
    AsymmetricFriction,
    Axis,
    Backlash,
    Between,
    Body,
    CoulombFriction,
    Damper,
    GapDamping,
    Imperfection,
    Joint,
    JointImperfection,
    Law,
    Parameter,
    Spring,
    ViscousFriction,
)
from symid.report.figures import symbols
from symid.report.figures.symbols import Sign

_SIGNS: Final[Mapping[type[Law], Sign]] = {
    ViscousFriction: symbols.damper,
    CoulombFriction: symbols.friction,
    AsymmetricFriction: symbols.friction,
    Backlash: symbols.play,
    GapDamping: symbols.play,
}
_FIRST_MARK, _CIRCLED = ord("\u2460"), 20
"""Circled numbers, by which notes explain imperfections, and how many there are."""


@dataclass(frozen=True)
class Link:
    """An element between two bodies: `sign` draws it, `label` is its text, `name` identifies it in the figure."""

    first: str
    second: str
    sign: Sign
    label: str
    name: str

    @classmethod
    def in_joint(cls, at: Joint, sign: Sign, label: str, name: str) -> Link:
        """Link between the two bodies of a joint."""
        first, second = (at.on, at) if isinstance(at, Body) else (at.first, at.second)
        return cls(first.name, second.name, sign, label, name)


def links_of(axis: Axis) -> Iterator[Link]:
    """All elements that act in a joint, in the order of the declaration; the drives last."""
    for body in axis.bodies:
        for gear in body.gears:
            name = f"gear of {body.name}" + (f" to {gear.to.name}" if len(body.gears) > 1 else "")
            yield Link(gear.to.name, body.name, symbols.gear, f"× {gear.ratio:.4g}", name)
    for element in axis.elements:
        match element:
            case Spring():
                label, at = parameter_text(element.stiffness), element.at
                if isinstance(at, Between) and at.ratio != 1:
                    label += f", × {at.ratio:.4g}"
                yield Link.in_joint(at, symbols.spring, label, f"spring {element.name}")
                if element.damping is not None:
                    damping = parameter_text(element.damping)
                    yield Link.in_joint(at, symbols.damper, damping, f"damping of {element.name}")
            case Damper():
                damping = parameter_text(element.damping)
                yield Link.in_joint(element.at, symbols.damper, damping, f"damper {element.name}")
            case Law():
                names = list(dict.fromkeys(term.parameter for term in element.terms()))
                label = ", ".join(names) if len(names) <= 2 else f"{names[0]} … {names[-1]}"
                sign = _SIGNS.get(type(element), symbols.law)
                yield Link.in_joint(element.at, sign, label, type(element).__name__)
            case JointImperfection():
                marks = marks_of(axis, element)
                yield Link.in_joint(element.at, symbols.law, marks, type(element).__name__)
    for drive in axis.drives:
        marks = marks_of(axis, *axis.imperfections_of(drive))
        name = "drive" if len(axis.drives) == 1 else f"drive {drive.signal}"
        label = marked(drive.command or drive.signal, marks)
        yield Link.in_joint(drive.at, symbols.drive, label, name)


def marks_of(axis: Axis, *elements: Imperfection) -> str:
    """Marks of imperfections, by which the notes below the drawing explain them."""
    places = [
        i
        for i, element in enumerate(axis.imperfections)
        if any(element is marked_element for marked_element in elements)
    ]
    return " ".join(chr(_FIRST_MARK + i) if i < _CIRCLED else f"({i + 1})" for i in places)


def marked(label: str, marks: str) -> str:
    """A label with marks behind it, if there are any."""
    return f"{label}, {marks}" if marks else label


def parameter_text(parameter: Parameter | None) -> str:
    """Name of a parameter, or the value of one that is known."""
    return parameter if isinstance(parameter, str) else f"{parameter:.4g}"
