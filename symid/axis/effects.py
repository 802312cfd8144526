"""Force laws of the effects that simple models leave out: friction that varies, ripple, backlash, springs that bend.

Amplitudes are parameters to identify; what an amplitude cannot scale, such as a pitch, is a number of the declaration.
q and v are displacement and velocity of the joint, forces count against the positive direction.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from symid.axis.laws import Law, Term, written


@dataclass(frozen=True)
class StribeckFriction(Law):
    """Friction that is higher at low speed: dF sign(v) exp(-(v/velocity)^2), beside Coulomb friction.

    Parameters
    ----------
    at : Body or Between
        The joint.
    level : str
        Parameter dF in N or N m, by which friction at rest exceeds the Coulomb level.
    velocity : float
        Stribeck velocity in m/s or rad/s: from it on, the excess falls below dF/e.

    Examples
    --------
    >>> from symid import Body, StribeckFriction
    >>> [term.expression for term in StribeckFriction(Body("motor", mass="M"), "dF", velocity=0.02).terms()]
    ['sign(v)*exp(-(v/0.02)**2)']
    """

    level: str
    velocity: float
    shape: ClassVar = ("velocity",)

    def terms(self) -> tuple[Term, ...]:
        return (Term(self.level, f"sign(v)*exp(-(v/{written(self.velocity)})**2)"),)


@dataclass(frozen=True)
class QuadraticDrag(Law):
    """Drag of air or oil: c v abs(v).

    Parameters
    ----------
    at : Body or Between
        The joint.
    coefficient : str
        Parameter c in N s^2/m^2 = kg/m, or N m s^2/rad^2.

    Examples
    --------
    >>> from symid import Body, QuadraticDrag
    >>> QuadraticDrag(Body("motor", mass="M"), "c").terms()[0].expression
    'v*abs(v)'
    """

    coefficient: str

    def terms(self) -> tuple[Term, ...]:
        return (Term(self.coefficient, "v*abs(v)", 2, 2),)


@dataclass(frozen=True)
class PositionStiffness(Law):
    """A force that grows with displacement, k q: cable chain, bellows, the tilt of a spring balance.

    It is a linear spring (no sensor need see the joint), but k may be negative.

    Parameters
    ----------
    at : Body or Between
        The joint.
    stiffness : str
        Parameter k in N/m or N m/rad.

    Examples
    --------
    >>> from symid import Body, PositionStiffness
    >>> PositionStiffness(Body("motor", mass="M"), "k").terms()[0].is_linear
    True
    """

    stiffness: str

    def terms(self) -> tuple[Term, ...]:
        return (Term(self.stiffness, "q", 1, signed=True),)


@dataclass(frozen=True)
class Cogging(Law):
    """Force ripple along the stroke: As sin(2 pi q/pitch) + Ac cos(2 pi q/pitch).

    Parameters
    ----------
    at : Body or Between
        The joint.
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

    sine: str
    cosine: str
    pitch: float
    shape: ClassVar = ("pitch",)

    def terms(self) -> tuple[Term, ...]:
        sine, cosine = _waves(self.pitch)
        return Term(self.sine, sine, signed=True), Term(self.cosine, cosine, signed=True)


@dataclass(frozen=True)
class PeriodicFriction(Law):
    """A Coulomb level that repeats along the stroke: sign(v) (Fss sin(2 pi q/pitch) + Fsc cos(2 pi q/pitch)).

    Declare it beside Coulomb friction, so that the level stays above 0 everywhere.

    Parameters
    ----------
    at : Body or Between
        The joint.
    sine, cosine : str
        Parameters Fss and Fsc in N or N m; both may be negative.
    pitch : float
        Length of a period in m or rad.

    Examples
    --------
    >>> from symid import Body, PeriodicFriction
    >>> PeriodicFriction(Body("motor", mass="M"), "Fss", "Fsc", pitch=0.5).terms()[0].expression
    'sign(v)*sin(6.283185307179586*q/0.5)'
    """

    sine: str
    cosine: str
    pitch: float
    shape: ClassVar = ("pitch",)

    def terms(self) -> tuple[Term, ...]:
        sine, cosine = (f"sign(v)*{wave}" for wave in _waves(self.pitch))
        return Term(self.sine, sine, signed=True), Term(self.cosine, cosine, signed=True)


