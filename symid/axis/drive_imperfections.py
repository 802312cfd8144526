"""Elements of the drive that no regressor contains: between the force that is sent and the force that acts."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import ClassVar

from symid.axis.imperfections import Imperfection

__all__ = [
    "ActuatorDelay",
    "ActuatorLag",
    "DriveImperfection",
    "ForceConstantRipple",
    "ForceLimit",
    "GainAsymmetry",
    "GainNonlinearity",
]


@dataclass(frozen=True)
class DriveImperfection(Imperfection):
    """Element between the force F that a controller sends, and a log records, and the force f that acts.

    Parameters
    ----------
    drive : str, optional
        Signal of the drive in which it is; it is in each drive of the axis by default.

    Examples
    --------
    >>> ActuatorDelay(0.001, drive="F2").formula
    'f(t) = F(t - 0.001 s), of F2'
    """

    drive: str | None = field(default=None, kw_only=True)

    def is_in(self, signal: str) -> bool:
        """Whether it is in the drive of a signal."""
        return self.drive is None or self.drive == signal

    @property
    def formula(self) -> str:
        """Formula of the element with its numbers, and its drive if it is in one of several."""
        return self._formula if self.drive is None else f"{self._formula}, of {self.drive}"

    @property
    def _formula(self) -> str:
        return super().formula


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
    shown: ClassVar = "f(t) = F(t - {seconds:.4g} s)"


@dataclass(frozen=True)
class ActuatorLag(DriveImperfection):
    """The force follows like a first-order system: T f(1) + f = F.

    Parameters
    ----------
    seconds : float
        T.
    """

    seconds: float
    law: ClassVar = "z"
    rate: ClassVar = "(F - z)/seconds"
    shown: ClassVar = "{seconds:.4g} s f(1) + f = F"


@dataclass(frozen=True)
class ForceLimit(DriveImperfection):
    """The force does not exceed a limit: f = clip(F, -limit, limit).

    Parameters
    ----------
    force : float
        The limit, in the unit of the drive.
    """

    force: float
    law: ClassVar = "min(max(F, -force), force)"
    shown: ClassVar = "f = clip(F, -{force:.4g}, {force:.4g})"


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
    law: ClassVar = "F - bend*F*abs(F)**(power - 1)"

    @property
    def _formula(self) -> str:
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
    law: ClassVar = "F - difference*abs(F)"
    shown: ClassVar = "f = F - {difference:.4g} abs(F)"


@dataclass(frozen=True)
class ForceConstantRipple(DriveImperfection):
    """Ripple of the force constant along the stroke: f = F - F (As sin(2 pi q/pitch) + Ac cos(2 pi q/pitch)).

    q is the displacement in the joint of the drive, and F has passed its other imperfections; `law` is the part that is
    lost. It acts in the joint, as the motion changes it between two samples.

    Parameters
    ----------
    sine, cosine : float
        As and Ac, relative to the mean force constant.
    pitch : float
        Length of a period, m or rad.

    Examples
    --------
    >>> ForceConstantRipple(0.03, 0.02, pitch=0.024, drive="F2").formula
    'f = F - F (0.03 sin(2 pi q/0.024) + 0.02 cos(2 pi q/0.024)), of F2'
    """

    sine: float
    cosine: float
    pitch: float
    law: ClassVar = f"F*(sine*sin({math.tau!r}*q/pitch) + cosine*cos({math.tau!r}*q/pitch))"
    shown: ClassVar = "f = F - F ({sine:.4g} sin(2 pi q/{pitch:.4g}) + {cosine:.4g} cos(2 pi q/{pitch:.4g}))"


def ripples_of(drive: Iterable[DriveImperfection]) -> tuple[ForceConstantRipple, ...]:
    """Ripples among the imperfections of a drive, which act in its joint.

    >>> ripples_of([ActuatorLag(1e-3)])
    ()
    """
    return tuple(item for item in drive if isinstance(item, ForceConstantRipple))


def imperfections_in_order(drive: Iterable[DriveImperfection]) -> tuple[DriveImperfection, ...]:
    """Imperfections of a drive in the order in which a force passes them: gain, limit, lag, delay; without ripples.

    >>> [type(item).__name__ for item in imperfections_in_order([ForceLimit(9.0), GainAsymmetry(0.1)])]
    ['GainAsymmetry', 'ForceLimit']
    """
    kinds = (GainNonlinearity, GainAsymmetry, ForceLimit, ActuatorLag, ActuatorDelay)
    items = tuple(drive)
    return tuple(item for kind in (kinds[:2], *kinds[2:]) for item in items if isinstance(item, kind))
