"""Limits of a commanded motion, and advice on how to keep them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from symid.errors import SettingError

_RATES: Final = (
    ("speed", "m/s or rad/s"),
    ("acceleration", "m/s^2 or rad/s^2"),
    ("jerk", "m/s^3 or rad/s^3"),
)
_ROUNDING: Final = 1e-9  # share of a limit by which rounding may exceed it


@dataclass(frozen=True)
class Extremes:
    """Range and greatest magnitudes of a trajectory, SI.

    Parameters
    ----------
    lowest, highest : float
        Range of the position, m or rad.
    speed, acceleration, jerk : float
        Greatest magnitude of the derivatives of order 1 to 3.
    """

    lowest: float
    highest: float
    speed: float
    acceleration: float
    jerk: float

    @property
    def reached(self) -> dict[str, float]:
        """Largest distance from zero, speed and acceleration, by name."""
        travel = max(abs(self.lowest), abs(self.highest))
        return {"travel": travel, "speed": self.speed, "acceleration": self.acceleration}


@dataclass(frozen=True)
class Limits:
    """Travel, speed, acceleration and jerk that an axis allows, SI. Infinity means no limit.

    Parameters
    ----------
    travel : tuple of float
        Lowest and highest position, m or rad.
    speed : float
        Greatest speed, m/s or rad/s.
    acceleration : float
        Greatest acceleration, m/s^2 or rad/s^2.
    jerk : float
        Greatest jerk, m/s^3 or rad/s^3.

    Raises
    ------
    SettingError
        If the travel is empty or a limit is not positive.

    Examples
    --------
    >>> Limits((0.0, 1.2), speed=1.0).check("ramp", Extremes(0.0, 1.0, 1.5, 0.0, 0.0))
    Traceback (most recent call last):
        ...
    symid.errors.SettingError: ramp: speed reaches 1.5, 0.5 more than the limit of 1 m/s or rad/s: multiply the \
amplitude by at most 0.6666
    """

    travel: tuple[float, float]
    speed: float = math.inf
    acceleration: float = math.inf
    jerk: float = math.inf

    def __post_init__(self) -> None:
        low, high = self.travel
        if not low < high:
            raise SettingError(
                f"travel from {low:g} to {high:g} is empty: give the lowest position, then the highest"
            )
        object.__setattr__(self, "travel", (float(low), float(high)))
        for kind, unit in _RATES:
            if not getattr(self, kind) > 0.0:
                raise SettingError(
                    f"limit of {kind} is {getattr(self, kind):g} {unit}: give a positive number"
                )

    def check(self, name: str, demand: Extremes, *, scaled: bool = True) -> None:
        """SettingError if a trajectory exceeds a limit: it names each exceeded limit, the excess and a remedy.

        The remedy is a smaller amplitude if the whole trajectory is `scaled` by one; otherwise it is a smaller speed,
        acceleration or jerk.
        """
        faults = self._faults_of_travel(demand)
        for kind, unit in _RATES:
            value, limit = getattr(demand, kind), getattr(self, kind)
            if value > limit * (1.0 + _ROUNDING):
                advice = (
                    f"multiply the amplitude by at most {_rounded_down(limit / value)}"
                    if scaled
                    else f"ask for a {kind} of at most {limit:g}"
                )
                faults.append(
                    f"{kind} reaches {value:g}, {value - limit:g} more than the limit of {limit:g} {unit}: {advice}"
                )
        if faults:
            raise SettingError(f"{name}: " + "; ".join(faults))

    def _faults_of_travel(self, demand: Extremes) -> list[str]:
        low, high = self.travel
        below, above = low - demand.lowest, demand.highest - high
        span, travel = demand.highest - demand.lowest, high - low
        margin = _ROUNDING * span
        if max(below, above) <= margin:
            return []
        if span <= travel:
            advice = f"shift it by {below if below > margin else -above:g}"
        else:
            advice = f"it spans {span:g}: shorten it to at most {_rounded_down(travel / span)} of that"
        ends = " and ".join(
            f"the {side} end of travel, {end:g} m or rad, by {excess:g}"
            for side, end, excess in (("lower", low, below), ("upper", high, above))
            if excess > margin
        )
        return [f"position goes beyond {ends}: {advice}"]


def _rounded_down(share: float) -> str:
    """A share between 0 and 1, rounded down to four digits."""
    if share <= 0.0:
        return "0"
    scale = 10.0 ** (3 - math.floor(math.log10(share)))
    return f"{math.floor(share * scale) / scale:.4g}"
