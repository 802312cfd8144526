"""The gap: its size before and after, and where it lies."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Level:
    """Size of an error.

    Parameters
    ----------
    rms : float
        Root mean square, in the unit of its signal.
    relative : float
        The same relative to the root mean square of the signal.
    """

    rms: float
    relative: float


@dataclass(frozen=True)
class Removed:
    """Share of the excess error of the re-identified model that an effect takes away, on data it has not seen.

    Parameters
    ----------
    share : float
        Of the mean square above the floor.
    low, high : float
        95 % interval of it, from resampled parts of the validation data.
    """

    share: float
    low: float
    high: float


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
class Gap:
    """Force error of the inverse model on data that took no part in any choice.

    Parameters
    ----------
    signal, unit : str
        The drive force.
    band_hz : float
        Up to here the force error is compared: above, the noise of the position reading drowns it.
    nominal : Level or None
        With the nominal values; None if there are none.
    reidentified : Level
        Same structure, parameters identified.
    explained : Level
        With the effects found added, everything identified again.
    noise_floor : Level
        What noise alone leaves, from the noise levels of the signals.
    steps : tuple of Level
        With the first effect, the first two, and so on; the last is `explained`.
    closed_fraction : float
        Of the way from `reidentified` to `noise_floor`; nan if that way has no length.
    closed_interval : (float, float)
        95 % interval of it, from resampled parts of the validation data.
    unexplained_share : float
        Share of the mean square of the re-identified model's error above the floor that stays; nan if it has none.
    reversal : Reversal or None
        The same error near reversals and standstills; None if the log has none.
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


@dataclass(frozen=True)
class Location:
    """Where a share of the excess error comes from.

    Parameters
    ----------
    at : str
        Body, spring, ``actuator`` or sensor signal.
    share : float
        Of the excess error of the re-identified model.
    band_hz : (float, float)
        Frequency band that holds most of it.
    regime : str
        Regime of motion in which most of it is.
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
        What it holds: a band, a regime, a part of the stroke.
    low, high : float
        Its limits, nan where it has none.
    samples : float
        Share of the rows that it holds.
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
