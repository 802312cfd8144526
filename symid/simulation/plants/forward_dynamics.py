"""The forward dynamics of an axis as functions of parameter values: from its declaration to a `Plant`."""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from types import MappingProxyType
from typing import Any, Literal

import numpy as np

from symid.arrays import BoolArray, FloatArray, read_only
from symid.axis import Axis, of_any_axis
from symid.errors import SettingError
from symid.last_values import LastValues
from symid.simulation.plants.added_laws import stored_with_laws
from symid.simulation.plants.dynamics_terms import (
    JointTerms,
    LawTerm,
    Polynomial,
    PolynomialArrays,
    SensorTerms,
)
from symid.simulation.plants.massless_bodies import without_massless_bodies
from symid.simulation.plants.plant import JointLaw, Plant, ScaledLaw, SensorRow

_MATRICES = ("stiffness", "damping", "mass")
_DERIVED = 32
"""Number of declarations whose forward dynamics are cached."""


@of_any_axis
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


def feedthrough_of(axis: Axis, parameters: Mapping[str, float]) -> Mapping[str, FloatArray]:
    """Acceleration that each accelerometer reads at once per unit of each drive's force."""
    return plant_of(axis, parameters).feedthrough


def forward_dynamics(axis: Axis) -> ForwardDynamics:
    """Forward dynamics of an axis for any parameter values: derived once, evaluated often.

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
    """The equation of motion of an axis with polynomials of its physical parameters as coefficients."""

    axis: Axis
    """The declared axis."""
    parameters: tuple[str, ...]
    """Unknown physical parameters, in order."""
    generators: tuple[str, ...]
    """Unknown and known parameters, in the order of the exponents of the polynomials."""
    bodies: tuple[str, ...]
    """Free bodies that have a mass."""
    motion: tuple[tuple[tuple[Polynomial, ...], ...], ...]
    """Stiffness, damping and mass."""
    drives: tuple[tuple[Polynomial, ...], ...]
    """Factor of each drive's force in the equation of each body."""
    constant: tuple[Polynomial, ...]
    """Constant force on each body."""
    laws: tuple[JointTerms, ...]
    """Nonlinear laws of each joint."""
    sensors: Mapping[str, SensorTerms]
    """Reading of each sensor."""
    _memory: LastValues = field(default_factory=LastValues, init=False, repr=False)

    def parameters_of(self, matrix: Literal["stiffness", "damping", "mass"]) -> set[str]:
        """Masses, springs or dampers in a matrix: its physical parameters that cannot be negative."""
        entries = (entry for row in self.motion[_MATRICES.index(matrix)] for entry in row)
        names = {name for entry in entries for name in self.names(entry)}
        return names.difference(self.axis.signed_parameters)

    def names(self, polynomial: Polynomial) -> set[str]:
        """Unknown physical parameters in a polynomial."""
        found = {
            self.generators[i] for _, powers in polynomial.terms for i, power in enumerate(powers) if power
        }
        return found.difference(self.axis.known_parameters)

    @cached_property
    def _free_bodies(self) -> tuple[tuple[str, ...], BoolArray]:
        """Names of the free bodies, and whether they have a mass."""
        names = tuple(body.name for body in self.axis.free_bodies)
        return names, np.array([name in self.bodies for name in names])

    def at(self, parameters: Mapping[str, float]) -> Plant:
        """The plant at parameter values, as `plant_of`; that of the last values is kept."""

        def made() -> Plant:
            plant, heavy = self.with_nodes(parameters), self._free_bodies[1]
            return plant if heavy.all() else without_massless_bodies(plant, heavy)

        return self._memory.of("plant", tuple(parameters.get(name) for name in self.parameters), made)

    def with_nodes(self, parameters: Mapping[str, float]) -> Plant:
        """The plant at parameter values, in which bodies without mass remain bodies."""
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
            given = ", ".join(
                f"{name} {parameters[name]:g}"
                for name in self.parameters
                if name in self.parameters_of("mass")
            )
            raise SettingError(
                f"the masses of axis {self.axis.name!r} are not positive with {given}: no machine has such values; "
                "give others, or none where they can be identified"
            )
        return plant

    def derivative(self, parameters: Mapping[str, float], name: str) -> Plant:
        """Derivatives of all terms of `with_nodes` by a parameter, as a plant; sensors are not differentiated."""
        values = self._values(parameters)
        return self._plant(self._arrays.derivative(values, self.generators.index(name)), values)

    def reading(self, parameters: Mapping[str, float], signal: str) -> SensorRow:
        """The reading of a sensor at parameter values."""
        return self.sensors[signal].at(self._values(parameters))

    def _values(self, parameters: Mapping[str, float]) -> list[float]:
        every = self.axis.with_known_values(parameters)
        return [float(every[name]) for name in self.generators]

    @cached_property
    def _arrays(self) -> PolynomialArrays:
        """All polynomials: stiffness, damping, mass, drives and constant, then the laws of each joint."""
        n_bodies, n_drives = len(self.constant), len(self.axis.drives)
        shapes: list[tuple[int, ...]] = [(n_bodies, n_bodies)] * 3 + [(n_bodies, n_drives), (n_bodies,)]
        matrices = [p for matrix in (*self.motion, self.drives) for row in matrix for p in row]
        levels = [term.parameter for joint in self.laws for term in joint.terms]
        return PolynomialArrays(
            shapes + [(len(joint.terms),) for joint in self.laws], [*matrices, *self.constant, *levels]
        )

    def _plant(self, arrays: Sequence[FloatArray], values: Sequence[float]) -> Plant:
        """The plant with the values `arrays` of `_arrays`; `values` are those of the generators."""
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
                    tuple(ScaledLaw(x, t.forces, t.code) for x, t in zip(level.tolist(), terms, strict=True)),
                )
                for (direction, terms), level in zip(self.laws, levels, strict=True)
            ),
            sensors={name: sensor.at(values) for name, sensor in self.sensors.items()},
        )


