"""The symbolic half: Lagrange's equations, elimination, minimal parameters and their maps."""

from symid.symbolic.expressions import (
    FORCE,
    MEMORY,
    READING,
    TIME,
    imperfection_law,
    imperfection_rate,
    is_smooth,
    law_expression,
    misread,
    parameter_symbol,
    positive,
)
from symid.symbolic.forward_terms import ForwardTerms, forward_terms
from symid.symbolic.lagrange import Kinematics, inverse_dynamics
from symid.symbolic.measurement import measurement
from symid.symbolic.minimal import MinimalModel, MinimalParameter
from symid.symbolic.operators import Functional, by_power
from symid.symbolic.parameter_function import ParameterFunction
from symid.symbolic.parameter_map import inverse_map
from symid.symbolic.pipeline import DerivedModel, derive
from symid.symbolic.polynomials import expression, factored
from symid.symbolic.triangular_systems import TriangularSolution

__all__ = [
    "FORCE",
    "MEMORY",
    "READING",
    "TIME",
    "DerivedModel",
    "ForwardTerms",
    "Functional",
    "Kinematics",
    "MinimalModel",
    "MinimalParameter",
    "ParameterFunction",
    "TriangularSolution",
    "by_power",
    "derive",
    "expression",
    "factored",
    "forward_terms",
    "imperfection_law",
    "imperfection_rate",
    "inverse_dynamics",
    "inverse_map",
    "is_smooth",
    "law_expression",
    "measurement",
    "misread",
    "parameter_symbol",
    "positive",
]
