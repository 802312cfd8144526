"""Elements of an axis: bodies, springs, dampers, weights and the drive.

Elements are plain records that refer to each other as objects. They check nothing themselves: `Axis`
collects the faults of all its elements and reports them at once.

Coordinates follow the paper: the coordinate of a body is its displacement **relative to the body it is
on**. A joint is what lies between a body and the body it is on.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias, TypeGuard

__all__ = [
    "GROUND",
    "STANDARD_GRAVITY",
    "Between",
    "Body",
    "Damper",
    "Drive",
    "Geared",
    "Ground",
    "Joint",
    "PendulumWeight",
    "Spring",
    "Weight",
]

STANDARD_GRAVITY = 9.80665
"""m/s^2, ISO 80000-3."""


@dataclass(frozen=True)
class Ground:
    """The basement frame; bodies are on it unless declared otherwise."""

    name: str = "ground"


GROUND = Ground()


@dataclass(frozen=True, kw_only=True)
class Geared:
    """A rigid transmission: the body moves `ratio` times as far as the body that turns it.

    Parameters
    ----------
    to : Body
        The body that sets the motion, such as a ball screw or a pinion.
    ratio : float
        Displacement of the geared body per displacement of `to`: lead / (2 pi) for a ball screw in m/rad,
        the pitch radius for a rack, the inverse of the reduction for a gear.
    """

    to: Body
    ratio: float


Parameter: TypeAlias = str | float
"""Name of a physical parameter that is unknown, or the value of one that is known, in SI units."""


class Parametrised:
    """An element with parameters, each a name or a known value."""

    def named(self, field: str) -> str:
        """Name of the parameter in a field; a known value is named after the element and the field.

        >>> Body("load", mass=12.5).named("mass"), Body("load", mass="Ml").named("mass")
        ('load_mass', 'Ml')
        """
        value = getattr(self, field)
        return value if isinstance(value, str) else f"{self._label}_{field}"

    def numbers(self) -> dict[str, float]:
        """Known values by the names of their parameters."""
        given = {field: getattr(self, field, None) for field in PARAMETER_FIELDS}
        return {self.named(field): float(value) for field, value in given.items() if is_number(value)}

    @property
    def _label(self) -> str:
        return str(getattr(self, "name", "")) or getattr(self, "body").name  # noqa: B009


PARAMETER_FIELDS = ("mass", "inertia", "stiffness", "damping", "moment", "gain", "offset")
"""Fields of elements that hold a parameter."""


def is_number(value: object) -> TypeGuard[float]:
    """Whether a value is a number, finite or not; a truth value is not one."""
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def joint_label(joint: Joint) -> str:
    """Name of a joint within the name of a parameter."""
    return f"{joint.first.name}_{joint.second.name}" if isinstance(joint, Between) else joint.name


@dataclass(frozen=True)
class Body(Parametrised):
    """A rigid body that slides (it has a mass) or turns (it has an inertia).

    Parameters
    ----------
    name : str
        Name of the body, unique in its axis.
    mass, inertia : str or float
        Name of the physical parameter, or its value where it is known: exactly one of the two.
    on : Body
        The body that carries it; its coordinate is relative to that body. The ground by default.
    geared : Geared or tuple of Geared, optional
        Rigid transmission from another body, or from several, whose contributions add up. A geared body has no
        separate coordinate.

    Examples
    --------
    >>> structure = Body("structure", mass="Ms")
    >>> motor = Body("motor", mass="Mm", on=structure)

    A beam between two carriages moves by their mean.

    >>> left, right = Body("left", mass="M1"), Body("right", mass="M2")
    >>> beam = Body("beam", mass="Mb", geared=(Geared(to=left, ratio=0.5), Geared(to=right, ratio=0.5)))
    """

    name: str
    mass: Parameter | None = None
    inertia: Parameter | None = None
    on: Body | Ground = GROUND
    geared: Geared | tuple[Geared, ...] | None = None

    @property
    def gears(self) -> tuple[Geared, ...]:
        """Transmissions of the body; empty for a body with its own coordinate."""
        if self.geared is None:
            return ()
        return self.geared if isinstance(self.geared, tuple) else (self.geared,)

    @property
    def parent(self) -> Body | None:
        """The body with its own coordinate, of the same kind of motion, that carries it; None if there is none."""
        on = self.on
        return on if isinstance(on, Body) and on.geared is None and on.turns == self.turns else None

    @property
    def turns(self) -> bool:
        """Whether the body turns (True) or slides (False)."""
        return self.inertia is not None

    @property
    def inertial(self) -> str:
        """Name of its mass or inertia."""
        return self.named("inertia" if self.turns else "mass")


@dataclass(frozen=True, kw_only=True)
class Between:
    """The displacement of one body against another: d = x(second) - ratio * x(first), in absolute coordinates.

    Of a turning and a sliding body, that of the sliding one is taken against the body that carries the turning one.

    Parameters
    ----------
    first, second : Body or Ground
        The two bodies.
    ratio : float
        Displacement of the second per displacement of the first: 1 where both slide, lead / (2 pi) where
        the first is a ball screw and the second its nut.
    """

    first: Body | Ground
    second: Body | Ground
    ratio: float = 1


Joint: TypeAlias = Body | Between
"""A body stands for the joint between it and the body it is on."""


@dataclass(frozen=True)
class Spring(Parametrised):
    """A linear spring, with damping in parallel if wanted: force = stiffness * d + damping * d(1).

    Parameters
    ----------
    name : str
        Name of the spring, unique in its axis (``"transmission"`` between motor and load).
    at : Body or Between
        The joint of a body, or two bodies.
    stiffness : str or float
        Name of the physical parameter, or its value where it is known.
    damping : str or float, optional
        The same of a damper in parallel.

    Examples
    --------
    >>> motor, load = Body("motor", mass="Mm"), Body("load", mass="Ml")
    >>> transmission = Spring("transmission", Between(first=motor, second=load), stiffness="Kt", damping="Ft")
    """

    name: str
    at: Joint
    stiffness: Parameter
    damping: Parameter | None = None


@dataclass(frozen=True)
class Damper(Parametrised):
    """A linear damper: force = damping * d(1)."""

    name: str
    at: Joint
    damping: Parameter


@dataclass(frozen=True)
class Weight:
    """The weight of a sliding body whose coordinate points upwards: a force -M g on the body.

    Parameters
    ----------
    body : Body
        A body that slides, also one that is geared, such as the table of a vertical ball screw.
    acceleration : float
        Component of gravity against the positive direction, in m/s^2: g for a vertical axis, g sin(angle) on an
        incline, negative where the coordinate points downwards.
    """

    body: Body
    acceleration: float = STANDARD_GRAVITY


@dataclass(frozen=True)
class PendulumWeight(Parametrised):
    """The weight of a turning body: a torque -(m l) g sin(q), q being its absolute angle, 0 when it hangs.

    Parameters
    ----------
    body : Body
        A body that turns.
    moment : str or float
        Name of the physical parameter m l, or its value where it is known, in kg m.
    acceleration : float
        Gravity in m/s^2.
    """

    body: Body
    moment: Parameter
    acceleration: float = STANDARD_GRAVITY


@dataclass(frozen=True)
class Drive:
    """The drive: +F on the second body and the reaction on the first one (on what carries it, for a joint).

    Parameters
    ----------
    signal : str
        Name of the force (or torque) signal, a column of the log.
    at : Body or Between
        The joint of the driven body, or two bodies.
    gain : float or str, optional
        Force per unit of the command, for a log that holds the command instead of the force; the name of a parameter
        where it is unknown: then `signal` is the command, such as a current in the `unit` A.
    command : str, optional
        Name of that command's column, such as a current or a controller output in volts.
    unit : str, optional
        Unit of the force signal. N for a sliding, N*m for a turning body by default. Give ``"A"`` to identify
        an axis in current units where the torque constant is unknown.
    held : bool
        Whether a sample of the force is sent at t and held until the next one; it then acts half a sample late.
    noise, resolution : float
        Standard deviation of white noise and step of the recorded force, in its unit; for simulation.
    """

    signal: str
    at: Joint
    gain: Parameter | None = None
    command: str | None = None
    unit: str | None = None
    held: bool = False
    noise: float = 0.0
    resolution: float = 0.0

    @property
    def constant(self) -> str | None:
        """Name of the parameter by which the signal becomes a force; None if the signal is a force itself."""
        return self.gain if isinstance(self.gain, str) else None

    @property
    def factor(self) -> float:
        """Force per unit of the command; 1 where the log holds the drive's signal."""
        return float(self.gain) if is_number(self.gain) else 1.0