@dataclass(frozen=True)
class _Declaration:
    """Key of a cache: axes of one signature are equal, as they differ only in imperfections of their signals."""

    signature: str
    axis: Axis = field(compare=False)


@lru_cache(maxsize=_DERIVED)
def _derived(declaration: _Declaration) -> ForwardDynamics:
    axis = declaration.axis
    record = stored_with_laws(axis)
    if record is None:
        from symid.codegen.generation import dynamics_record  # sympy takes half a second to load

        record = dynamics_record(axis)

    read = {tuple(sensor["row"]) for sensor in record["sensors"].values() if sensor.get("law")}
    joints: dict[tuple[float, ...], list[LawTerm]] = {}
    for law in record["laws"]:
        joint, ratio = _joint_of(tuple(law["direction"]), joints, read)
        term = LawTerm.of(Polynomial.of(law["parameter"]), law["code"])
        joints.setdefault(joint, []).append(term if ratio == 1.0 else term.geared(ratio))
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
                    drives=tuple(map(Polynomial.of, sensor.get("drives", ()))),
                    scale=tuple(map(Polynomial.of, sensor.get("scale", ()))),
                    law=list(joints).index(tuple(sensor["row"])) if sensor.get("law") else None,
                )
                for name, sensor in record["sensors"].items()
            }
        ),
    )


def _joint_of(
    direction: tuple[float, ...], joints: Iterable[tuple[float, ...]], read: Container[tuple[float, ...]]
) -> tuple[tuple[float, ...], float]:
    """The joint that moves with a direction, and by how much of it; the direction itself if there is none yet.

    Two racks on one pinion slide and stick together: their laws act in one joint. A force sensor reads its own.
    """
    own = np.array(direction)
    for joint in () if direction in read else joints:
        other = np.array(joint)
        ratio = float(own @ other / (other @ other))
        if joint not in read and np.allclose(own, ratio * other, rtol=1e-12, atol=0.0):
            return joint, ratio
    return direction, 1.0


def _polynomials(matrix: Sequence[Sequence[Any]]) -> tuple[tuple[Polynomial, ...], ...]:
    return tuple(tuple(map(Polynomial.of, row)) for row in matrix)
