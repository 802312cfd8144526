"""Force laws in joints and springs: friction and every other effect that an axis may have.

A law is one class. It states its joint and the force that opposes the motion there, as a sum of terms
``parameter * expression(q, v)`` with the displacement q and the velocity v of the joint. The expression is text, so
that declaring an axis needs no sympy; derivation, generated code, simulation, export and diagnosis all read this text.
All of symid knows the names that a module of this package lists in ``__all__``.

Amplitudes are parameters to identify. A quantity in which the force is not linear, such as a pitch, is a number of the
declaration.
"""

from symid.axis.laws import along_stroke, constant, friction, spring
from symid.axis.laws.along_stroke import *
from symid.axis.laws.constant import *
from symid.axis.laws.friction import *
from symid.axis.laws.law import Hypothesis, Law, ShapeParameter, Term
from symid.axis.laws.spring import *

__all__ = ["Hypothesis", "Law", "ShapeParameter", "Term"]
__all__ += along_stroke.__all__
__all__ += constant.__all__
__all__ += friction.__all__
__all__ += spring.__all__
