"""The commanded motion of an axis."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import partial
from typing import Any, Final, Self

import numpy as np

from symid.arrays import FloatArray, read_only
from symid.data import REFERENCE, Log
from symid.errors import SettingError
from symid.simulation.trajectories.limits import Extremes, Limits, checked_positive, intervals

_JOINT: Final = 1e-9  # share of the greatest value by which two trajectories may differ where they join


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Commanded motion of an axis, uniformly sampled, SI.

    Parameters
    ----------
    position : array of shape (n_samples,)
        Commanded position, m or rad. The record keeps read-only views and makes no copy.
    velocity : array of shape (n_samples,)
        Its derivative, m/s or rad/s.
    acceleration : array of shape (n_samples,)
        Its second derivative, m/s^2 or rad/s^2.
    sampling_period : float
        Time between two samples, s.
    name : str
        Name in messages and logs.
    start : float
        Time of the first sample, s.

    Raises
    ------
    SettingError
        If the arrays are not finite vectors of equal length, or the sampling period is not positive.

    Examples
    --------
    >>> ramp = Trajectory([0.0, 0.5, 1.0], [0.5] * 3, [0.0] * 3, sampling_period=1.0, name="ramp")
    >>> ramp.time.tolist(), ramp.duration, ramp.as_log()["reference"].tolist()
    ([0.0, 1.0, 2.0], 2.0, [0.0, 0.5, 1.0])
    """

    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    sampling_period: float
    name: str
    start: float = 0.0

    def __post_init__(self) -> None:
        checked_positive(self.sampling_period, f"{self.name}: sampling period", "s")
        for kind in ("position", "velocity", "acceleration"):
            values = read_only(np.asarray(getattr(self, kind), dtype=np.float64))
            if values.ndim != 1 or values.size == 0 or values.size != np.size(self.position):
                raise SettingError(
                    f"{self.name}: {kind} has shape {values.shape}: give vectors of one length for position, "
                    "velocity and acceleration"
                )
            if not np.isfinite(values).all():
                raise SettingError(f"{self.name}: {kind} has values that are not finite: give finite numbers")
            object.__setattr__(self, kind, values)

    def __reduce__(self) -> tuple[Any, ...]:
        # Unpickled arrays can be written to; building the record makes them read-only again.
        return (partial(type(self), **{item.name: getattr(self, item.name) for item in fields(self)}), ())

    @property
    def n_samples(self) -> int:
        """Number of samples of the trajectory."""
        return self.position.size

    @property
    def duration(self) -> float:
        """Time from the first to the last sample, s."""
        return (self.n_samples - 1) * self.sampling_period

    @property
    def time(self) -> FloatArray:
        """Time of each sample, s, shape (n_samples,), read-only."""
        return read_only(self.start + self.sampling_period * np.arange(self.n_samples, dtype=np.float64))

    @property
    def extremes(self) -> Extremes:
        """Range and greatest magnitudes at the samples; the jerk is the mean between two samples."""
        jumps = np.diff(self.acceleration)
        return Extremes(
            lowest=float(self.position.min()),
            highest=float(self.position.max()),
            speed=_greatest(self.velocity),
            acceleration=_greatest(self.acceleration),
            jerk=_greatest(jumps) / self.sampling_period if jumps.size else 0.0,
        )

    def checked(self, limits: Limits | None) -> Self:
        """The trajectory itself; SettingError with a remedy if a sample exceeds the limits."""
        if limits is not None:
            limits.check(self.name, self.extremes)
        return self

    def as_log(self) -> Log:
        """Log with the commanded position as its signal ``reference``."""
        return Log(
            source=self.name,
            start=self.start,
            sampling_period=self.sampling_period,
            signals={REFERENCE: self.position},
        )

    def shifted(self, by: float) -> Trajectory:
        """The trajectory with `by` (m or rad) added to each position."""
        return self.with_motion(position=self.position + by)

    def lasting(self, seconds: float) -> Trajectory:
        """The trajectory repeated without a pause, and cut to `seconds`; it must end where it begins.

        Examples
        --------
        >>> swing = Trajectory([0.0, 1.0, 0.0], [0.0] * 3, [0.0] * 3, sampling_period=0.5, name="swing")
        >>> swing.lasting(2.5).position.tolist()
        [0.0, 1.0, 0.0, 1.0, 0.0, 1.0]
        """
        self._check_joint(self)
        period = max(self.n_samples - 1, 1)
        place = np.arange(intervals(seconds, self.sampling_period, self.name) + 1) % period
        place[-1] = place[-1] or self.n_samples - 1  # the acceleration may jump where it begins again
        motion = {kind: getattr(self, kind)[place] for kind in ("position", "velocity", "acceleration")}
        return self.with_motion(**motion)

    def then(self, other: Trajectory) -> Trajectory:
        """The trajectory followed by `other`, whose first sample coincides with the last one here.

        Raises
        ------
        SettingError
            If the sampling periods differ, or position or velocity would jump where the two join.

        Examples
        --------
        >>> rest = Trajectory([0.0] * 3, [0.0] * 3, [0.0] * 3, sampling_period=0.5, name="rest")
        >>> rest.then(rest).duration
        2.0
        """
        if not math.isclose(self.sampling_period, other.sampling_period, rel_tol=1e-12):
            raise SettingError(
                f"{other.name} is sampled every {other.sampling_period:g} s and {self.name} every "
                f"{self.sampling_period:g} s: give both the same sampling period"
            )
        self._check_joint(other)
        return self.with_motion(
            position=np.concatenate([self.position, other.position[1:]]),
            velocity=np.concatenate([self.velocity, other.velocity[1:]]),
            acceleration=np.concatenate([self.acceleration[:-1], other.acceleration]),
            name=f"{self.name}, {other.name}",
        )

    def _check_joint(self, other: Trajectory) -> None:
        step = float(other.position[0] - self.position[-1])
        size = max(_greatest(self.position), _greatest(other.position))
        if abs(step) > _JOINT * size:
            raise SettingError(
                f"{other.name} begins at {other.position[0]:g} m or rad, where {self.name} ends at "
                f"{self.position[-1]:g}: shift it by {-step:g}, or move there first"
            )
        jump = float(other.velocity[0] - self.velocity[-1])
        if abs(jump) > _JOINT * max(_greatest(self.velocity), _greatest(other.velocity)):
            raise SettingError(
                f"{other.name} begins with a velocity of {other.velocity[0]:g} m/s or rad/s, where {self.name} "
                f"ends with {self.velocity[-1]:g}: join trajectories at rest, or fade them in and out"
            )

    def with_motion(self, **changed: Any) -> Trajectory:
        """A plain trajectory with changed fields."""
        names = [item.name for item in fields(Trajectory)]
        return Trajectory(**{name: getattr(self, name) for name in names} | changed)


def _greatest(values: FloatArray) -> float:
    return float(max(values.max(), -values.min()))
