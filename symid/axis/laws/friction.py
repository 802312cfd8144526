"""Friction as a function of velocity: viscous, Coulomb, Stribeck, drag, and differences between directions."""

from dataclasses import dataclass
from typing import ClassVar

from symid.axis.elements import Parameter
from symid.axis.laws.constant import OffsetForce
from symid.axis.laws.law import Hypothesis, Law, ShapeParameter, Term

__all__ = [
    "AsymmetricFriction",
    "CoulombFriction",
    "FrictionAsymmetry",
    "QuadraticDrag",
    "StribeckFriction",
    "ViscousAsymmetry",
    "ViscousFriction",
]


@dataclass(frozen=True)
class ViscousFriction(Law):
    """Fv v, paper eq. [1].

    Parameters
    ----------
    coefficient : str
        Parameter Fv in N s/m or N m s/rad.
    """

    coefficient: Parameter
    formula: ClassVar = (Term("coefficient", "v", 1, 1),)
    hypotheses: ClassVar = (Hypothesis("viscous_friction", ("Fv",)),)
    once: ClassVar = True
    advice: ClassVar = "move at several constant speeds in both directions"


@dataclass(frozen=True)
class CoulombFriction(Law):
    """Fs sign(v), paper eq. [2].

    Parameters
    ----------
    level : str
        Parameter Fs in N or N m.
    """

    level: Parameter
    formula: ClassVar = (Term("level", "sign(v)"),)
    hypotheses: ClassVar = (Hypothesis("coulomb_friction", ("Fs",)),)
    once: ClassVar = True
    advice: ClassVar = "move at constant speeds in both directions"


@dataclass(frozen=True)
class AsymmetricFriction(Law):
    """Viscous and Coulomb friction whose coefficients differ by direction of motion.

    Parameters
    ----------
    viscous, coulomb : tuple of str
        Parameter names for motion in positive and in negative direction.
    """

    viscous: tuple[str, str]
    coulomb: tuple[str, str]

    def terms(self) -> tuple[Term, ...]:
        """Viscous and Coulomb friction of each direction."""
        forward, backward = "positive(v)", "positive(-v)"
        return (
            Term(self.viscous[0], f"v*{forward}", 1, 1),
            Term(self.coulomb[0], forward),
            Term(self.viscous[1], f"v*{backward}", 1, 1),
            Term(self.coulomb[1], f"-{backward}"),
        )


@dataclass(frozen=True)
class FrictionAsymmetry(Law):
    """Difference of friction between directions: dFs + dFv abs(v), beside Coulomb and viscous friction.

    The parameters are half the differences of level and coefficient, forward minus backward; `AsymmetricFriction` has a
    level and a coefficient for each direction instead. While an axis moves, dFs alone is a constant force, which a
    diagnosis considers too.

    Parameters
    ----------
    coulomb, viscous : str
        Parameters dFs in N or N m and dFv in N s/m or N m s/rad; both may be negative.

    Examples
    --------
    >>> from symid import Body, FrictionAsymmetry
    >>> [term.expression for term in FrictionAsymmetry(Body("motor", mass="M"), "dFs", "dFv").terms()]
    ['1', 'abs(v)']
    """

    coulomb: Parameter
    viscous: Parameter
    formula: ClassVar = (Term("coulomb", "1", signed=True), Term("viscous", "abs(v)", 1, 1, signed=True))
    hypotheses: ClassVar = (
        Hypothesis("asymmetric_friction", ("dFs", "dFv"), without=(OffsetForce,)),
        Hypothesis("asymmetric_friction", ("dFs",), without=(OffsetForce,)),
    )
    by_direction: ClassVar = True
    refines: ClassVar = (OffsetForce,)
    advice: ClassVar = "move over the same stroke at the same speeds in both directions"


@dataclass(frozen=True)
class ViscousAsymmetry(Law):
    """Difference of viscous friction between directions: dFv abs(v), beside a constant force.

    Parameters
    ----------
    viscous : str
        Parameter dFv in N s/m or N m s/rad, half the difference of the coefficients, forward minus backward; it may be
        negative.

    Examples
    --------
    >>> from symid import Body, ViscousAsymmetry
    >>> ViscousAsymmetry(Body("motor", mass="M"), "dFv").terms()[0].expression
    'abs(v)'
    """

    viscous: Parameter
    formula: ClassVar = (Term("viscous", "abs(v)", 1, 1, signed=True),)
    hypotheses: ClassVar = (Hypothesis("asymmetric_friction", ("dFv",), beside=(OffsetForce,)),)


@dataclass(frozen=True)
class StribeckFriction(Law):
    """Friction that is higher at low speed: dF sign(v) exp(-(v/velocity)^2), beside Coulomb friction.

    Parameters
    ----------
    level : str
        Parameter dF in N or N m, the excess of friction at rest over the Coulomb level.
    velocity : float
        Stribeck velocity in m/s or rad/s, at which the excess is dF/e.

    Examples
    --------
    >>> from symid import Body, StribeckFriction
    >>> [term.expression for term in StribeckFriction(Body("motor", mass="M"), "dF", velocity=0.02).terms()]
    ['sign(v)*exp(-(v/0.02)**2)']
    """

    level: Parameter
    velocity: float
    formula: ClassVar = (Term("level", "sign(v)*exp(-(v/velocity)**2)"),)
    shape: ClassVar = (ShapeParameter("velocity", "vs", "speed", trials=(0.006, 0.6, 12)),)
    hypotheses: ClassVar = (Hypothesis("stribeck_friction", ("dF",)),)
    refines: ClassVar = (CoulombFriction,)
    advice: ClassVar = "move at five to ten constant speeds below 10 % of the highest"


@dataclass(frozen=True)
class QuadraticDrag(Law):
    """Drag of air or oil: c v abs(v).

    Parameters
    ----------
    coefficient : str
        Parameter c in N s^2/m^2 = kg/m, or N m s^2/rad^2.

    Examples
    --------
    >>> from symid import Body, QuadraticDrag
    >>> QuadraticDrag(Body("motor", mass="M"), "c").terms()[0].expression
    'v*abs(v)'
    """

    coefficient: Parameter
    formula: ClassVar = (Term("coefficient", "v*abs(v)", 2, 2),)
    hypotheses: ClassVar = (Hypothesis("quadratic_drag", ("c",)),)
    advice: ClassVar = "move at several high constant speeds"