@dataclass(frozen=True)
class PositionDependentFriction(Law):
    """A Coulomb level that changes along the stroke: sign(v) (Fs1 q + Fs2 q^2).

    Declare it beside Coulomb friction, which is then the level at q = 0.

    Parameters
    ----------
    at : Body or Between
        The joint.
    linear, quadratic : str
        Parameters Fs1 in N/m or N m/rad, Fs2 in N/m^2 or N m/rad^2; both may be negative.

    Examples
    --------
    >>> from symid import Body, PositionDependentFriction
    >>> PositionDependentFriction(Body("motor", mass="M"), "Fs1", "Fs2").terms()[1].expression
    'sign(v)*q**2'
    """

    linear: str
    quadratic: str

    def terms(self) -> tuple[Term, ...]:
        return Term(self.linear, "sign(v)*q", 1, signed=True), Term(
            self.quadratic, "sign(v)*q**2", 2, signed=True
        )


@dataclass(frozen=True)
class PositionDependentViscousFriction(Law):
    """A viscous coefficient that changes along the stroke: v (Fv1 q + Fv2 q^2), beside `ViscousFriction`.

    Parameters
    ----------
    at : Body or Between
        The joint.
    linear, quadratic : str
        Parameters Fv1 in N s/m^2 or N m s/rad^2, Fv2 in N s/m^3 or N m s/rad^3; both may be negative.

    Examples
    --------
    >>> from symid import Body, PositionDependentViscousFriction
    >>> PositionDependentViscousFriction(Body("motor", mass="M"), "Fv1", "Fv2").terms()[1].expression
    'v*q**2'
    """

    linear: str
    quadratic: str

    def terms(self) -> tuple[Term, ...]:
        return Term(self.linear, "v*q", 2, 1, signed=True), Term(self.quadratic, "v*q**2", 3, 1, signed=True)


@dataclass(frozen=True)
class StiffnessNonlinearity(Law):
    """A spring that becomes harder with its deflection, or softer: k3 q^3, beside a `Spring` in the same joint.

    Parameters
    ----------
    at : Body or Between
        The joint.
    cubic : str
        Parameter k3 in N/m^3 or N m/rad^3; negative where the spring becomes softer.

    Examples
    --------
    >>> from symid import Between, Body, StiffnessNonlinearity
    >>> motor, load = Body("motor", mass="Mm"), Body("load", mass="Ml")
    >>> StiffnessNonlinearity(Between(first=motor, second=load), "k3").terms()[0].expression
    'q**3'
    """

    cubic: str

    def terms(self) -> tuple[Term, ...]:
        return (Term(self.cubic, "q**3", 3, signed=True),)


@dataclass(frozen=True)
class Backlash(Law):
    """Play in a spring: -Kb clip(q, -gap/2, gap/2), beside a `Spring` of stiffness K in the same joint.

    With Kb = K the joint is free within the gap; with a smaller Kb it is softer there. A clipped value is half the
    difference of two absolute values: clip(q, -b, b) = (abs(q + b) - abs(q - b))/2.

    Parameters
    ----------
    at : Body or Between
        The joint of the spring.
    stiffness : str
        Parameter Kb in N/m or N m/rad.
    gap : float
        Width of the play in m or rad, all of it.

    Examples
    --------
    >>> from symid import Between, Body, Backlash
    >>> motor, load = Body("motor", mass="Mm"), Body("load", mass="Ml")
    >>> Backlash(Between(first=motor, second=load), "Kb", gap=2e-5).terms()[0].expression
    '(abs(q - 2e-05/2) - abs(q + 2e-05/2))/2'
    """

    stiffness: str
    gap: float
    shape: ClassVar = ("gap",)

    def terms(self) -> tuple[Term, ...]:
        edge = f"{written(self.gap)}/2"
        return (Term(self.stiffness, f"(abs(q - {edge}) - abs(q + {edge}))/2", 1),)


@dataclass(frozen=True)
class FrictionAsymmetry(Law):
    """What friction in both directions differs by: dFs + dFv abs(v), beside Coulomb and viscous friction.

    The parameters are half the differences of the levels and coefficients of both directions, forward less backward.
    `AsymmetricFriction` says the same with a level and a coefficient for each direction.

    Parameters
    ----------
    at : Body or Between
        The joint.
    coulomb, viscous : str
        Parameters dFs in N or N m and dFv in N s/m or N m s/rad; both may be negative.

    Examples
    --------
    >>> from symid import Body, FrictionAsymmetry
    >>> [term.expression for term in FrictionAsymmetry(Body("motor", mass="M"), "dFs", "dFv").terms()]
    ['1', 'abs(v)']
    """

    coulomb: str
    viscous: str

    def terms(self) -> tuple[Term, ...]:
        return Term(self.coulomb, "1", signed=True), Term(self.viscous, "abs(v)", 1, 1, signed=True)


def _waves(pitch: float) -> tuple[str, str]:
    """Sine and cosine that repeat along the stroke."""
    phase = f"{math.tau!r}*q/{written(pitch)}"
    return f"sin({phase})", f"cos({phase})"
