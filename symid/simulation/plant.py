"""The forward dynamics of an axis at given parameter values.

M x(2) + C x(1) + K x = B F + c - sum_j d_j f_j(d_j x, d_j x(1)), x being the absolute displacements of the free
bodies, d_j the direction of a joint and f_j the nonlinear laws in it. All of it comes from the same balances and
expressions as the regressors.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import prod
from typing import Any

import numpy as np
import sympy as sp
from sympy.polys.rings import PolyElement

from symid.arrays import FloatArray
from symid.axis import Axis, derivative_order
from symid.codegen.lowering import code
from symid.errors import SettingError
from symid.simulation.scalar import Scalar
from symid.symbolic.equations import by_power
from symid.symbolic.lagrange import Kinematics, inverse_dynamics
from symid.symbolic.operators import OperatorModel, operator_model

LawFunction = Callable[[float, float], float]

JUST_MOVING = 1e-300
"""A speed with a sign and nothing else: laws are evaluated at it to know their limits at rest."""


@dataclass(frozen=True, eq=False)
class JointLaw:
    """All nonlinear laws that act along one direction.

    Parameters
    ----------
    direction : array of shape (n_bodies,)
        The joint's displacement is its product with the bodies' displacements.
    terms : tuple of (float, callable)
        Parameter and expression of each law, the latter of displacement and velocity of the joint.
    """

    direction: FloatArray
    terms: tuple[tuple[float, LawFunction], ...]

    def force(self, q: float, v: float) -> float:
        """Force that opposes the motion."""
        return sum(parameter * function(q, v) for parameter, function in self.terms)

    def limits(self, q: float) -> tuple[float, float]:
        """Lowest and highest force at rest, from either side; they differ where the law can hold the joint."""
        return self.force(q, -JUST_MOVING), self.force(q, JUST_MOVING)

    @property
    def can_hold(self) -> bool:
        """Whether the law jumps at rest, so that the joint can stick."""
        low, high = self.limits(0.0)
        return high > low


@dataclass(frozen=True, eq=False)
class Plant:
    """Matrices of an axis; see the module for the equation.

    Parameters
    ----------
    bodies : tuple of str
        Free bodies, in the order of the displacements.
    mass, damping, stiffness : array of shape (n, n)
        M, C and K.
    drive, constant : array of shape (n,)
        B and c.
    laws : tuple of JointLaw
        Nonlinear laws by joint.
    sensors : mapping of str to (array, int)
        Row over the bodies and order of derivative of each signal.
    """

    bodies: tuple[str, ...]
    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    drive: FloatArray
    constant: FloatArray
    laws: tuple[JointLaw, ...]
    sensors: Mapping[str, tuple[FloatArray, int]]


def plant_of(axis: Axis, parameters: Mapping[str, float]) -> Plant:
    """Forward dynamics of an axis with parameter values.

    Parameters
    ----------
    axis : Axis
        The declared axis.
    parameters : mapping of str to float
        Value of every physical parameter, SI.

    Raises
    ------
    SettingError
        If a parameter is missing, or the mass matrix is not positive.

    Examples
    --------
    >>> from symid.axis import load_axis
    >>> plant = plant_of(load_axis("rigid_1m"), {"M": 2.0, "Fv": 3.0, "Fs": 4.0})
    >>> plant.mass.tolist(), plant.damping.tolist(), plant.laws[0].limits(0.0)
    ([[2.0]], [[3.0]], (-4.0, 4.0))
    """
    missing = [name for name in axis.physical_parameters if name not in parameters]
    if missing:
        raise SettingError(
            f"parameters of axis {axis.name!r} lack {', '.join(missing)}: give a value for each"
        )
    model = inverse_dynamics(axis)
    operators = operator_model(model)
    values = _Values(operators, parameters)
    bodies = tuple(operators.motion)
    powers = [[by_power(operators.motion[b].get(x)) for x in bodies] for b in bodies]
    stiffness, damping, mass = (
        np.array([[values.of(p.get(order)) for p in row] for row in powers]) for order in range(3)
    )
    if np.any(np.linalg.eigvalsh(mass) <= 0):
        raise SettingError(
            f"the masses of axis {axis.name!r} are {np.diag(mass).tolist()}: they must be positive"
        )
    ones = [str(w.symbol) for w in model.inputs if not w.expression.free_symbols]
    constant = [-sum(values.of(operators.inputs[b].get(one)) for one in ones) for b in bodies]
    return Plant(
        bodies=bodies,
        mass=mass,
        damping=damping,
        stiffness=stiffness,
        drive=np.array([-values.of(operators.force[b]) for b in bodies]),
        constant=np.array(constant, dtype=float),
        laws=_laws(operators, values, bodies),
        sensors=_sensors(operators, values, bodies),
    )


class _Values:
    """Numbers for the polynomials and field elements of an operator model."""

    def __init__(self, operators: OperatorModel, parameters: Mapping[str, float]) -> None:
        self.field = operators.ring.domain
        self.constants = {sp.Symbol(name): value for name, value in operators.source.constants.items()}
        self.values = [1.0, *(float(parameters[str(symbol)]) for symbol in operators.ring.symbols[1:])]

    def number(self, element: Any) -> float:
        """Number of an element of the coefficient field."""
        return float(self.field.to_sympy(self.field.convert(element)).xreplace(self.constants))

    def of(self, polynomial: PolyElement | None) -> float:
        """Number of a polynomial without s."""
        terms = polynomial.terms() if polynomial else ()
        return float(
            sum(self.number(c) * prod(x**p for x, p in zip(self.values, m, strict=True)) for m, c in terms)
        )

    def row(self, functional: Mapping[str, Any], bodies: tuple[str, ...]) -> FloatArray:
        """A function of displacements as a row."""
        return np.array([self.number(functional[b]) if b in functional else 0.0 for b in bodies])


def _laws(operators: OperatorModel, values: _Values, bodies: tuple[str, ...]) -> tuple[JointLaw, ...]:
    kinematics = Kinematics(operators.source.axis)
    joints: dict[tuple[float, ...], list[tuple[float, LawFunction]]] = {}
    for entry in operators.source.inputs:
        if not entry.expression.free_symbols:
            continue
        functional = operators.functional(kinematics.displacement(entry.joint))
        body = next(iter(functional))
        parameter = values.of(operators.inputs[body][str(entry.symbol)]) / values.number(functional[body])
        direction = tuple(float(x) for x in values.row(functional, bodies))
        joints.setdefault(direction, []).append((parameter, law_function(entry.expression)))
    return tuple(JointLaw(np.array(direction), tuple(terms)) for direction, terms in joints.items())


def law_function(expression: sp.Expr) -> LawFunction:
    """Law expression in q and v as a function of two numbers.

    Examples
    --------
    >>> law_function(sp.sympify("v*q"))(2.0, 3.0)
    6.0
    """
    function = eval(f"lambda q, v: float({code(expression)})", {"np": Scalar()})
    return function  # type: ignore[no-any-return]  # eval is untyped


def _sensors(
    operators: OperatorModel, values: _Values, bodies: tuple[str, ...]
) -> dict[str, tuple[FloatArray, int]]:
    axis = operators.source.axis
    kinematics = Kinematics(axis)
    return {
        sensor.signal: (
            values.row(operators.functional(kinematics.reading(sensor)), bodies),
            derivative_order(sensor),
        )
        for sensor in axis.sensors
    }
