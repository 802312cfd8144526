"""The record of a force law, which derivation, generated code, simulation, export and diagnosis share."""

from __future__ import annotations

import math
import re
from abc import ABC
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import ClassVar, Literal, TypeAlias

from symid.axis.elements import Joint, PendulumWeight, is_number, joint_label
from symid.units import Unit

__all__ = ["Hypothesis", "Law", "ShapeParameter", "Term"]

LAW_FUNCTIONS = ("sign", "positive", "sin", "cos", "exp", "abs")
"""Functions that an expression may use. positive(v) is 1 for v > 0 and 0 otherwise."""


@dataclass(frozen=True)
class Term:
    """One term of a law: `parameter` times `expression`.

    Parameters
    ----------
    parameter : str
        Name of the physical parameter; in the formula of a class, the field that holds this name.
    expression : str
        Expression in q (displacement of the joint), v (its velocity), numbers and `LAW_FUNCTIONS`; in the formula of a
        class, also in its shape parameters.
    length_power, time_power : int
        Dimension of the expression as length^a / time^b, which determines the unit of the parameter.
    signed : bool
        Whether the parameter may be negative.
    per_log : bool
        Whether the parameter is a property of a log, not of the axis.
    """

    parameter: str
    expression: str
    length_power: int = 0
    time_power: int = 0
    signed: bool = False
    per_log: bool = False

    def unit(self, force: Unit, length: Unit) -> Unit:
        """Unit of the parameter in a joint with these units of force and displacement."""
        return force / length**self.length_power * Unit.of("s") ** self.time_power

    @property
    def is_linear(self) -> bool:
        """Whether the term is linear in the motion, so that its joint need not be measured."""
        return self.expression in ("q", "v")


Scale: TypeAlias = Literal["speed", "stroke", "deflection"]
"""Motion of a joint in a log: highest speed, stroke, largest displacement in either direction."""


@dataclass(frozen=True)
class ShapeParameter:
    """A number of a law in which the force is not linear, such as a pitch; always positive.

    Parameters
    ----------
    field : str
        Field that holds it; formulas use this name.
    symbol : str
        Its name in a diagnosis.
    scale : str
        Quantity of the log to which it is relative, which also determines its unit, see `Scale`.
    trials : tuple of (float, float, int), optional
        Values that a diagnosis tries: lowest and highest in multiples of the scale, and their number, spaced
        logarithmically. None if the effect has its own search.
    bounds : tuple of (float, float), optional
        Bounds of a fit in multiples of the scale.
    """

    field: str
    symbol: str
    scale: Scale
    trials: tuple[float, float, int] | None = None
    bounds: tuple[float, float] | None = None


@dataclass(frozen=True)
class Hypothesis:
    """The form in which a diagnosis considers a law that may be missing from a model.

    Parameters
    ----------
    effect : str
        Name of the effect.
    symbols : tuple of str
        Names of the parameters in the diagnosis: those of the laws in `together`, then its own, in the order of the
        formulas. If there are fewer symbols than terms, the last terms are omitted.
    together : tuple of Law classes
        Laws that are added with it.
    beside : tuple of classes
        Laws or weights that must already be declared in the joint.
    without : tuple of classes
        Laws or weights that must not be declared there, because they act alike.
    """

    effect: str
    symbols: tuple[str, ...]
    together: tuple[type[Law], ...] = ()
    beside: tuple[type[Law | PendulumWeight], ...] = ()
    without: tuple[type[Law | PendulumWeight], ...] = ()


@dataclass(frozen=True)
class Law(ABC):
    """Base of all force laws.

    A law is one class: its fields, and its `formula`, the force that opposes the motion of its joint. If it has
    `hypotheses`, a diagnosis considers it too.

    Parameters
    ----------
    at : Body or Between
        The joint in which the law acts: a body stands for the joint between it and its base.

    Examples
    --------
    >>> from symid import Body, StribeckFriction
    >>> StribeckFriction.formula[0].expression
    'sign(v)*exp(-(v/velocity)**2)'
    >>> StribeckFriction(Body("motor", mass="M"), "dF", velocity=0.02).terms()[0].expression
    'sign(v)*exp(-(v/0.02)**2)'
    """

    at: Joint
    formula: ClassVar[tuple[Term, ...]] = ()
    """The force, in terms of the fields."""
    shape: ClassVar[tuple[ShapeParameter, ...]] = ()
    """Fields that hold numbers."""
    hypotheses: ClassVar[tuple[Hypothesis, ...]] = ()
    """Forms in which a diagnosis considers the law; the first names all its parameters."""
    once: ClassVar[bool] = False
    """Whether a diagnosis considers it only in joints without such a law."""
    by_direction: ClassVar[bool] = False
    """Whether it is other friction where an axis moves in one direction only, so that a diagnosis needs both."""
    in_spring: ClassVar[bool] = False
    """Whether it belongs to a spring, with q as the deflection of the spring."""
    moves_hidden: ClassVar[bool] = True
    """Whether it may change the motion of an unmeasured joint so much that a diagnosis must integrate that motion."""
    refines: ClassVar[tuple[type[Law], ...]] = ()
    """Simpler laws that may explain the same gap: a diagnosis tries them too, and prefers them in a tie."""
    advice: ClassVar[str] = ""
    """Measurement that confirms the law; a diagnosis proposes it as the next experiment."""

    def terms(self) -> tuple[Term, ...]:
        """Terms of the force that opposes the motion."""
        numbers = {number.field: written(getattr(self, number.field)) for number in self.shape}
        return tuple(
            replace(
                term,
                parameter=self.named(term.parameter),
                expression=re.sub(r"[a-z_]+", lambda m: numbers.get(m[0], m[0]), term.expression),
            )
            for term in self.formula
        )

    def named(self, field: str) -> str:
        """Name of the parameter in a field; a known value gets a name from joint and field."""
        value: str = getattr(self, field)
        return f"{joint_label(self.at)}_{field}" if is_number(value) else value

    def numbers(self) -> dict[str, float]:
        """Known values by the names of their parameters."""
        given = {term.parameter: getattr(self, term.parameter) for term in self.formula}
        return {self.named(field): float(value) for field, value in given.items() if is_number(value)}

    def faults(self) -> Iterator[str]:
        """Faults of the law's numbers, which `Axis` reports with all others."""
        for number in self.shape:
            value = getattr(self, number.field)
            if not (is_finite(value) and value > 0):
                yield f"{number.field} is {value!r}: it must be a positive finite number"


def is_finite(value: object) -> bool:
    """Whether a value is a finite number; booleans are not numbers."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def written(number: float) -> str:
    """A number as text for an expression, equal for 1, 1.0 and a NumPy number; the `repr` of anything else.

    >>> written(1), written(0.02), written("wide")
    ('1.0', '0.02', "'wide'")
    """
    return repr(float(number)) if isinstance(number, (int, float)) else repr(number)
