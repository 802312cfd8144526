"""The forward dynamics of an axis as functions of parameter values: from its declaration to a `Plant`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from itertools import compress
from types import MappingProxyType
from typing import Any, Literal, NamedTuple

import numpy as np

from symid.arrays import BoolArray, FloatArray, read_only
from symid.axis import Axis
from symid.errors import SettingError
from symid.simulation.added_laws import stored_with_laws
from symid.simulation.law_functions import array_function, law_function
from symid.simulation.parameter_polynomials import Polynomial, PolynomialArrays
from symid.simulation.plant import JointLaw, LawFunction, Plant, ScaledLaw, SensorRow, condensed
from symid.simulation.postfix import program

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
    sensors : mapping of str to SensorTerms
        What each sensor reads.
    """

    axis: Axis
    parameters: tuple[str, ...]
    generators: tuple[str, ...]
    bodies: tuple[str, ...]
    motion: tuple[tuple[tuple[Polynomial, ...], ...], ...]
    drives: tuple[tuple[Polynomial, ...], ...]
    constant: tuple[Polynomial, ...]
    laws: tuple[JointTerms, ...]
    sensors: Mapping[str, SensorTerms]

    def parameters_of(self, matrix: Literal["stiffness", "damping", "mass"]) -> set[str]:
        """Physical parameters in a matrix, except for those that may be negative: masses, springs, dampers."""
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

    @cached_property
    def _free_bodies(self) -> tuple[tuple[str, ...], BoolArray]:
        """Names of the free bodies, and whether they have a mass."""
        names = tuple(body.name for body in self.axis.free_bodies)
        return names, np.array([name in self.bodies for name in names])

    def at(self, parameters: Mapping[str, float]) -> Plant:
        """The plant at parameter values, as `plant_of`."""
        plant = self.with_nodes(parameters)
        heavy = self._free_bodies[1]
        return plant if heavy.all() else _without_nodes(plant, heavy)

    def with_nodes(self, parameters: Mapping[str, float]) -> Plant:
        """The same with bodies that have no mass as bodies."""
        missing = [name for name in self.parameters if name not in parameters]
        if missing:
            raise SettingError(
                f"parameters of axis {self.axis.name!r} lack {', '.join(missing)}: give a value for each"
            )
        values = self._values(parameters)
        plant = self._plant(self._arrays.at(values), values)
        _, heavy = self._free_bodies
        moved = plant.mass if heavy.all() else plant.mass[np.ix_(heavy, heavy)]
        if not np.all(np.linalg.eigvalsh(moved) > 0):
            raise SettingError(
                f"the masses of axis {self.axis.name!r} are {np.diag(plant.mass).tolist()}: they must be positive"
            )
        return plant

    def derivative(self, parameters: Mapping[str, float], name: str) -> Plant:
        """Derivatives of all terms of `with_nodes` by a parameter, in the form of a plant; sensors as they are."""
        values = self._values(parameters)
        return self._plant(self._arrays.derivative(values, self.generators.index(name)), values)

    def reading(self, parameters: Mapping[str, float], signal: str) -> SensorRow:
        """What a sensor reads at parameter values."""
        return self.sensors[signal].at(self._values(parameters))

    def _values(self, parameters: Mapping[str, float]) -> list[float]:
        """Values of the generators."""
        every = {**parameters, **self._known}
        return [float(every[name]) for name in self.generators]

    @cached_property
    def _arrays(self) -> PolynomialArrays:
        """Polynomials of stiffness, damping, mass, drives and constant, and of the laws joint by joint."""
        n_bodies, n_drives = len(self.constant), len(self.axis.drives)
        shapes: list[tuple[int, ...]] = [(n_bodies, n_bodies)] * 3 + [(n_bodies, n_drives), (n_bodies,)]
        matrices = [p for matrix in (*self.motion, self.drives) for row in matrix for p in row]
        levels = [term.parameter for joint in self.laws for term in joint.terms]
        return PolynomialArrays(
            shapes + [(len(joint.terms),) for joint in self.laws], [*matrices, *self.constant, *levels]
        )

    def _plant(self, arrays: Sequence[FloatArray], values: Sequence[float]) -> Plant:
        """The plant that has these values of `_arrays`, and sensors at parameter values."""
        stiffness, damping, mass, drives, constant, *levels = arrays
        return Plant(
            bodies=self._free_bodies[0],
            mass=mass,
            damping=damping,
            stiffness=stiffness,
            drives=drives,
            constant=constant,
            laws=tuple(
                JointLaw(
                    direction,
                    tuple(ScaledLaw(x, t.force, t.code) for x, t in zip(level.tolist(), terms, strict=True)),
                )
                for (direction, terms), level in zip(self.laws, levels, strict=True)
            ),
            sensors={name: sensor.at(values) for name, sensor in self.sensors.items()},
        )


