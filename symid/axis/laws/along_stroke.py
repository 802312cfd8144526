"""Forces and friction that vary along the stroke: stiffness, cogging, position-dependent friction."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from symid.axis.elements import Body, Parameter, PendulumWeight
from symid.axis.laws.friction import CoulombFriction, ViscousFriction
from symid.axis.laws.law import Hypothesis, Law, ShapeParameter, Term

__all__ = [
    "Cogging",
    "PeriodicFriction",
    "PositionDependentFriction",
    "PositionDependentViscousFriction",
    "PositionStiffness",
    "Unbalance",
]

_PHASE = f"{math.tau!r}*q/pitch"
_ALONG = "move slowly over the whole stroke in both directions"


@dataclass(frozen=True)
class PositionStiffness(Law):
    """A force proportional to the displacement, k q: cable chain, bellows, the tilt of a spring balance.

    It is a linear spring, so that its joint need not be measured, but k may be negative.

    Parameters
    ----------
    stiffness : str
        Parameter k in N/m or N m/rad.

    Examples
    --------
    >>> from symid import Body, PositionStiffness
    >>> PositionStiffness(Body("motor", mass="M"), "k").terms()[0].is_linear
    True
    """

    stiffness: Parameter
    formula: ClassVar = (Term("stiffness", "q", 1, signed=True),)
    hypotheses: ClassVar = (Hypothesis("position_stiffness", ("k",)),)
    advice: ClassVar = _ALONG


@dataclass(frozen=True)
class Unbalance(Law):
    """The weight of a turning body whose centre of gravity is at an unknown angle: Gs sin(q) + Gc cos(q).

    It is m g l sin(q + phase) with phase = atan2(Gc, Gs) and m g l = sqrt(Gs^2 + Gc^2): the body hangs at q = -phase.

    Parameters
    ----------
    at : Body
        A body that turns about a horizontal axis, on a base that does not turn.
    sine, cosine : str
        Parameters Gs and Gc in N m; both may be negative.

    Examples
    --------
    >>> from symid import Body, Unbalance
    >>> [term.expression for term in Unbalance(Body("table", inertia="J"), "Gs", "Gc").terms()]
    ['cos(q)', 'sin(q)']
    """

    sine: Parameter
    cosine: Parameter
    formula: ClassVar = (Term("cosine", "cos(q)", signed=True), Term("sine", "sin(q)", signed=True))
    # beside a weight that is declared, the zero of its angle may be wrong: m l g sin(q + phase) less what is declared
    hypotheses: ClassVar = (
        Hypothesis("weight", ("Gc", "Gs"), without=(PendulumWeight,)),
        Hypothesis("weight", ("Gc",), beside=(PendulumWeight,)),
    )
    once: ClassVar = True
    moves_hidden: ClassVar = False
    advice: ClassVar = "hold the axis at rest at several angles, each approached from both sides"

    def faults(self) -> Iterator[str]:
        """Faults of the joint, whose q must be an angle relative to the ground."""
        yield from super().faults()
        if not (isinstance(self.at, Body) and self.at.turns):
            yield "at must be a body that turns: use Weight where it slides"
        elif isinstance(self.at.on, Body) and self.at.on.turns:
            yield f"its angle is relative to {self.at.on.name!r}, which turns too: put the body on the ground"


@dataclass(frozen=True)
class Cogging(Law):
    """Force ripple along the stroke: As sin(2 pi q/pitch) + Ac cos(2 pi q/pitch).

    Parameters
    ----------
    sine, cosine : str
        Parameters As and Ac in N or N m; both may be negative.
    pitch : float
        Length of a period in m or rad.

    Examples
    --------
    >>> from symid import Body, Cogging
    >>> [term.expression for term in Cogging(Body("motor", mass="M"), "As", "Ac", pitch=0.03).terms()]
    ['sin(6.283185307179586*q/0.03)', 'cos(6.283185307179586*q/0.03)']
    """

    sine: Parameter
    cosine: Parameter
    pitch: float
    formula: ClassVar = (
        Term("sine", f"sin({_PHASE})", signed=True),
        Term("cosine", f"cos({_PHASE})", signed=True),
    )
    shape: ClassVar = (ShapeParameter("pitch", "pitch", "stroke"),)
    hypotheses: ClassVar = (Hypothesis("cogging", ("As", "Ac")),)
    moves_hidden: ClassVar = False
    refines: ClassVar = (Unbalance,)
    advice: ClassVar = (
        "move slowly at two speeds over the whole stroke: "
        "ripple of the stroke scales its frequency with speed"
    )


@dataclass(frozen=True)
class PeriodicFriction(Law):
    """A Coulomb level that is periodic along the stroke: sign(v) (dFs sin(2 pi q/pitch) + dFc cos(2 pi q/pitch)).

    Declare it beside Coulomb friction, so that the total level is positive everywhere.

    Parameters
    ----------
    sine, cosine : str
        Parameters dFs and dFc in N or N m; both may be negative.
    pitch : float
        Length of a period in m or rad.

    Examples
    --------
    >>> from symid import Body, PeriodicFriction
    >>> PeriodicFriction(Body("motor", mass="M"), "dFs", "dFc", pitch=0.5).terms()[0].expression
    'sign(v)*sin(6.283185307179586*q/0.5)'
    """

    sine: Parameter
    cosine: Parameter
    pitch: float
    formula: ClassVar = (
        Term("sine", f"sign(v)*sin({_PHASE})", signed=True),
        Term("cosine", f"sign(v)*cos({_PHASE})", signed=True),
    )
    shape: ClassVar = (
        ShapeParameter("pitch", "pitch", "stroke", trials=(0.15, 2.0, 12), bounds=(0.02, 4.0)),
    )
    hypotheses: ClassVar = (
        Hypothesis("position_dependent_friction", ("dFs", "dFc"), beside=(CoulombFriction,)),
        Hypothesis("position_dependent_friction", ("Fs", "dFs", "dFc"), together=(CoulombFriction,)),
    )
    refines: ClassVar = (CoulombFriction,)
    advice: ClassVar = _ALONG


@dataclass(frozen=True)
class PositionDependentFriction(Law):
    """A Coulomb level that changes along the stroke: sign(v) (dF1 q + dF2 q^2).

    Declare it beside Coulomb friction, which is then the level at q = 0.

    Parameters
    ----------
    linear, quadratic : str
        Parameters dF1 in N/m or N m/rad, dF2 in N/m^2 or N m/rad^2; both may be negative.

    Examples
    --------
    >>> from symid import Body, PositionDependentFriction
    >>> PositionDependentFriction(Body("motor", mass="M"), "dF1", "dF2").terms()[1].expression
    'sign(v)*q**2'
    """

    linear: Parameter
    quadratic: Parameter
    formula: ClassVar = (
        Term("linear", "sign(v)*q", 1, signed=True),
        Term("quadratic", "sign(v)*q**2", 2, signed=True),
    )
    hypotheses: ClassVar = (
        Hypothesis("position_dependent_friction", ("dF1", "dF2"), beside=(CoulombFriction,)),
        Hypothesis("position_dependent_friction", ("Fs", "dF1", "dF2"), together=(CoulombFriction,)),
    )
    moves_hidden: ClassVar = False
    refines: ClassVar = (CoulombFriction,)
    advice: ClassVar = _ALONG


@dataclass(frozen=True)
class PositionDependentViscousFriction(Law):
    """A viscous coefficient that changes along the stroke: v (dFv1 q + dFv2 q^2), beside `ViscousFriction`.

    Parameters
    ----------
    linear, quadratic : str
        Parameters dFv1 in N s/m^2 or N m s/rad^2, dFv2 in N s/m^3 or N m s/rad^3; both may be negative.

    Examples
    --------
    >>> from symid import Body, PositionDependentViscousFriction
    >>> PositionDependentViscousFriction(Body("motor", mass="M"), "dFv1", "dFv2").terms()[1].expression
    'v*q**2'
    """

    linear: Parameter
    quadratic: Parameter
    formula: ClassVar = (
        Term("linear", "v*q", 2, 1, signed=True),
        Term("quadratic", "v*q**2", 3, 1, signed=True),
    )
    hypotheses: ClassVar = (
        Hypothesis("position_dependent_friction", ("dFv1", "dFv2"), beside=(ViscousFriction,)),
        Hypothesis(
            "position_dependent_friction",
            ("dFs1", "dFs2", "dFv1", "dFv2"),
            together=(PositionDependentFriction,),
            beside=(ViscousFriction, CoulombFriction),
        ),
    )
    refines: ClassVar = (CoulombFriction,)
    advice: ClassVar = _ALONG
