"""Sensors of an axis. A kind is one class here: its name in `__all__` is a name of `symid`."""

from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple

from symid.axis.elements import Between, Body, Drive, Ground, Joint, Parameter, Parametrised, Spring

__all__ = ["Acceleration", "Force", "MotionSensor", "Position", "Sensor", "Velocity"]


class ReadingPart(NamedTuple):
    """A part of the reading of a sensor: a derivative of a displacement times a parameter, or the force of a drive."""

    of: Joint | Drive
    derivative: int = 0
    parameter: str | None = None


@dataclass(frozen=True)
class Sensor(Parametrised, ABC):
    """A reading of a quantity of the axis: quantity = gain * signal + offset.

    A kind of sensor is a subclass that states what is read in `parts`. Its derivation, identification and simulation
    follow from that.

    Parameters
    ----------
    signal : str
        Name of the signal, a column of the log.
    gain : str or float, optional
        Quantity per unit of the signal: name of the parameter, or its value; positive. 1 by default.
    offset : str or float, optional
        Quantity where the signal is 0: name of the parameter, or its value. 0 by default.
    unit : str, optional
        Unit of a signal with a gain, such as V; that of the quantity by default.
    noise, resolution : float
        Standard deviation of white noise and step of the reading, SI; for simulation.
    delay : float
        Age of a reading in seconds; for simulation.
    """

    signal: str
    gain: Parameter | None = field(default=None, kw_only=True)
    offset: Parameter | None = field(default=None, kw_only=True)
    unit: str | None = field(default=None, kw_only=True)
    noise: float = field(default=0.0, kw_only=True)
    resolution: float = field(default=0.0, kw_only=True)
    delay: float = field(default=0.0, kw_only=True)
    derivative: ClassVar[int | None] = None
    """Which derivative of a displacement is read, 0, 1 or 2; None of a sensor that reads something else."""

    @property
    @abstractmethod
    def quantity(self) -> str:
        """Quantity read: position, velocity, acceleration or force."""

    @property
    @abstractmethod
    def parts(self) -> tuple[ReadingPart, ...]:
        """Parts whose sum is the quantity."""

    @property
    @abstractmethod
    def joint(self) -> Joint:
        """The joint in which it reads."""

    @property
    def element(self) -> Spring | Drive | None:
        """The element whose force is read, which must be of the axis; None of a sensor that reads something else."""
        return None

    @property
    def is_scaled(self) -> bool:
        """Whether its gain or offset is a parameter."""
        return self.gain is not None or self.offset is not None

    @property
    def _label(self) -> str:
        return self.signal


@dataclass(frozen=True)
class MotionSensor(Sensor):
    """A reading of the displacement of a body against another, or of a time derivative of it.

    Parameters
    ----------
    signal : str
        Name of the signal, a column of the log.
    body : Body
        The body measured.
    relative_to : Body or Ground, optional
        The body it is measured from. By default the body it is on, so that the sensor reads the body's coordinate.
    ratio : float, optional
        Displacement of the body per displacement of `relative_to`, of which the sensor reads the difference: of a
        deflection behind a gear or a ball screw. 1 by default.
    gain, offset, unit, noise, resolution, delay
        As of any `Sensor`.
    """

    body: Body
    relative_to: Body | Ground | None = None
    ratio: float | None = field(default=None, kw_only=True)
    derivative: ClassVar[int]
    """Which derivative of the displacement is read: 0, 1 or 2."""

    @property
    def quantity(self) -> str:
        """Quantity read: position, velocity or acceleration."""
        return ("position", "velocity", "acceleration")[self.derivative]

    @property
    def reference(self) -> Body | Ground:
        """The body that the sensor measures from."""
        return self.body.on if self.relative_to is None else self.relative_to

    @property
    def joint(self) -> Joint:
        """The joint whose displacement it reads."""
        if self.relative_to is None:
            return self.body
        ratio = 1 if self.ratio is None else self.ratio
        return Between(first=self.relative_to, second=self.body, ratio=ratio)

    @property
    def parts(self) -> tuple[ReadingPart, ...]:
        """A derivative of that displacement."""
        return (ReadingPart(self.joint, self.derivative),)


@dataclass(frozen=True)
class Position(MotionSensor):
    """A position sensor: linear scale, encoder, laser.

    Examples
    --------
    >>> table = Body("table", mass="M")
    >>> Position("q", table, gain="cq", offset="oq").parts[0].of.name
    'table'
    """

    derivative: ClassVar = 0


@dataclass(frozen=True)
class Velocity(MotionSensor):
    """A velocity sensor: tachometer, gyroscope."""

    derivative: ClassVar = 1


@dataclass(frozen=True)
class Acceleration(MotionSensor):
    """An accelerometer: the second derivative of a displacement, m/s^2 or rad/s^2."""

    derivative: ClassVar = 2


@dataclass(frozen=True)
class Force(Sensor):
    """A force or torque sensor: a load cell or strain gauge in a spring, a transducer at a drive.

    In a spring it reads stiffness * d + damping * d(1), positive where the displacement d of the joint is, and the
    forces of the spring's nonlinear laws (`StiffnessNonlinearity`, `Backlash`, `GapDamping`). At a drive it reads the
    force that acts, in the direction of the drive.

    Parameters
    ----------
    signal : str
        Name of the signal, a column of the log.
    of : Spring or Drive
        The element whose force is read.
    gain, offset, unit, noise, resolution, delay
        As of any `Sensor`.

    Examples
    --------
    >>> motor, load = Body("motor", mass="Mm"), Body("load", mass="Ml")
    >>> shaft = Spring("shaft", Between(first=motor, second=load), stiffness="K", damping="D")
    >>> [(part.parameter, part.derivative) for part in Force("cell", shaft).parts]
    [('K', 0), ('D', 1)]
    """

    of: Spring | Drive

    @property
    def quantity(self) -> str:
        """A force; a torque where the joint turns."""
        return "force"

    @property
    def element(self) -> Spring | Drive:
        """The element whose force is read."""
        return self.of

    @property
    def joint(self) -> Joint:
        """The joint in which the force acts."""
        return self.of.at

    @property
    def parts(self) -> tuple[ReadingPart, ...]:
        """Forces of the spring and of its damping, or that of the drive."""
        if isinstance(self.of, Drive):
            return (ReadingPart(self.of),)
        stiffness = ReadingPart(self.of.at, 0, self.of.named("stiffness"))
        if self.of.damping is None:
            return (stiffness,)
        return stiffness, ReadingPart(self.of.at, 1, self.of.named("damping"))


def controlled_of(sensors: Iterable[Sensor], body: Body | Ground | None = None) -> str | None:
    """Signal of the first position sensor, or else velocity sensor, of a body or of any; None if there is none."""
    motions = (s for s in sensors if isinstance(s, MotionSensor) and s.derivative < 2)
    read = [sensor for sensor in motions if body in (None, sensor.body)]
    return min(read, key=lambda sensor: sensor.derivative).signal if read else None