def _without_nodes(plant: Plant, heavy: BoolArray) -> Plant:
    """The plant without massless bodies, which are where the springs beside them balance: x = T x_heavy.

    Refused where anything else acts on such a body: springs alone must determine its displacement.
    """
    nodes = ~heavy
    springs = plant.stiffness[np.ix_(nodes, nodes)]
    other = [plant.damping[nodes], plant.drives[nodes], plant.constant[nodes]]
    named = f"bodies {', '.join(compress(plant.bodies, nodes))} without mass"
    if any(forces.any() for forces in other) or any(law.direction[nodes].any() for law in plant.laws):
        raise SettingError(f"{named} carry more than springs: give each a mass to simulate")
    if np.linalg.matrix_rank(springs) < len(springs):
        raise SettingError(f"{named} are held by no spring: give each a mass, or a spring")
    T = np.zeros((heavy.size, int(heavy.sum())))
    T[heavy] = np.eye(T.shape[1])
    T[nodes] = -np.linalg.solve(springs, plant.stiffness[np.ix_(nodes, heavy)])
    reduced: Plant = condensed(plant, T, tuple(compress(plant.bodies, heavy)))
    return reduced


@dataclass(frozen=True, eq=False)
class LawTerm:
    """A nonlinear law of a joint, parameter times an expression: its NumPy code, function of numbers and of arrays."""

    parameter: Polynomial
    code: str
    force: LawFunction
    forces: Callable[[FloatArray, FloatArray], FloatArray]

    @classmethod
    def of(cls, parameter: Polynomial, code: str) -> LawTerm:
        """The law of some code; SymidError if that is not of the law language."""
        program(code, ("q", "v"))  # nothing else is run
        return cls(parameter, code, law_function(code), array_function(code))


class SensorTerms(NamedTuple):
    """What a sensor reads: `row` and `order` as of `SensorRow` where it has no parameters, which else are polynomials.

    The reading is (motion + drives - offset) / gain; `scale` holds gain and offset.
    """

    row: FloatArray
    order: int | None
    n_drives: int
    motion: tuple[tuple[Polynomial, ...], ...] = ()
    drives: tuple[Polynomial, ...] = ()
    scale: tuple[Polynomial, ...] = ()

    def at(self, values: Sequence[float]) -> SensorRow:
        """What it reads at parameter values; SettingError if its gain is not positive."""
        if not self.motion:
            motion = np.zeros((3, self.row.size))
            motion[self.order] = self.row
            return SensorRow(self.row, self.order, motion, np.zeros(self.n_drives))
        gain, offset = (polynomial.at(values) for polynomial in self.scale)
        if not gain > 0:
            raise SettingError(f"the gain of a sensor is {gain:g}: it must be positive")
        motion = np.array([[p.at(values) for p in row] for row in self.motion]) / gain
        drives = np.array([p.at(values) for p in self.drives]) / gain
        row = self.row if self.order is None else motion[self.order]
        return SensorRow(row, self.order, motion, drives, -offset / gain)


class JointTerms(NamedTuple):
    """Nonlinear laws of one joint, whose displacement is `direction` times the bodies' displacements."""

    direction: FloatArray
    terms: tuple[LawTerm, ...]


@dataclass(frozen=True)
class _Declaration:
    """An axis that equals all others of its signature: those differ in the imperfections of their signals only."""

    signature: str
    axis: Axis = field(compare=False)


@lru_cache(maxsize=_DERIVED)
def _derived(declaration: _Declaration) -> ForwardDynamics:
    axis = declaration.axis
    record = stored_with_laws(axis)
    if record is None:
        from symid.codegen.dynamics_record import dynamics_record  # sympy takes half a second to load

        record = dynamics_record(axis)

    joints: dict[tuple[float, ...], list[LawTerm]] = {}
    for law in record["laws"]:
        joints.setdefault(tuple(law["direction"]), []).append(
            LawTerm.of(_polynomial(law["parameter"]), law["code"])
        )
    return ForwardDynamics(
        axis=axis,
        parameters=tuple(axis.physical_parameters),
        generators=tuple(record["generators"]),
        bodies=tuple(record["bodies"]),
        motion=tuple(_polynomials(record[matrix]) for matrix in _MATRICES),
        drives=_polynomials(record["drives"]),
        constant=tuple(entry for (entry,) in _polynomials(record["constant"])),
        laws=tuple(JointTerms(read_only(np.array(d)), tuple(found)) for d, found in joints.items()),
        sensors=MappingProxyType(
            {
                name: SensorTerms(
                    read_only(np.array(sensor["row"])),
                    sensor["order"],
                    len(axis.drives),
                    motion=_polynomials(sensor.get("motion", ())),
                    drives=tuple(map(_polynomial, sensor.get("drives", ()))),
                    scale=tuple(map(_polynomial, sensor.get("scale", ()))),
                )
                for name, sensor in record["sensors"].items()
            }
        ),
    )


def _polynomials(matrix: Sequence[Sequence[Any]]) -> tuple[tuple[Polynomial, ...], ...]:
    return tuple(tuple(map(_polynomial, row)) for row in matrix)


def _polynomial(terms: Sequence[tuple[float, Sequence[int]]]) -> Polynomial:
    return Polynomial(tuple((coefficient, tuple(powers)) for coefficient, powers in terms))
