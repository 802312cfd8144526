"""The gap: its size before and after, and where it lies."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Level:
    """Size of an error.

    Parameters
    ----------
    rms : float
        Root mean square, in the unit of its signal.
    relative : float
        Relative to the root mean square of the signal.
    """

    rms: float
    relative: float


@dataclass(frozen=True)
class Removed:
    """Share of the excess error of the re-identified model that an effect removes, on validation data.

    Parameters
    ----------
    share : float
        Of the mean square above the floor.
    low, high : float
        95 % interval of it, from resampled parts of the validation data; of an effect found also from what effects
        take over from each other, see `including`.
    """

    share: float
    low: float
    high: float

    def including(self, others: Iterable[float], spread: float) -> Removed:
        """The share with an interval that holds other values of it, each with a standard deviation relative to it.

        Parts of one log do not show what an effect takes over from others, as it takes over the same in all of them.

        >>> wide = Removed(0.8, 0.77, 0.83).including([], 0.05)
        >>> round(wide.low, 3), round(wide.high, 3)
        (0.716, 0.884)
        >>> wide = Removed(0.6, 0.5, 0.7).including([0.8], 0.05)
        >>> round(wide.low, 3), round(wide.high, 3)
        (0.484, 0.878)
        """
        low, high = (
            math.hypot(end - self.share, 1.96 * spread * self.share) for end in (self.low, self.high)
        )
        ends = [(self.share - low, self.share + high)]
        ends += [(share - 1.96 * spread * abs(share), share + 1.96 * spread * abs(share)) for share in others]
        most = max(self.high, 1.0)
        return Removed(self.share, min(end for end, _ in ends), min(max(end for _, end in ends), most))


@dataclass(frozen=True)
class Reversal:
    """Force error within 50 ms of reversals and standstills.

    Parameters
    ----------
    reidentified, explained : Level
        Of the declared structure, and with the effects found.
    """

    reidentified: Level
    explained: Level


@dataclass(frozen=True)
class NotRepeated:
    """Part of the force error that differs in each repetition of the motion: no law of the motion explains it."""

    period: float  # of the motion, s
    level: Level  # of that part of the error, with the effects found


@dataclass(frozen=True)
class MotionError:
    """Motion of a simulated axis compared with the measured one.

    Parameters
    ----------
    status : str
        "ok", or "failed": then the numbers are nan.
    position_fit, velocity_fit, tracking_fit : float
        100 (1 - abs(y - simulated)/abs(y - mean of y)) per cent of position, velocity and tracking error (reference
        less position, nan without a reference); 100 is perfect, below 0 worse than a constant.
    position_rms, velocity_rms : float
        Root mean square of the differences, SI.
    reversal_rms : float
        Root mean square difference of the positions within 50 ms of reversals, SI; nan if there are none.
    message : str
        Failures, or parts of the model that are not simulated.
    """

    status: Literal["ok", "failed"]
    position_fit: float = math.nan
    velocity_fit: float = math.nan
    tracking_fit: float = math.nan
    position_rms: float = math.nan
    velocity_rms: float = math.nan
    reversal_rms: float = math.nan
    message: str = ""


@dataclass(frozen=True)
class SimulatedMotion:
    """The gap in the motion of the simulated axis, on data that took no part in any choice.

    Parameters
    ----------
    signal, unit : str
        The position, and its unit.
    driver : str
        "given" controller, "identified" controller, or the measured force under an "observer".
    gains : mapping of str to float
        Kpp in 1/s, Kpv in SI and Kiv in 1/s of the controller or observer.
    share : float
        Share of the variance of the measured force that the controller explains; nan for an observer.
    tracking_rms : float
        Root mean square of the measured tracking error, SI; nan without a reference.
    nominal : MotionError or None
        With the nominal values; None if there are none.
    reidentified, explained : MotionError
        As for the force error.
    steps : tuple of MotionError
        With the first effect, the first two, and so on; the last is `explained`.
    """

    signal: str
    unit: str
    driver: Literal["given", "identified", "observer"]
    gains: Mapping[str, float]
    share: float
    tracking_rms: float
    nominal: MotionError | None
    reidentified: MotionError
    explained: MotionError
    steps: tuple[MotionError, ...]


@dataclass(frozen=True)
class Gap:
    """Force error of the inverse model on data that took no part in any choice.

    Parameters
    ----------
    signal, unit : str
        The drive force.
    band_hz : float
        Highest frequency of the comparison; above it, the noise of the position reading dominates.
    nominal : Level or None
        With the nominal values; None if there are none.
    reidentified : Level
        Same structure, parameters identified.
    explained : Level
        With the effects found added, everything identified again.
    noise_floor : Level
        Error that noise alone leaves, from the noise levels of the signals.
    steps : tuple of Level
        With the first effect, the first two, and so on; the last is `explained`.
    closed_fraction : float
        Removed fraction of the distance from `reidentified` to `noise_floor`; nan if that is zero.
    closed_interval : (float, float)
        95 % interval of it, from resampled parts of the validation data.
    unexplained_share : float
        Share of the re-identified model's excess that remains; nan if there is no excess.
    reversal : Reversal or None
        Error near reversals and standstills; None if the log has none.
    not_repeated : NotRepeated or None
        Part of the error that differs each time; None if the motion does not repeat within the validation data.
    motion : SimulatedMotion or None
        Error of the simulated motion; None where it was not simulated.
    """

    signal: str
    unit: str
    band_hz: float
    nominal: Level | None
    reidentified: Level
    explained: Level
    noise_floor: Level
    steps: tuple[Level, ...]
    closed_fraction: float
    closed_interval: tuple[float, float]
    unexplained_share: float
    reversal: Reversal | None
    not_repeated: NotRepeated | None = None
    motion: SimulatedMotion | None = None

    @property
    def least(self) -> float:
        """Least rms that a model can be expected to reach: the larger of the noise floor and the part not repeated."""
        return max(self.noise_floor.rms, self.not_repeated.level.rms if self.not_repeated else 0.0)


@dataclass(frozen=True)
class Location:
    """Place at which a share of the excess error arises.

    Parameters
    ----------
    at : str
        Body, spring, ``actuator`` or sensor signal.
    share : float
        Of the excess error of the re-identified model.
    band_hz : (float, float)
        Frequency band that holds most of it.
    regime : str
        Regime of motion with the largest part of it.
    """

    at: str
    share: float
    band_hz: tuple[float, float]
    regime: str


@dataclass(frozen=True)
class MapCell:
    """One cell of the map of the gap.

    Parameters
    ----------
    label : str
        Name of its band, regime or part of the stroke.
    low, high : float
        Its limits; nan without limits.
    samples : float
        Share of the rows in it.
    share : float
        Of the excess error of the re-identified model.
    before, after : float
        Error in multiples of the noise floor: re-identified, and with the effects found; nan where there is none.
    """

    label: str
    low: float
    high: float
    samples: float
    share: float
    before: float
    after: float
