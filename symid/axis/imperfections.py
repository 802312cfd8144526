"""What acts beyond the regressor: in the drive, in a reading, in time, with a memory.

An imperfection is an element like any other: it is declared, simulated, and written by a diagnosis. Its values are
numbers of the declaration, since no regressor holds them: derivation and least squares pass it over.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, fields

from symid.axis.elements import Body, Joint
from symid.axis.laws.base import is_finite

__all__ = [
    "ActuatorDelay",
    "ActuatorLag",
    "DriveImperfection",
    "EncoderRipple",
    "ForceLimit",
    "FrictionDrift",
    "FrictionTrend",
    "GainAsymmetry",
    "GainNonlinearity",
    "Imperfection",
    "JointImperfection",
    "LoadDependentFriction",
    "PayloadChange",
    "PeriodicForce",
    "PreslidingFriction",
]


@dataclass(frozen=True)
class Imperfection(ABC):
    """Base of what acts beyond the regressor."""

    @property
    @abstractmethod
    def formula(self) -> str:
        """What it does, with its numbers."""

    def faults(self) -> Iterator[str]:
        """What is wrong with its numbers; `Axis` reports it with all other faults."""
        positive = ("seconds", "force", "pitch", "frequency", "time_constant", "reach", "level", "time")
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name in ("at", "body", "signal"):
                continue
            if not is_finite(value):
                yield f"{field.name} is {value!r}: it must be a finite number"
            elif field.name in positive and not value > 0:
                yield f"{field.name} is {value!r}: it must be positive"


@dataclass(frozen=True)
class DriveImperfection(Imperfection):
    """What lies between the force F that a controller sends, and a log records, and the force f that acts."""


@dataclass(frozen=True)
class JointImperfection(Imperfection):
    """A force in a joint, against its motion.

    Parameters
    ----------
    at : Body or Between
        The joint.
    """

    at: Joint


@dataclass(frozen=True)
class ActuatorDelay(DriveImperfection):
    """The force acts later than it is sent: f(t) = F(t - T).

    Parameters
    ----------
    seconds : float
        T.

    Examples
    --------
    >>> ActuatorDelay(0.001).formula
    'f(t) = F(t - 0.001 s)'
    """

    seconds: float

    @property
    def formula(self) -> str:
        """What it does."""
        return f"f(t) = F(t - {self.seconds:.4g} s)"


@dataclass(frozen=True)
class ActuatorLag(DriveImperfection):
    """The force follows like a first-order system: T f(1) + f = F.

    Parameters
    ----------
    seconds : float
        T.
    """

    seconds: float

    @property
    def formula(self) -> str:
        """What it does."""
        return f"{self.seconds:.4g} s f(1) + f = F"


@dataclass(frozen=True)
class ForceLimit(DriveImperfection):
    """The force does not exceed a limit: f = clip(F, -limit, limit).

    Parameters
    ----------
    force : float
        The limit, in the unit of the drive.
    """

    force: float

    @property
    def formula(self) -> str:
        """What it does."""
        return f"f = clip(F, {-self.force:.4g}, {self.force:.4g})"


@dataclass(frozen=True)
class GainNonlinearity(DriveImperfection):
    """The force bends over its command: f = F - bend F abs(F)^(power - 1).

    Parameters
    ----------
    bend : float
        In the unit of the drive to the power of 1 - power; positive where the gain droops.
    power : int
        2 or 3.
    """

    bend: float
    power: int

    @property
    def formula(self) -> str:
        """What it does."""
        return f"f = F - {self.bend:.4g} F abs(F)^{self.power - 1}"


@dataclass(frozen=True)
class GainAsymmetry(DriveImperfection):
    """The gain differs by direction: f = F - difference abs(F).

    Parameters
    ----------
    difference : float
        Half of the difference of both gains, backward less forward.
    """

    difference: float

    @property
    def formula(self) -> str:
        """What it does."""
        return f"f = F - {self.difference:.4g} abs(F)"


@dataclass(frozen=True)
class EncoderRipple(Imperfection):
    """A position reading with an error that repeats along the stroke: y + As sin(2 pi y/pitch) + Ac cos(2 pi y/pitch).

    Parameters
    ----------
    signal : str
        Of a position sensor.
    sine, cosine : float
        As and Ac, m or rad.
    pitch : float
        Length of a period, m or rad.
    """

    signal: str
    sine: float
    cosine: float
    pitch: float

    @property
    def formula(self) -> str:
        """What it does."""
        y, phase = self.signal, f"2 pi {self.signal}/{self.pitch:.4g}"
        return f"{y} reads {y} + {self.sine:.4g} sin({phase}) + {self.cosine:.4g} cos({phase})"


@dataclass(frozen=True)
class PayloadChange(Imperfection):
    """The mass (or inertia) of a body is another from a moment on.

    Parameters
    ----------
    body : Body
        The body.
    change : float
        By which its mass grows, kg or kg m^2.
    time : float
        Since the beginning of a run, s.
    """

    body: Body
    change: float
    time: float

    @property
    def formula(self) -> str:
        """What it does."""
        return f"{self.body.inertial} + {self.change:.4g} from {self.time:.4g} s on"


@dataclass(frozen=True)
class PeriodicForce(JointImperfection):
    """A disturbance in time: As sin(2 pi f t) + Ac cos(2 pi f t).

    Parameters
    ----------
    at : Body or Between
        The joint.
    sine, cosine : float
        As and Ac, N or N m.
    frequency : float
        f, Hz; t is the time since the beginning of a run.
    """

    sine: float
    cosine: float
    frequency: float

    @property
    def formula(self) -> str:
        """What it does."""
        phase = f"2 pi {self.frequency:.4g} t"
        return f"{self.sine:.4g} sin({phase}) + {self.cosine:.4g} cos({phase})"


@dataclass(frozen=True)
class FrictionDrift(JointImperfection):
    """Friction that fades while the axis warms up: exp(-t/T) (coulomb sign(v) + viscous v), beside declared friction.

    Parameters
    ----------
    at : Body or Between
        The joint.
    coulomb, viscous : float
        What the cold axis has more than the warm one: N or N m, N s/m or N m s/rad.
    time_constant : float
        T, s.
    """

    coulomb: float
    viscous: float
    time_constant: float

    @property
    def formula(self) -> str:
        """What it does."""
        return f"exp(-t/{self.time_constant:.4g} s) ({self.coulomb:.4g} sign(v) + {self.viscous:.4g} v)"


@dataclass(frozen=True)
class FrictionTrend(JointImperfection):
    """Friction that changes steadily: t (coulomb sign(v) + viscous v), beside declared friction.

    Parameters
    ----------
    at : Body or Between
        The joint.
    coulomb, viscous : float
        Change in a second.
    """

    coulomb: float
    viscous: float

    @property
    def formula(self) -> str:
        """What it does."""
        return f"t ({self.coulomb:.4g} sign(v) + {self.viscous:.4g} v)"


@dataclass(frozen=True)
class PreslidingFriction(JointImperfection):
    """Part of the Coulomb friction declared builds up over a displacement (Dahl): level (z - sign(v)).

    z(1) = (v - abs(v) z)/reach. Where less than `level` is declared in the joint, the declared level counts.

    Parameters
    ----------
    at : Body or Between
        The joint, with `CoulombFriction`.
    level : float
        Part of the Coulomb friction, N or N m.
    reach : float
        Displacement after which the force has come within 1/e of its level, m or rad.
    """

    level: float
    reach: float

    @property
    def formula(self) -> str:
        """What it does."""
        return f"{self.level:.4g} (z - sign(v)), z(1) = (v - abs(v) z)/{self.reach:.4g}"


@dataclass(frozen=True)
class LoadDependentFriction(JointImperfection):
    """Friction that grows with the force of the drive: coefficient abs(F) sign(v).

    Parameters
    ----------
    at : Body or Between
        The joint.
    coefficient : float
        mu.
    """

    coefficient: float

    @property
    def formula(self) -> str:
        """What it does."""
        return f"{self.coefficient:.4g} abs(F) sign(v)"
