"""The gap: its size before and after, and where it lies."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Level:
    """Size of an error."""

    rms: float
    """Root mean square, in the unit of its signal."""
    relative: float
    """Relative to the root mean square of the signal."""


@dataclass(frozen=True)
class Removed:
    """Share of the excess error of the re-identified model that an effect removes, on validation data."""

    share: float
    """Of the mean square above the floor."""
    low: float
    high: float
    """`low`, `high`: 95 % interval of it, from resampled parts of the validation data; of an effect found it allows
    also for the error that effects absorb of each other, see `including`."""

    def including(self, others: Iterable[float], spread: float) -> Removed:
        """The share with an interval that holds other values of it, each with a standard deviation relative to it.

        Parts of one log do not show the error that an effect absorbs of others, as it is the same in all of them.

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
    """Force error within 50 ms of reversals and standstills."""

    reidentified: Level
    explained: Level
    """`reidentified`, `explained`: of the declared structure, and with the effects found."""


@dataclass(frozen=True)
class NotRepeated:
    """Part of the force error that differs in each repetition of the motion: no law of the motion explains it."""

    period: float  # of the motion, s
    level: Level  # of that part of the error, with the effects found


@dataclass(frozen=True)
class MotionError:
    """Motion of a simulated axis compared with the measured one."""

    status: Literal["ok", "failed"]
    """Whether it could be simulated; the numbers are nan if it "failed"."""
    position_fit: float = math.nan
    velocity_fit: float = math.nan
    tracking_fit: float = math.nan
    """`position_fit`, `velocity_fit`, `tracking_fit`: 100 (1 - abs(y - simulated)/abs(y - mean of y)) per cent of
    position, velocity and tracking error (reference less position, nan without a reference); 100 is perfect, below 0
    worse than a constant."""
    position_rms: float = math.nan
    velocity_rms: float = math.nan
    """`position_rms`, `velocity_rms`: root mean square of the differences, SI."""
    reversal_rms: float = math.nan
    """Root mean square difference of the positions within 50 ms of reversals, SI; nan if there are none."""
    message: str = ""
    """Failures, or parts of the model that are not simulated."""


@dataclass(frozen=True)
class SimulatedMotion:
    """The gap in the motion of the simulated axis, on data that took no part in any choice."""

    signal: str
    unit: str
    """`signal`, `unit`: the position, and its unit."""
    driver: Literal["given", "identified", "observer"]
    """The "given" or "identified" controller, or the measured force under an "observer"."""
    gains: Mapping[str, float]
    """Kpp in 1/s, Kpv in SI and Kiv in 1/s of the controller or observer."""
    share: float
    """Share of the variance of the measured force that the controller explains; nan for an observer."""
    tracking_rms: float
    """Root mean square of the measured tracking error, SI; nan without a reference."""
    nominal: MotionError | None
    """With the nominal values; None if there are none."""
    reidentified: MotionError
    explained: MotionError
    """`reidentified`, `explained`: as for the force error."""
    steps: tuple[MotionError, ...]
    """With the first effect, the first two, and so on; the last is `explained`."""


@dataclass(frozen=True)
class Gap:
    """Force error of the inverse model on data that took no part in any choice."""

    signal: str
    unit: str
    """`signal`, `unit`: the drive force."""
    band_hz: float
    """Highest frequency of the comparison; above it, the noise of the position reading dominates."""
    nominal: Level | None
    """With the nominal values; None if there are none."""
    reidentified: Level
    """Same structure, parameters identified."""
    explained: Level
    """With the effects found added, everything identified again."""
    noise_floor: Level
    """Error that noise alone leaves, from the noise levels of the signals."""
    steps: tuple[Level, ...]
    """With the first effect, the first two, and so on; the last is `explained`."""
    closed_fraction: float
    """Removed fraction of the distance from `reidentified` to `noise_floor`; nan if that is zero."""
    closed_interval: tuple[float, float]
    """95 % interval of it, from resampled parts of the validation data."""
    unexplained_share: float
    """Share of the re-identified model's excess that remains; nan if there is no excess."""
    reversal: Reversal | None
    """Error near reversals and standstills; None if the log has none."""
    not_repeated: NotRepeated | None = None
    """Part of the error that differs each time; None if the motion does not repeat within the validation data."""
    motion: SimulatedMotion | None = None
    """Error of the simulated motion; None where it was not simulated."""

    @property
    def least(self) -> float:
        """Least rms that a model can be expected to reach: the larger of the noise floor and the part not repeated."""
        return max(self.noise_floor.rms, self.not_repeated.level.rms if self.not_repeated else 0.0)


@dataclass(frozen=True)
class Location:
    """Place at which a share of the excess error arises."""

    at: str
    """Body, spring, ``actuator`` or sensor signal."""
    share: float
    """Of the excess error of the re-identified model."""
    band_hz: tuple[float, float]
    """Frequency band that holds most of it."""
    regime: str
    """Regime of motion with the largest part of it."""


@dataclass(frozen=True)
class MapCell:
    """One cell of the map of the gap."""

    label: str
    """Name of its band, regime or part of the stroke."""
    low: float
    high: float
    """`low`, `high`: its limits; nan without limits."""
    samples: float
    """Share of the rows in it."""
    share: float
    """Of the excess error of the re-identified model."""
    before: float
    after: float
    """`before`, `after`: error in multiples of the noise floor: re-identified, and with the effects found; nan where
    there is none."""
