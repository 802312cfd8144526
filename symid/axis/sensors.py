"""Sensors of an axis. A kind is one class here: its name in `__all__` is a name of `symid`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from symid.axis.elements import Body, Ground

__all__ = ["Acceleration", "Position", "Sensor", "Velocity"]


@dataclass(frozen=True)
class Sensor:
    """A reading of the displacement of a body against another, or of a time derivative of it.

    A kind of sensor is a subclass that sets `derivative`. Its unit, derivation, identification, simulation, export and
    drawing follow from that.

    Parameters
    ----------
    signal : str
        Name of the signal, a column of the log.
    body : Body
        The body measured.
    relative_to : Body or Ground, optional
        The body it is measured from. By default the body it is on, so that the sensor reads the body's coordinate.
    noise, resolution : float
        Standard deviation of white noise and step of the reading, SI; for simulation.
    delay : float
        Age of a reading in seconds; for simulation.
    """

    signal: str
    body: Body
    relative_to: Body | Ground | None = None
    noise: float = 0.0
    resolution: float = 0.0
    delay: float = 0.0
    derivative: ClassVar[int]
    """Which time derivative of the displacement is read: 0, 1 or 2."""

    @property
    def reference(self) -> Body | Ground:
        """The body that the sensor measures from."""
        return self.body.on if self.relative_to is None else self.relative_to

    @property
    def quantity(self) -> str:
        """Quantity read: position, velocity or acceleration."""
        return ("position", "velocity", "acceleration")[self.derivative]


@dataclass(frozen=True)
class Position(Sensor):
    """A position sensor: linear scale, encoder, laser."""

    derivative: ClassVar = 0


@dataclass(frozen=True)
class Velocity(Sensor):
    """A velocity sensor: tachometer, gyroscope."""

    derivative: ClassVar = 1


@dataclass(frozen=True)
class Acceleration(Sensor):
    """An accelerometer."""

    derivative: ClassVar = 2
