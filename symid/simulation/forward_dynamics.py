"""The forward dynamics of an axis: from its declaration to the matrices and laws of a `Plant`.

It uses the same balances and expressions as the regressors.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from math import prod
from types import MappingProxyType
from typing import Any, Literal, NamedTuple

import numpy as np
import sympy as sp
from sympy.polys.rings import PolyElement

from symid.arrays import BoolArray, FloatArray, read_only
from symid.axis import Axis
from symid.errors import SettingError
from symid.simulation.law_functions import array_function, law_function
from symid.simulation.plant import JointLaw, LawFunction, Plant, ScaledLaw, SensorRow
from symid.symbolic.equations import by_power
from symid.symbolic.lagrange import Kinematics, inverse_dynamics
from symid.symbolic.operators import OperatorModel, operator_model

_MATRICES = ("stiffness", "damping", "mass")
_DERIVED = 32
"""Number of declarations whose forward dynamics are cached."""


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
    return forward_dynamics(axis).at(parameters)


def forward_dynamics(axis: Axis) -> ForwardDynamics:
    """Forward dynamics of an axis for any parameter values: derived once for a declaration, evaluated often.

    Examples
    --------
    >>> from symid.axis import load_axis
    >>> dynamics = forward_dynamics(load_axis("rigid_1m"))
    >>> [dynamics.at({"M": m, "Fv": 3.0, "Fs": 4.0}).mass.item() for m in (1.0, 2.0)]
    [1.0, 2.0]
    """
    return replace(_derived(_Declaration(axis.signature, axis)), axis=axis)


@dataclass(frozen=True, eq=False)
class ForwardDynamics:
    """The matrices of an axis as functions of its physical parameters, for any number of parameter values.

    Parameters
    ----------
    axis : Axis
        The declared axis.
    parameters : tuple of str
        Unknown physical parameters, in order.
    generators : tuple of str
        Unknown and known ones, in the order of the exponents of polynomials.
    bodies : tuple of str
        Free bodies that have a mass.
    motion : tuple of matrices of Polynomial
        Stiffness, damping and mass.
    drives : tuple of tuple of Polynomial
        Effect on each body of each drive's force.
    constant : tuple of Polynomial
        Constant force on each body.
    laws : tuple of JointTerms
        Nonlinear laws of each joint.
    sensors : mapping of str to SensorRow
        As in `Plant`.
    """

    axis: Axis
    parameters: tuple[str, ...]
    generators: tuple[str, ...]
    bodies: tuple[str, ...]
    motion: tuple[tuple[tuple[Polynomial, ...], ...], ...]
    drives: tuple[tuple[Polynomial, ...], ...]
    constant: tuple[Polynomial, ...]
    laws: tuple[JointTerms, ...]
    sensors: Mapping[str, SensorRow]

    @property
    def drive(self) -> tuple[Polynomial, ...]:
        """Effect on each body of the drive's force, of an axis with one drive."""
        return tuple(effect for (effect,) in self.drives)

    def parameters_of(self, matrix: Literal["stiffness", "damping", "mass"]) -> set[str]:
        """Physical parameters in a matrix, but for those that may be negative: masses, springs, dampers."""
        entries = (entry for row in self.motion[_MATRICES.index(matrix)] for entry in row)
        names = {name for entry in entries for name in self.names(entry)}
        return names.difference(self.axis.signed_parameters)

    def names(self, polynomial: Polynomial) -> set[str]:
        """Unknown physical parameters in a polynomial."""
        found = {
            self.generators[i] for _, powers in polynomial.terms for i, power in enumerate(powers) if power
        }
        return found.difference(self._known)

    @cached_property
    def _known(self) -> dict[str, float]:
        """Values that the axis knows, once for all evaluations."""
        return self.axis.known_parameters

    def at(self, parameters: Mapping[str, float]) -> Plant:
        """The plant at parameter values, as `plant_of`."""
        plant = self.with_nodes(parameters)
        heavy = np.array([name in self.bodies for name in plant.bodies])
        return plant if heavy.all() else _without_nodes(plant, heavy)

    def with_nodes(self, parameters: Mapping[str, float]) -> Plant:
        """The same with bodies that have no mass as bodies."""
        missing = [name for name in self.parameters if name not in parameters]
        if missing:
            raise SettingError(
                f"parameters of axis {self.axis.name!r} lack {', '.join(missing)}: give a value for each"
            )
        every = {**parameters, **self._known}
        values = np.array([float(every[name]) for name in self.generators])
        stiffness, damping, mass = (np.array([[p.at(values) for p in row] for row in m]) for m in self.motion)
        names = tuple(body.name for body in self.axis.free_bodies)
        heavy = [name in self.bodies for name in names]
        if not np.all(np.linalg.eigvalsh(mass[np.ix_(heavy, heavy)]) > 0):
            raise SettingError(
                f"the masses of axis {self.axis.name!r} are {np.diag(mass).tolist()}: they must be positive"
            )
        return Plant(
            bodies=names,
            mass=mass,
            damping=damping,
            stiffness=stiffness,
            drives=np.array([[p.at(values) for p in row] for row in self.drives]),
            constant=np.array([p.at(values) for p in self.constant]),
            laws=tuple(
                JointLaw(
                    direction, tuple(ScaledLaw(t.parameter.at(values), t.force, t.source) for t in terms)
                )
                for direction, terms in self.laws
            ),
            sensors=self.sensors,
        )


