"""A case: an axis as declared to symid, beside its equations of motion written by hand."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from axes.plant import Plant, Sensor, Values
from symid import Axis

LEAD = 0.01
SCREW = LEAD / (2 * math.pi)
GRAVITY = 9.80665
PINION = 0.025
INCLINE = GRAVITY * math.sin(math.radians(25))


@dataclass(frozen=True)
class Case:
    """An axis and all that is known of it without symid."""

    declared: Axis  # what symid is given
    values: Mapping[str, float]  # physical parameters in the order in which they must be listed
    build: Callable[[Values], Plant]  # plant at some values
    sensors: Mapping[str, Sensor]  # what each sensor reads of the plant's displacements
    shipped: bool = False  # whether the axis is one of models/
    refused: tuple[tuple[str, ...], ...] = ()  # sets of sensors from which a nonlinear law cannot be seen
    # parameters that leave no trace in the signals of a set of sensors
    hidden: Mapping[tuple[str, ...], tuple[str, ...]] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Name of the axis."""
        return self.declared.name

    @property
    def sensor_sets(self) -> tuple[tuple[str, ...], ...]:
        """Sets of sensors that allow a model."""
        return tuple(chosen for chosen in self.declared.sensor_sets if chosen not in self.refused)

    def plant(self, **changed: float) -> Plant:
        """Plant at the case's values, some of them changed."""
        return self.build(Values({**self.values, **changed}))
