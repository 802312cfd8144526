"""Forward dynamics of an axis, from the balances and laws from which the regressors come.

M x(2) + C x(1) + K x = B F + c - sum_j d_j f_j(d_j x, d_j x(1)), x being the absolute displacements of the free
bodies, F the drive forces, d_j the direction of a joint and f_j the nonlinear laws in it. The simulation evaluates
these terms as numbers, exports write them as expressions.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import sympy as sp
from sympy.polys.rings import PolyElement

from symid.axis import Axis
from symid.symbolic.lagrange import ONE_INPUT, Kinematics, inverse_dynamics
from symid.symbolic.operators import Functional, OperatorModel, by_power, operator_model
from symid.symbolic.readings import ReadingTerms, sensor_terms

Matrix: TypeAlias = tuple[tuple[PolyElement, ...], ...]
"""Polynomials of the physical parameters, by row."""


class SymbolicLawTerm(NamedTuple):
    """A nonlinear law: `parameter` times `expression`, in q and v of the joint with a displacement."""

    displacement: Functional
    parameter: PolyElement
    expression: sp.Expr


@dataclass(frozen=True, eq=False)
class ForwardTerms:
    """The terms of the equation above."""

    operators: OperatorModel  # balances from which they come, and the ring of the polynomials
    bodies: tuple[str, ...]  # free bodies, in the order of the displacements
    # stiffness, damping, mass: shape (n, n): K, C and M
    stiffness: Matrix
    damping: Matrix
    mass: Matrix
    drives: Matrix  # shape (n, n_drives): B
    constant: Matrix  # shape (n, 1): c
    laws: tuple[SymbolicLawTerm, ...]  # all nonlinear laws
    readings: Mapping[str, ReadingTerms]  # what each sensor reads
    # known numbers that stand in the terms as symbols: ratios, gravity, known parameters
    constants: Mapping[str, float]


def forward_terms(axis: Axis) -> ForwardTerms:
    """Terms of the forward dynamics of an axis.

    >>> from symid.axis import load_axis
    >>> terms = forward_terms(load_axis("rigid_1m"))
    >>> terms.mass, terms.laws[0].parameter, terms.laws[0].expression
    (((M,),), Fs, sign(v))
    """
    operators, kinematics = operator_model(inverse_dynamics(axis)), Kinematics(axis)
    bodies, zero = tuple(operators.motion), operators.ring.zero
    powers = [[by_power(operators.motion[b].get(x)) for x in bodies] for b in bodies]
    stiffness, damping, mass = (
        tuple(tuple(entry.get(order, zero) for entry in row) for row in powers) for order in range(3)
    )
    laws = []
    for entry in operators.source.inputs:
        if entry.expression.free_symbols:
            displacement = operators.functional(kinematics.displacement(entry.joint))
            # In the balance of a body the law's parameter stands times the share of that body in the displacement.
            body, share = next(iter(displacement.items()))
            parameter = operators.inputs[body][str(entry.symbol)].mul_ground(1 / share)
            laws.append(SymbolicLawTerm(displacement, parameter, entry.expression))
    return ForwardTerms(
        operators=operators,
        bodies=bodies,
        stiffness=stiffness,
        damping=damping,
        mass=mass,
        drives=tuple(tuple(-operators.force[b].get(d.signal, zero) for d in axis.drives) for b in bodies),
        constant=tuple((-operators.inputs[b].get(str(ONE_INPUT), zero),) for b in bodies),
        laws=tuple(laws),
        readings={s.signal: sensor_terms(operators, s) for s in axis.sensors},
        constants={**operators.source.numbers, **kinematics.constants},
    )
