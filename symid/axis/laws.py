"""Force laws in joints and springs: friction and every other effect that an axis may have.

A law is one class. It says where it sits and what force opposes the motion there, as a sum of terms
``parameter * expression(q, v)``, q and v being displacement and velocity of the joint. The expression is
text, so that declaring an axis needs no sympy; derivation, generated code and simulation all read the
same text. To add a law, subclass `Law` and give its `terms`.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from symid.axis.elements import Joint
from symid.units import Unit

FUNCTIONS = ("sign", "positive", "sin", "cos", "exp", "abs")
"""Functions that an expression may use. positive(v) is 1 for v > 0 and 0 otherwise."""


@dataclass(frozen=True)
class Term:
    """One term of a law: `parameter` times `expression`.

    Parameters
    ----------
    parameter : str
        Name of the physical parameter.
    expression : str
        In q (displacement of the joint), v (its velocity), numbers and `FUNCTIONS`.
    length_power, time_power : int
        Dimension of the expression as length^a / time^b, from which the parameter's unit follows.
    signed : bool
        Whether the parameter may be negative.
    per_log : bool
        Whether the parameter belongs to a log and not to the axis.
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
        """Whether the term is linear in the motion, so that it needs no measured coordinate."""
        return self.expression in ("q", "v")


@dataclass(frozen=True)
class Law(ABC):
    """Base of all force laws.

    Parameters
    ----------
    at : Body or Between
        The joint in which the law acts: a body stands for the joint between it and what it is on.
    """

    at: Joint
    shape: ClassVar[tuple[str, ...]] = ()
    """Fields that are numbers in which the force is not linear, such as a pitch; all positive."""

    @abstractmethod
    def terms(self) -> tuple[Term, ...]:
        """Terms of the force that opposes the motion."""

    def faults(self) -> Iterator[str]:
        """What is wrong with the numbers of the law; `Axis` reports it with all other faults."""
        for name in self.shape:
            value = getattr(self, name)
            if not (is_finite(value) and value > 0):
                yield f"{name} is {value!r}: it must be a positive finite number"


def is_finite(value: object) -> bool:
    """Whether a value is a finite number (a truth value is none)."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def written(number: float) -> str:
    """A number as text for an expression, the same for 1, 1.0 and a NumPy number; anything else as it is.

    Examples
    --------
    >>> written(1), written(0.02), written("wide")
    ('1.0', '0.02', "'wide'")
    """
    return repr(float(number)) if isinstance(number, (int, float)) else repr(number)


@dataclass(frozen=True)
class ViscousFriction(Law):
    """Fv v, paper eq. [1]."""

    coefficient: str

    def terms(self) -> tuple[Term, ...]:
        return (Term(self.coefficient, "v", 1, 1),)


@dataclass(frozen=True)
class CoulombFriction(Law):
    """Fs sign(v), paper eq. [2]."""

    level: str

    def terms(self) -> tuple[Term, ...]:
        return (Term(self.level, "sign(v)"),)


@dataclass(frozen=True)
class AsymmetricFriction(Law):
    """Viscous and Coulomb friction whose coefficients differ by direction of motion.

    Parameters
    ----------
    at : Body or Between
        The joint.
    viscous, coulomb : tuple of str
        Parameter names for motion in positive and in negative direction.
    """

    viscous: tuple[str, str]
    coulomb: tuple[str, str]

    def terms(self) -> tuple[Term, ...]:
        forward, backward = "positive(v)", "positive(-v)"
        return (
            Term(self.viscous[0], f"v*{forward}", 1, 1),
            Term(self.coulomb[0], forward),
            Term(self.viscous[1], f"v*{backward}", 1, 1),
            Term(self.coulomb[1], f"-{backward}"),
        )


@dataclass(frozen=True)
class OffsetForce(Law):
    """A constant force against the positive direction: drive offset, spring preload."""

    level: str

    def terms(self) -> tuple[Term, ...]:
        return (Term(self.level, "1", signed=True),)


@dataclass(frozen=True)
class UnknownZero(Law):
    """The force of a spring whose deflection is measured from an unknown zero, as between two incremental encoders.

    It acts like a preload, but has another value in each log: it is estimated with each log and says nothing
    of the axis.
    """

    preload: str

    def terms(self) -> tuple[Term, ...]:
        return (Term(self.preload, "1", signed=True, per_log=True),)
