"""`Axis`: a machine axis as its elements, its drive and its sensors, checked as a whole."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import combinations
from typing import Any, TypeAlias

from symid.axis.drive_imperfections import DriveImperfection
from symid.axis.elements import Body, Damper, Drive, PendulumWeight, Spring, Weight
from symid.axis.imperfections import Imperfection
from symid.axis.laws import Law
from symid.axis.quantities import end_of, parameter_units, signal_unit, unit_faults
from symid.axis.sensors import Sensor, controlled_of
from symid.axis.signature import hash_of
from symid.axis.validation import declaration_faults
from symid.errors import DeclarationError, SettingError
from symid.shown import Shown
from symid.units import Unit

Element: TypeAlias = Body | Spring | Damper | Weight | PendulumWeight | Law | Imperfection

MOST_OPTIONAL_SENSORS = 3
"""Largest number of optional sensors for which a regressor is generated for every subset."""


@dataclass(frozen=True, repr=False)
class Axis(Shown):
    """A declared machine axis.

    Parameters
    ----------
    name : str
        Name of the axis, that of its generated modules.
    elements : tuple
        Bodies, springs, dampers, weights, laws and imperfections. Physical parameters are listed in the order in which
        they appear.
    drive : Drive or tuple of Drive
        The force or torque that moves the axis, or several: two motors of a gantry, tandem drives.
    sensors : tuple of Sensor
        Signals that can be measured. All but the first are optional; with several drives, all but one of each.
    known : mapping of str to float
        Values in SI units of parameters that are known though they have a name; others are given as numbers where they
        stand.

    Raises
    ------
    DeclarationError
        With every fault of the declaration.

    Examples
    --------
    >>> from symid import Axis, Body, Drive, Position, ViscousFriction
    >>> table = Body("table", mass="M")
    >>> axis = Axis("rigid", (table, ViscousFriction(table, "Fv")), Drive("F", table), (Position("q", table),))
    >>> axis.physical_parameters
    {'M': Unit('kg'), 'Fv': Unit('N*s/m')}

    A parameter that is known is a number; one that several elements share has the same name in each.

    >>> table = Body("table", mass=12.5)
    >>> axis = Axis("weighed", (table, ViscousFriction(table, "Fv")), Drive("F", table), (Position("q", table),))
    >>> axis.physical_parameters, axis.known_parameters
    ({'Fv': Unit('N*s/m')}, {'table_mass': 12.5})
    """

    name: str
    elements: tuple[Element, ...]
    drive: Drive | tuple[Drive, ...]
    sensors: tuple[Sensor, ...]
    known: Mapping[str, float] = field(default_factory=dict, hash=False)

    def __post_init__(self) -> None:
        if isinstance(self.drive, tuple) and len(self.drive) == 1:
            object.__setattr__(self, "drive", self.drive[0])
        faults = declaration_faults(self.name, self.elements, self.drives, self.sensors, self.known)
        faults = faults or tuple(unit_faults((*self.elements, *self.sensors), self.drives))
        if faults:
            raise DeclarationError(str(self.name), faults)
        object.__setattr__(self, "known", dict(self.known))

    @property
    def headline(self) -> str:
        """Bodies, drive, sensors and parameters by name."""
        bodies = ", ".join(body.name for body in self.bodies)
        sensors = ", ".join(sensor.signal for sensor in self.sensors)
        parameters = ", ".join(self.physical_parameters)
        drives = ", ".join(drive.signal for drive in self.drives)
        return f"{self.name}: {bodies} moved by {drives}, measured by {sensors}, parameters {parameters}"

    @property
    def drives(self) -> tuple[Drive, ...]:
        """Drives in the order of their declaration."""
        return self.drive if isinstance(self.drive, tuple) else (self.drive,)

    @property
    def only_drive(self) -> Drive:
        """The drive of an axis that has one; SettingError if there are several, where that is not yet possible."""
        if isinstance(self.drive, tuple):
            signals = ", ".join(drive.signal for drive in self.drive)
            raise SettingError(
                f"axis {self.name!r} has {len(self.drive)} drives ({signals}): feed-forward takes an axis "
                "with one; identify, tune or diagnose it, or export it to C, an FMU or MJCF"
            )
        return self.drive

    @cached_property
    def bodies(self) -> tuple[Body, ...]:
        """Bodies in the order of their declaration."""
        return tuple(element for element in self.elements if isinstance(element, Body))

    @cached_property
    def free_bodies(self) -> tuple[Body, ...]:
        """Bodies that have a coordinate of their own: all but the geared ones."""
        return tuple(body for body in self.bodies if body.geared is None)

    @cached_property
    def laws(self) -> tuple[Law, ...]:
        """Force laws in the order of their declaration."""
        return tuple(element for element in self.elements if isinstance(element, Law))

    @cached_property
    def imperfections(self) -> tuple[Imperfection, ...]:
        """Effects with given numbers that no regressor contains, in the order of their declaration."""
        return tuple(element for element in self.elements if isinstance(element, Imperfection))

    def imperfections_of(self, drive: Drive) -> tuple[DriveImperfection, ...]:
        """Effects with given numbers that are in a drive, in the order of their declaration."""
        items = (item for item in self.imperfections if isinstance(item, DriveImperfection))
        return tuple(item for item in items if item.is_in(drive.signal))

    @cached_property
    def physical_parameters(self) -> dict[str, Unit]:
        """Unknown physical parameters and their units, in the order of the declaration."""
        known = self.known_parameters
        return {name: unit for name, unit in self.parameter_units.items() if name not in known}

    @cached_property
    def known_parameters(self) -> dict[str, float]:
        """Values of the physical parameters that are known, SI, in the order of the declaration."""
        numbers = {
            name: value
            for element in (*self.elements, *self.sensors)
            if not isinstance(element, (Weight, Imperfection))
            for name, value in element.numbers().items()
        }
        numbers |= {name: float(value) for name, value in self.known.items()}
        return {name: numbers[name] for name in self.parameter_units if name in numbers}

    def with_known_values(self, parameters: Mapping[str, float]) -> dict[str, float]:
        """Values of parameters and those that the axis knows, which go first, SI."""
        return {**parameters, **self.known_parameters}

    @cached_property
    def parameter_units(self) -> dict[str, Unit]:
        """Physical parameters, unknown and known, with their units, in the order of the declaration."""
        return dict(parameter_units((*self.elements, *self.sensors), self.drives))

    @cached_property
    def signed_parameters(self) -> tuple[str, ...]:
        """Physical parameters that may be negative; masses, springs, dampers, friction levels and gains may not."""
        of_laws = (term.parameter for law in self.laws for term in law.terms() if term.signed)
        offsets = (s.named("offset") for s in self.sensors if s.offset is not None)
        return (*of_laws, *offsets)

    @cached_property
    def log_parameters(self) -> tuple[str, ...]:
        """Physical parameters that have another value in each log."""
        return tuple(term.parameter for law in self.laws for term in law.terms() if term.per_log)

    @cached_property
    def signal_units(self) -> dict[str, Unit]:
        """Unit of every drive's and every sensor's signal, drives first."""
        signals: tuple[Drive | Sensor, ...] = (*self.drives, *self.sensors)
        return {sent.signal: signal_unit(self.drives, sent) for sent in signals}

    @property
    def controlled(self) -> str:
        """Signal of which a controller is made: the first of a position, or else of a velocity, or else the first."""
        return controlled_of(self.sensors) or self.sensors[0].signal

    @property
    def controlled_signals(self) -> tuple[str, ...]:
        """For each drive the signal of which its controller is made.

        With several drives, that of the driven body; `controlled` where it has none.
        """
        if len(self.drives) == 1:
            return (self.controlled,)
        driven = (end_of(drive.at) for drive in self.drives)
        return tuple(controlled_of(self.sensors, body) or self.controlled for body in driven)

    @property
    def reference_units(self) -> tuple[Unit, ...]:
        """For each drive the unit of its reference, which is a position even if a velocity is controlled."""
        orders = {sensor.signal: sensor.derivative or 0 for sensor in self.sensors}
        return tuple(
            self.signal_units[name] * Unit.of("s") ** orders[name] for name in self.controlled_signals
        )

    @property
    def required_sensors(self) -> tuple[str, ...]:
        """Signals without which no module is generated: the first sensor, with several drives one of each."""
        needed = {self.sensors[0].signal, *(self.controlled_signals if len(self.drives) > 1 else ())}
        return tuple(sensor.signal for sensor in self.sensors if sensor.signal in needed)

    @property
    def sensor_sets(self) -> tuple[tuple[str, ...], ...]:
        """Sets of sensors for which modules are generated: those required with every subset of the others.

        With more than `MOST_OPTIONAL_SENSORS` others: the required alone, with each single other, and with all.
        """
        required, places = self.required_sensors, [sensor.signal for sensor in self.sensors]
        others = [signal for signal in places if signal not in required]
        sizes = range(len(others) + 1) if len(others) <= MOST_OPTIONAL_SENSORS else (0, 1, len(others))
        subsets = (subset for size in sizes for subset in combinations(others, size))
        return tuple(tuple(sorted((*required, *subset), key=places.index)) for subset in subsets)

    def measured(self, signals: Sequence[str] | None = None) -> tuple[Sensor, ...]:
        """Sensors of the given signals in the order of the declaration; those required if None.

        SettingError if a signal is not that of a sensor of this axis.
        """
        wanted = self.required_sensors if signals is None else signals
        known = {sensor.signal for sensor in self.sensors}
        unknown = [signal for signal in wanted if signal not in known]
        if unknown or not wanted:
            raise SettingError(
                f"axis {self.name!r} has no sensor {', '.join(map(repr, unknown)) or 'in an empty set'}: "
                f"choose from {', '.join(sensor.signal for sensor in self.sensors)}"
            )
        return tuple(sensor for sensor in self.sensors if sensor.signal in wanted)

    def with_effect(self, *elements: Element) -> Axis:
        """The axis with more elements; an effect is an element like any other."""
        return replace(self, elements=(*self.elements, *elements))

    def without(self, *elements: Element) -> Axis:
        """The axis without some of its elements."""
        return replace(self, elements=tuple(element for element in self.elements if element not in elements))

    def with_known(self, values: Mapping[str, float]) -> Axis:
        """The axis with parameters of which the values are known.

        Parameters
        ----------
        values : mapping of str to float
            By name, SI.

        Raises
        ------
        SettingError
            If there is no such parameter, a value is not possible, or nothing is left to identify.

        Examples
        --------
        >>> from symid.axis import load_axis
        >>> list(load_axis("rigid_1m").with_known({"M": 95.0}).physical_parameters)
        ['Fv', 'Fs']
        """
        try:
            return replace(self, known={**self.known, **values})
        except DeclarationError as error:
            raise SettingError("; ".join(error.faults)) from error

    def with_signal(self, signal: str, noise: float, resolution: float = 0.0, delay: float = 0.0) -> Axis:
        """The axis with other imperfections of a sensor, or of a drive's recorded force (which has no delay).

        Raises
        ------
        SettingError
            If there is no such signal.

        Examples
        --------
        >>> from symid.axis import load_axis
        >>> load_axis("rigid_1m").with_signal("q", noise=1e-7).sensors[0].noise
        1e-07
        """
        recorded: dict[str, Any] = {"noise": noise, "resolution": resolution}
        if signal in [drive.signal for drive in self.drives]:
            drives = (replace(d, **recorded) if d.signal == signal else d for d in self.drives)
            return replace(self, drive=tuple(drives))
        (read,) = self.measured((signal,))
        sensors = (replace(s, **recorded, delay=delay) if s is read else s for s in self.sensors)
        return replace(self, sensors=tuple(sensors))

    @property
    def signature(self) -> str:
        """Hash of what was declared; generated modules carry it to show that they are up to date.

        Imperfections of signals do not count: no regressor depends on them.
        """
        return hash_of(self)
