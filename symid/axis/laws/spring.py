"""Laws of springs, with the deflection q."""

from dataclasses import dataclass
from typing import ClassVar

from symid.axis.elements import Parameter
from symid.axis.laws.law import Hypothesis, Law, ShapeParameter, Term

__all__ = ["Backlash", "GapDamping", "SpringDamping", "StiffnessNonlinearity"]


@dataclass(frozen=True)
class StiffnessNonlinearity(Law):
    """A spring that stiffens or softens with its deflection: k3 q^3, beside a `Spring` in the same joint.

    Parameters
    ----------
    cubic : str
        Parameter k3 in N/m^3 or N m/rad^3; negative for a softening spring.

    Examples
    --------
    >>> from symid import Between, Body, StiffnessNonlinearity
    >>> motor, load = Body("motor", mass="Mm"), Body("load", mass="Ml")
    >>> StiffnessNonlinearity(Between(first=motor, second=load), "k3").terms()[0].expression
    'q**3'
    """

    cubic: Parameter
    formula: ClassVar = (Term("cubic", "q**3", 3, signed=True),)
    hypotheses: ClassVar = (Hypothesis("stiffness_nonlinearity", ("k3",)),)
    in_spring: ClassVar = True
    advice: ClassVar = "accelerate at several levels up to the limit"


@dataclass(frozen=True)
class SpringDamping(Law):
    """Damping of a spring that is declared without it: Fd v, beside a `Spring` in the same joint.

    In a declaration, ``Spring(..., damping="Fd")`` is the same.

    Parameters
    ----------
    damping : str
        Parameter Fd in N s/m or N m s/rad.

    Examples
    --------
    >>> from symid import Between, Body, SpringDamping
    >>> motor, load = Body("motor", mass="Mm"), Body("load", mass="Ml")
    >>> SpringDamping(Between(first=motor, second=load), "Fd").terms()[0].expression
    'v'
    """

    damping: Parameter
    formula: ClassVar = (Term("damping", "v", 1, 1),)
    hypotheses: ClassVar = (Hypothesis("spring_damping", ("Fd",)),)
    in_spring: ClassVar = True
    once: ClassVar = True
    advice: ClassVar = "sweep slowly over the resonance, at two amplitudes"


@dataclass(frozen=True)
class Backlash(Law):
    """Play in a spring: -Kb clip(q, -gap/2, gap/2), beside a `Spring` of stiffness K in the same joint.

    With Kb = K the joint is free within the gap; with a smaller Kb it is softer there. The clipped value is written
    with absolute values: clip(q, -b, b) = (abs(q + b) - abs(q - b))/2.

    Parameters
    ----------
    at : Body or Between
        The joint of the spring.
    stiffness : str
        Parameter Kb in N/m or N m/rad.
    gap : float
        Total width of the play in m or rad.

    Examples
    --------
    >>> from symid import Between, Body, Backlash
    >>> motor, load = Body("motor", mass="Mm"), Body("load", mass="Ml")
    >>> Backlash(Between(first=motor, second=load), "Kb", gap=2e-5).terms()[0].expression
    '(abs(q - 2e-05/2) - abs(q + 2e-05/2))/2'
    """

    stiffness: Parameter
    gap: float
    formula: ClassVar = (Term("stiffness", "(abs(q - gap/2) - abs(q + gap/2))/2", 1),)
    shape: ClassVar = (ShapeParameter("gap", "b", "deflection", trials=(0.04, 1.8, 10)),)
    hypotheses: ClassVar = (Hypothesis("backlash", ("Kb",)),)
    in_spring: ClassVar = True
    advice: ClassVar = "reverse slowly under small loads, so that the spring passes its zero often"


@dataclass(frozen=True)
class GapDamping(Law):
    """Damping that ends where the play of a spring begins: -Cb v within the gap, beside a `Backlash` of that gap.

    The damping of a `Spring` acts within the gap of its backlash too. With Cb equal to it the joint is free there, as
    with teeth that do not touch.

    Parameters
    ----------
    at : Body or Between
        The joint of the spring.
    damping : str
        Parameter Cb in N s/m or N m s/rad.
    gap : float
        Total width of the play in m or rad.

    Examples
    --------
    >>> from symid import Between, Body, GapDamping
    >>> motor, load = Body("motor", mass="Mm"), Body("load", mass="Ml")
    >>> GapDamping(Between(first=motor, second=load), "Cb", gap=2e-5).terms()[0].expression
    '-v*positive(2e-05/2 - q)*positive(2e-05/2 + q)'
    """

    damping: Parameter
    gap: float
    formula: ClassVar = (Term("damping", "-v*positive(gap/2 - q)*positive(gap/2 + q)", 1, 1),)
    shape: ClassVar = (ShapeParameter("gap", "b", "deflection"),)
    in_spring: ClassVar = True
