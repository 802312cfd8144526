"""Constant forces: an offset of the drive, a preload."""

from dataclasses import dataclass
from typing import ClassVar

from symid.axis.elements import Parameter
from symid.axis.laws.law import Hypothesis, Law, Term

__all__ = ["OffsetForce", "UnknownZero"]


@dataclass(frozen=True)
class OffsetForce(Law):
    """A constant force against the positive direction: drive offset, spring preload.

    Parameters
    ----------
    level : str
        Parameter in N or N m; it may be negative.
    """

    level: Parameter
    formula: ClassVar = (Term("level", "1", signed=True),)
    hypotheses: ClassVar = (Hypothesis("offset_force", ("F0",)),)
    once: ClassVar = True
    moves_hidden: ClassVar = False
    advice: ClassVar = "turn the axis round, or unload it: a constant force stays, friction changes its sign"


@dataclass(frozen=True)
class UnknownZero(Law):
    """The force of a spring whose deflection is measured from an unknown zero, as between two incremental encoders.

    It acts like a preload, but its value differs from log to log: it is estimated for each log and is not a property of
    the axis.

    Parameters
    ----------
    at : Body or Between
        The joint of the spring.
    preload : str
        Parameter in N or N m; it may be negative.
    """

    preload: Parameter
    formula: ClassVar = (Term("preload", "1", signed=True, per_log=True),)
