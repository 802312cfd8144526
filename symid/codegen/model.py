"""`GeneratedModel`: the model of an axis for the numeric packages, read from a generated module."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np

from symid.arrays import FloatArray
from symid.axis import ActuatorDelay, Axis
from symid.shown import Shown
from symid.signal_names import split_derivative

ArrayFunction = Callable[..., FloatArray]


_RIGID = 2
"""Order of the derivatives of a rigid axis."""


@dataclass(frozen=True, eq=False, repr=False)
class GeneratedModel(Shown):
    """A generated module, ready to be evaluated."""

    axis: str
    """Name of the axis."""
    measured: tuple[str, ...]
    """Signals of the sensors used."""
    signature: str
    """Signature of the declaration from which it was generated."""
    signals: tuple[str, ...]
    """Flat names of the arguments of the functions, in order."""
    output_names: tuple[str, ...]
    """Left-hand side of each equation."""
    output_units: tuple[str, ...]
    """Unit of each equation."""
    minimal_units: Mapping[str, str]
    """Names and units of the minimal parameters, in order."""
    physical_units: Mapping[str, str]
    """Names and units of the physical parameters, in order."""
    signed: tuple[str, ...]
    """Physical parameters that may be negative."""
    per_log: tuple[str, ...]
    """Minimal parameters that differ from log to log."""
    known: Mapping[str, tuple[float, str]]
    """Physical parameters that are known: value and unit."""
    held: bool
    """Whether the axis declares its force as held (zero-order hold)."""
    assumptions: tuple[str, ...]
    """Assumptions of the derivation."""
    sliding: tuple[tuple[int, ...], ...]
    """For each equation, the rows of `sliding_velocities` whose sign enters it."""
    law_columns: tuple[tuple[int, int], ...]
    """Equation and parameter index of the columns with values of nonlinear laws."""
    coulomb_at_drive: tuple[tuple[int, int], ...]
    """Coulomb friction that acts like a drive, in equations that omit its derivatives: row of its velocity in
    `sliding_velocities`, and index of its minimal parameter."""
    coulomb_drives: tuple[str, ...]
    """Signal of the drive for each of these."""
    redundant: tuple[tuple[str, tuple[tuple[str, int, float], ...]], ...]
    """Redundant sensors: signal, and the terms (signal, derivatives, factor) whose sum it should equal."""
    known_laws: tuple[int, ...]
    """Equations whose output contains nonlinear laws with known parameters."""
    branches: int
    """Number of solutions of the closed-form inverse map; 0 without one."""
    regressor: ArrayFunction
    """As in the generated module."""
    output: ArrayFunction
    """As in the generated module."""
    sliding_velocities: ArrayFunction
    """As in the generated module."""
    minimal_parameters: ArrayFunction
    """As in the generated module."""
    physical_parameters: ArrayFunction | None
    """The inverse map, if it has a closed form."""
    delays: Mapping[str, float] = field(default_factory=dict)
    """Declared delays in seconds: of late sensors positive, of forces that act late negative. They are taken from
    the declaration, not from the module."""
    passed_over: tuple[str, ...] = ()
    """Kinds of declared imperfections that the regressor does not model, also from the declaration."""

    @classmethod
    def from_namespace(cls, namespace: Mapping[str, Any]) -> GeneratedModel:
        """Record of a module's namespace, in which functions have the fields' names and values these in capitals."""
        drives = (split_derivative(name)[0] for name in namespace["SIGNALS"])
        force = next((name for name in drives if name not in namespace["MEASURED"]), "")
        found = {
            "COULOMB_AT_DRIVE": (),
            "COULOMB_DRIVES": (force,) * len(namespace.get("COULOMB_AT_DRIVE", ())),
            "KNOWN": {},
            "KNOWN_LAWS": (),
            "REDUNDANT": (),
            "physical_parameters": None,
            **namespace,
            "OUTPUT_NAMES": namespace["OUTPUT"],
        }
        names = (item.name for item in fields(cls) if item.name not in ("delays", "passed_over"))
        values: dict[str, Any] = {name: found[name if name in found else name.upper()] for name in names}
        for name, value in values.items():
            values[name] = MappingProxyType(value) if isinstance(value, dict) else value
        return cls(**values)

    @property
    def headline(self) -> str:
        """Axis, sensors and parameters."""
        parameters = ", ".join(self.physical_units)
        return f"{self.axis} from {', '.join(self.measured)}: parameters {parameters}"

    @cached_property
    def highest_derivatives(self) -> Mapping[str, int]:
        """Highest derivative needed of each measured signal and of the force."""
        highest: dict[str, int] = {}
        for name in self.signals:
            signal, order = split_derivative(name)
            highest[signal] = max(order, highest.get(signal, 0))
        return MappingProxyType(highest)

    @property
    def forces(self) -> tuple[str, ...]:
        """Signals of the drives, in the order of their declaration."""
        return tuple(name for name in self.highest_derivatives if name not in self.measured)

    @property
    def force(self) -> str:
        """Signal of the first drive."""
        return self.forces[0]

    @property
    def most_differentiated(self) -> str:
        """The measured signal with the highest required derivative."""
        highest = self.highest_derivatives
        return max((name for name in self.measured if name in highest), key=highest.__getitem__)

    @property
    def is_flexible(self) -> bool:
        """Whether it holds a mode: in derivatives beyond the second, or in more outputs than drives."""
        return len(self.output_names) > len(self.forces) or max(self.highest_derivatives.values()) > _RIGID

    @cached_property
    def laws_of_velocity(self) -> bool:
        """Whether laws and sliding velocities depend on no derivative beyond the first."""
        beyond = np.array([split_derivative(name)[1] > 1 for name in self.signals])
        at = [np.where(beyond, other, 0.7)[:, None] for other in (0.0, 1.0)]
        laws = [[self.regressor(*x)[:, 0][place] for place in self.law_columns] for x in at]
        velocities = [self.sliding_velocities(*x).tolist() for x in at]
        return laws[0] == laws[1] and velocities[0] == velocities[1]

    def sample(self, signals: Mapping[str, FloatArray]) -> tuple[FloatArray, FloatArray]:
        """Observation matrix W and output y of sampled signals, which are given by flat name."""
        arguments = [np.asarray(signals[name], dtype=float) for name in self.signals]
        return self.regressor(*arguments), self.output(*arguments)


def declared_delays(axis: Axis, measured: Sequence[str] | None = None) -> dict[str, float]:
    """Declared delays in seconds: of late sensors positive, of forces that act late negative.

    Parameters
    ----------
    axis : Axis
        The declared axis.
    measured : sequence of str, optional
        Sensors whose delays are wanted; all by default.

    Examples
    --------
    >>> from symid.axis import load_axis
    >>> declared_delays(load_axis("rigid_1m").with_effect(ActuatorDelay(3e-3)))
    {'F': -0.003}
    """
    sensors = axis.sensors if measured is None else axis.measured(measured)
    late = {sensor.signal: sensor.delay for sensor in sensors if sensor.delay}
    acting = {
        drive.signal: sum(e.seconds for e in axis.imperfections_of(drive) if isinstance(e, ActuatorDelay))
        for drive in axis.drives
    }
    return late | {signal: -seconds for signal, seconds in acting.items() if seconds}


def passed_over(axis: Axis) -> tuple[str, ...]:
    """Kinds of declared imperfections that neither a regressor nor a delay of a signal models.

    Examples
    --------
    >>> from symid.axis import ForceLimit, load_axis
    >>> passed_over(load_axis("rigid_1m").with_effect(ActuatorDelay(3e-3), ForceLimit(9.0)))
    ('ForceLimit',)
    """
    return tuple(
        dict.fromkeys(
            type(item).__name__ for item in axis.imperfections if not isinstance(item, ActuatorDelay)
        )
    )