def _without_nodes(plant: Plant, heavy: BoolArray) -> Plant:
    """The plant without massless bodies, which are where the springs beside them balance: x = T x_heavy.

    Refused where anything else acts on such a body: springs alone must determine its displacement.
    """
    nodes = ~heavy
    springs = plant.stiffness[np.ix_(nodes, nodes)]
    other = [plant.damping[nodes], plant.drives[nodes], plant.constant[nodes]]
    if any(forces.any() for forces in other) or any(law.direction[nodes].any() for law in plant.laws):
        raise SettingError(
            f"{_named(plant, nodes)} without mass carry more than springs: give each a mass to simulate"
        )
    if np.linalg.matrix_rank(springs) < len(springs):
        raise SettingError(
            f"{_named(plant, nodes)} without mass are held by no spring: give each a mass, or a spring"
        )
    T = np.zeros((heavy.size, int(heavy.sum())))
    T[heavy] = np.eye(T.shape[1])
    T[nodes] = -np.linalg.solve(springs, plant.stiffness[np.ix_(nodes, heavy)])
    return replace(
        plant,
        bodies=tuple(name for name, has_mass in zip(plant.bodies, heavy, strict=True) if has_mass),
        mass=T.T @ plant.mass @ T,
        damping=T.T @ plant.damping @ T,
        stiffness=T.T @ plant.stiffness @ T,
        drives=T.T @ plant.drives,
        constant=T.T @ plant.constant,
        laws=tuple(replace(law, direction=law.direction @ T) for law in plant.laws),
        sensors={name: SensorRow(row @ T, order) for name, (row, order) in plant.sensors.items()},
    )


def _named(plant: Plant, chosen: BoolArray) -> str:
    return f"bodies {', '.join(n for n, one in zip(plant.bodies, chosen, strict=True) if one)}"


@dataclass(frozen=True, eq=False)
class LawTerm:
    """A nonlinear law of a joint, parameter times expression `source`: as a function of two numbers, and of arrays."""

    parameter: Polynomial
    force: LawFunction
    forces: Callable[[FloatArray, FloatArray], FloatArray]
    source: sp.Expr


class JointTerms(NamedTuple):
    """Nonlinear laws of one joint, whose displacement is `direction` times the bodies' displacements."""

    direction: FloatArray
    terms: tuple[LawTerm, ...]


@dataclass(frozen=True, eq=False)
class Polynomial:
    """A polynomial of the physical parameters: coefficient and exponents of each term."""

    terms: tuple[tuple[float, tuple[int, ...]], ...]

    def at(self, values: FloatArray) -> float:
        """Value at parameter values."""
        return float(
            sum(c * prod(x**p for x, p in zip(values, powers, strict=True) if p) for c, powers in self.terms)
        )


