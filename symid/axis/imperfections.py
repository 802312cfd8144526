"""Elements that no regressor contains: of a reading, in time, with memory (`drive_imperfections`: of the drive).

An imperfection is an element like any other: it is declared, simulated, and written by a diagnosis. Its values are
numbers of the declaration, since no regressor holds them: derivation and least squares pass it over.
"""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import ClassVar

from symid.axis.elements import Body, Joint
from symid.axis.laws.law import is_finite

__all__ = [
    "EncoderRipple",
    "FrictionDrift",
    "FrictionTrend",
    "Imperfection",
    "JointImperfection",
    "LoadDependentFriction",
    "PayloadChange",
    "PeriodicForce",
    "PreslidingFriction",
]

_PLACES = ("at", "body", "signal", "drive")
"""Fields that are not numbers."""
_TURN = repr(math.tau)


@dataclass(frozen=True)
class Imperfection:
    """Base class of effects with given numbers that no regressor contains.

    Simulation and exports read what it does from `law` and `rate`, in the names of the fields, q and v (displacement
    and velocity of its joint), t (time), F (force of the drive), y (reading) and z (its memory).
    """

    law: ClassVar[str] = ""
    """Force against the motion of its joint; or the force that acts, or the reading, in place of F or y."""
    rate: ClassVar[str] = ""
    """z(1) of an element with memory, linear in z; z is 0 at the start."""
    shown: ClassVar[str]
    """Formula for readers: a format of the fields."""

    def in_numbers(self, text: str) -> str:
        """`law` or `rate` with the numbers of the declaration in place of the fields.

        Examples
        --------
        >>> from symid import ForceLimit
        >>> limit = ForceLimit(25.0)
        >>> limit.in_numbers(limit.law)
        'min(max(F, -(25.0)), (25.0))'
        """
        values = self._numbers.items()
        written = {name: f"({x if isinstance(x, int) else float(x)!r})" for name, x in values}
        return re.sub(r"[a-z_]+", lambda found: written.get(found[0], found[0]), text)

    @property
    def formula(self) -> str:
        """Formula of the element with its numbers."""
        return self.shown.format_map(vars(self))

    def faults(self) -> Iterator[str]:
        """Faults of its numbers; `Axis` reports them with all others."""
        positive = ("seconds", "force", "pitch", "frequency", "time_constant", "reach", "level", "time")
        for name, value in self._numbers.items():
            if not is_finite(value):
                yield f"{name} is {value!r}: it must be a finite number"
            elif name in positive and not value > 0:
                yield f"{name} is {value!r}: it must be positive"

    @property
    def _numbers(self) -> dict[str, float]:
        return {f.name: getattr(self, f.name) for f in fields(self) if f.name not in _PLACES}


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
    law: ClassVar = f"y + sine*sin({_TURN}*y/pitch) + cosine*cos({_TURN}*y/pitch)"
    shown: ClassVar = (
        "{signal} reads {signal} + {sine:.4g} sin(2 pi {signal}/{pitch:.4g})"
        " + {cosine:.4g} cos(2 pi {signal}/{pitch:.4g})"
    )


@dataclass(frozen=True)
class PayloadChange(Imperfection):
    """The mass (or inertia) of a body changes at a moment.

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
    shown: ClassVar = "{body.inertial} + {change:.4g} from {time:.4g} s on"


@dataclass(frozen=True)
class PeriodicForce(JointImperfection):
    """A disturbance in time: As sin(2 pi f t) + Ac cos(2 pi f t).

    Parameters
    ----------
    sine, cosine : float
        As and Ac, N or N m.
    frequency : float
        f, Hz; t is the time since the beginning of a run.
    """

    sine: float
    cosine: float
    frequency: float
    law: ClassVar = f"sine*sin({_TURN}*frequency*t) + cosine*cos({_TURN}*frequency*t)"
    shown: ClassVar = "{sine:.4g} sin(2 pi {frequency:.4g} t) + {cosine:.4g} cos(2 pi {frequency:.4g} t)"


@dataclass(frozen=True)
class FrictionDrift(JointImperfection):
    """Friction that fades while the axis warms up: exp(-t/T) (coulomb sign(v) + viscous v), beside declared friction.

    Parameters
    ----------
    coulomb, viscous : float
        Excess of the cold axis over the warm one: N or N m, N s/m or N m s/rad.
    time_constant : float
        T, s.
    """

    coulomb: float
    viscous: float
    time_constant: float
    law: ClassVar = "exp(-t/time_constant)*(coulomb*sign(v) + viscous*v)"
    shown: ClassVar = "exp(-t/{time_constant:.4g} s) ({coulomb:.4g} sign(v) + {viscous:.4g} v)"


@dataclass(frozen=True)
class FrictionTrend(JointImperfection):
    """Friction that changes steadily: t (coulomb sign(v) + viscous v), beside declared friction.

    Parameters
    ----------
    coulomb, viscous : float
        Change in a second.
    """

    coulomb: float
    viscous: float
    law: ClassVar = "t*(coulomb*sign(v) + viscous*v)"
    shown: ClassVar = "t ({coulomb:.4g} sign(v) + {viscous:.4g} v)"


@dataclass(frozen=True)
class PreslidingFriction(JointImperfection):
    """Part of the Coulomb friction declared builds up over a displacement (Dahl): level (z - sign(v)).

    z(1) = (v - abs(v) z)/reach. Where less than `level` is declared in the joint, the declared level counts.

    Parameters
    ----------
    at : Body or Between
        The joint, which needs a `CoulombFriction`.
    level : float
        Part of the Coulomb friction, N or N m.
    reach : float
        Displacement after which the force has come within 1/e of its level, m or rad.
    """

    level: float
    reach: float
    law: ClassVar = "level*(z - sign(v))"
    rate: ClassVar = "(v - abs(v)*z)/reach"
    shown: ClassVar = "{level:.4g} (z - sign(v)), z(1) = (v - abs(v) z)/{reach:.4g}"


@dataclass(frozen=True)
class LoadDependentFriction(JointImperfection):
    """Friction that grows with the force of the drive: coefficient abs(F) sign(v).

    F is the force also where the signal is a command, such as a current, with an unknown `Drive.gain`.

    Parameters
    ----------
    coefficient : float
        mu.
    """

    coefficient: float
    law: ClassVar = "coefficient*abs(F)*sign(v)"
    shown: ClassVar = "{coefficient:.4g} abs(F) sign(v)"
