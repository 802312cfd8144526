"""Sampling of trajectories, their fades, limits of a commanded motion, and advice on how to keep them."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from symid.arrays import FloatArray
from symid.errors import SettingError

MOST_SAMPLES: Final = 100_000_000
"""Longest trajectory; position, velocity and acceleration then take 2.4 GB."""
_WHOLE: Final = 1e-9  # a duration this close to whole sampling periods, relative to one period, is whole


def checked_positive(value: float, what: str, unit: str) -> float:
    """The value itself, as a float; SettingError if it is not positive and finite.

    >>> checked_positive(2, "dwell", "s")
    2.0
    """
    if not (math.isfinite(value) and value > 0.0):
        raise SettingError(f"{what} is {value:g} {unit}: give a positive number")
    return float(value)


def intervals(seconds: float, sampling_period: float, what: str) -> int:
    """Number of sampling periods, s, in a duration of 0 s or more, rounded up.

    SettingError if the duration is not possible or has more than `MOST_SAMPLES`; `what` names it in the message.

    >>> intervals(0.3, 0.1, "dwell"), intervals(0.31, 0.1, "dwell")
    (3, 4)
    """
    checked_positive(sampling_period, "sampling period", "s")
    if not (math.isfinite(seconds) and seconds >= 0.0):
        raise SettingError(f"{what} is {seconds:g} s: give 0 s or more")
    ratio = seconds / sampling_period
    if ratio >= MOST_SAMPLES:
        raise SettingError(
            f"{what} of {seconds:g} s is {ratio:.3g} samples of {sampling_period:g} s: at most "
            f"{MOST_SAMPLES:g} are possible: give a shorter time or a longer sampling period"
        )
    return math.ceil(ratio - _WHOLE * max(1.0, ratio * 1e-3))


def fade_envelope(
    n_intervals: int, n_fade: int, sampling_period: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Envelope that rises from 0 to 1 and falls to 0 again, with its first and second time derivatives.

    The flanks, of `n_fade` of all `n_intervals`, are polynomials of degree 7 whose first three derivatives vanish at
    both ends: a faded motion begins and ends with zero velocity, acceleration and jerk.

    >>> value, slope, curvature = fade_envelope(8, 4, 0.5)
    >>> value.tolist()[:5], slope.tolist()[2], curvature.tolist()[2]
    ([0.0, 0.070556640625, 0.5, 0.929443359375, 1.0], 1.09375, 0.0)
    """
    value, slope, curvature = np.ones(n_intervals + 1), np.zeros(n_intervals + 1), np.zeros(n_intervals + 1)
    if n_fade:
        s = np.arange(n_fade + 1) / n_fade
        rest, seconds = 1.0 - s, n_fade * sampling_period
        rise = s**4 * (35.0 + s * (-84.0 + s * (70.0 - 20.0 * s)))
        rise_slope = 140.0 * (s * rest) ** 3 / seconds
        rise_curvature = 420.0 * (s * rest) ** 2 * (rest - s) / seconds**2
        for whole, flank, sign in (
            (value, rise, 1.0),
            (slope, rise_slope, -1.0),
            (curvature, rise_curvature, 1.0),
        ):
            whole[: n_fade + 1] = flank
            whole[-n_fade - 1 :] = sign * flank[::-1]
    return value, slope, curvature


def faded(waves: FloatArray, n_steady: int, n_fade: int, sampling_period: float) -> FloatArray:
    """Position about its centre, velocity and acceleration, as rows: whole periods between two fades."""
    period = waves.shape[1]
    count = n_steady + 2 * n_fade + (1 if n_fade else 0)
    x, v, a = waves[:, (np.arange(count) - n_fade) % period]
    if not n_fade:
        return np.stack([x, v, a])
    # x w and its derivatives by the product rule: velocity and acceleration stay exact derivatives in the fades.
    w, slope, curvature = fade_envelope(count - 1, n_fade, sampling_period)
    return np.stack([w * x, w * v + slope * x, w * a + 2.0 * slope * v + curvature * x])


_RATES: Final = (
    ("speed", "m/s or rad/s"),
    ("acceleration", "m/s^2 or rad/s^2"),
    ("jerk", "m/s^3 or rad/s^3"),
)
_ROUNDING: Final = 1e-9  # share of a limit by which rounding may exceed it


@dataclass(frozen=True)
class Extremes:
    """Range and greatest magnitudes of a trajectory, SI."""

    lowest: float
    """Least position, m or rad."""
    highest: float
    """Greatest position, m or rad."""
    speed: float
    """Greatest magnitude of the first derivative."""
    acceleration: float
    """Greatest magnitude of the second derivative."""
    jerk: float
    """Greatest magnitude of the third derivative."""

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