@dataclass(frozen=True)
class _Declaration:
    """An axis that equals all others of its signature: those differ in the imperfections of their signals only."""

    signature: str
    axis: Axis = field(compare=False)


@lru_cache(maxsize=_DERIVED)
def _derived(declaration: _Declaration) -> ForwardDynamics:
    axis = declaration.axis
    model = inverse_dynamics(axis)
    operators = operator_model(model)
    numbers = _Numbers(operators)
    bodies = tuple(operators.motion)
    powers = [[by_power(operators.motion[b].get(x)) for x in bodies] for b in bodies]
    ones = [str(w.symbol) for w in model.inputs if not w.expression.free_symbols]
    return ForwardDynamics(
        axis=axis,
        parameters=tuple(axis.physical_parameters),
        generators=tuple(map(str, operators.ring.symbols[1:])),
        bodies=tuple(b for b, row in zip(bodies, powers, strict=True) if any(entry.get(2) for entry in row)),
        motion=tuple(
            tuple(tuple(numbers.polynomial(p.get(order)) for p in row) for row in powers)
            for order in range(3)
        ),
        drives=tuple(
            tuple(numbers.polynomial(operators.force[b].get(d.signal), -1.0) for d in axis.drives)
            for b in bodies
        ),
        constant=tuple(
            Polynomial(
                tuple(t for one in ones for t in numbers.polynomial(operators.inputs[b].get(one), -1.0).terms)
            )
            for b in bodies
        ),
        laws=_laws(operators, numbers, bodies),
        sensors=_sensors(operators, numbers, bodies),
    )


class _Numbers:
    """Numbers for the field elements and polynomials of an operator model."""

    def __init__(self, operators: OperatorModel) -> None:
        self.field = operators.ring.domain
        self.constants = {sp.Symbol(name): value for name, value in operators.source.constants.items()}

    def number(self, element: Any) -> float:
        """Number of an element of the coefficient field."""
        return float(self.field.to_sympy(self.field.convert(element)).xreplace(self.constants))

    def polynomial(self, polynomial: PolyElement | None, factor: float = 1.0) -> Polynomial:
        """A polynomial without s, times a factor."""
        terms = polynomial.terms() if polynomial else ()
        return Polynomial(tuple((factor * self.number(c), tuple(map(int, m[1:]))) for m, c in terms))

    def row(self, functional: Mapping[str, Any], bodies: tuple[str, ...]) -> FloatArray:
        """A function of displacements as a row."""
        return read_only(np.array([self.number(functional[b]) if b in functional else 0.0 for b in bodies]))


def _laws(operators: OperatorModel, numbers: _Numbers, bodies: tuple[str, ...]) -> tuple[JointTerms, ...]:
    kinematics = Kinematics(operators.source.axis)
    joints: dict[tuple[float, ...], list[LawTerm]] = {}
    for entry in operators.source.inputs:
        if not entry.expression.free_symbols:
            continue
        functional = operators.functional(kinematics.displacement(entry.joint))
        body = next(iter(functional))
        # In the balance of a body the law's parameter stands times the share of that body in the joint's displacement.
        share = numbers.number(functional[body])
        parameter = numbers.polynomial(operators.inputs[body][str(entry.symbol)], 1 / share)
        direction = tuple(float(x) for x in numbers.row(functional, bodies))
        formula = entry.expression
        term = LawTerm(parameter, law_function(formula), array_function(formula), formula)
        joints.setdefault(direction, []).append(term)
    return tuple(
        JointTerms(read_only(np.array(direction)), tuple(terms)) for direction, terms in joints.items()
    )


def _sensors(operators: OperatorModel, numbers: _Numbers, bodies: tuple[str, ...]) -> Mapping[str, SensorRow]:
    kinematics, found = Kinematics(operators.source.axis), {}
    for sensor in operators.source.axis.sensors:
        row = numbers.row(operators.functional(kinematics.reading(sensor)), bodies)
        found[sensor.signal] = SensorRow(row, sensor.derivative)
    return MappingProxyType(found)
