"""Jerk-limited moves from point to point, exact in time and place."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from symid.arrays import FloatArray
from symid.errors import SettingError
from symid.simulation.trajectories.limits import Extremes, Limits, checked_positive, intervals
from symid.simulation.trajectories.trajectory import Trajectory


@dataclass(frozen=True)
class MoveProfile:
    """The fastest move over a distance within limits, from rest to rest: seven segments of constant jerk."""

    distance: float
    """Length of the move, m or rad, positive."""
    speed: float
    """Speed that the move reaches; a short move reaches less than allowed."""
    acceleration: float
    """Acceleration that the move reaches, likewise."""
    jerk_time: float
    """Duration of each of the four segments with jerk, s; 0 if the jerk is not limited."""
    acceleration_time: float
    """Duration of each of the two segments with constant acceleration, s."""
    cruise_time: float
    """Duration of the segment with constant speed, s."""

    @classmethod
    def fastest(
        cls, distance: float, speed: float, acceleration: float, jerk: float = math.inf
    ) -> MoveProfile:
        """Profile of the shortest duration with at most the given speed, acceleration and jerk.

        Examples
        --------
        >>> MoveProfile.fastest(2.0, speed=1.0, acceleration=2.0, jerk=4.0).duration
        3.0
        >>> MoveProfile.fastest(0.25, speed=1.0, acceleration=2.0, jerk=4.0).speed
        0.3968502629920499
        """
        distance = checked_positive(distance, "distance of a move", "m or rad")
        speed = checked_positive(speed, "speed of a move", "m/s or rad/s")
        acceleration = checked_positive(acceleration, "acceleration of a move", "m/s^2 or rad/s^2")
        if not jerk > 0.0:
            raise SettingError(f"jerk of a move is {jerk:g} m/s^3 or rad/s^3: give a positive number")
        ramp = max(acceleration / jerk, 0.0)  # from no acceleration to the full one
        if speed >= acceleration * ramp:
            jerk_time, acceleration_time = ramp, speed / acceleration - ramp
        else:
            jerk_time, acceleration_time = math.sqrt(speed / jerk), 0.0
        cruise = distance / speed - (2.0 * jerk_time + acceleration_time)
        if cruise < 0.0:
            return cls._short(distance, acceleration, jerk)
        peak = speed / (jerk_time + acceleration_time)
        return cls(distance, speed, min(peak, acceleration), jerk_time, acceleration_time, cruise)

    @classmethod
    def _short(cls, distance: float, acceleration: float, jerk: float) -> MoveProfile:
        """Profile of a move too short to reach its speed."""
        ramp = acceleration / jerk
        gained = acceleration * ramp  # speed of a move that reaches the acceleration for an instant
        if distance >= 2.0 * gained * ramp:
            speed = 0.5 * (math.sqrt(gained * gained + 4.0 * acceleration * distance) - gained)
            return cls(distance, speed, acceleration, ramp, max(speed / acceleration - ramp, 0.0), 0.0)
        jerk_time = math.cbrt(0.5 * distance / jerk)
        return cls(distance, jerk * jerk_time**2, jerk * jerk_time, jerk_time, 0.0, 0.0)

    @property
    def duration(self) -> float:
        """Time from rest to rest, s."""
        return 2.0 * (2.0 * self.jerk_time + self.acceleration_time) + self.cruise_time

    @property
    def jerk(self) -> float:
        """Jerk of the segments that have any, m/s^3 or rad/s^3; infinite if the acceleration jumps."""
        return self.acceleration / self.jerk_time if self.jerk_time else math.inf

    def at(self, time: npt.ArrayLike) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Way covered, velocity and acceleration at given times since the start, s.

        The second half of the move mirrors the first, so the end is reached to the last digit.
        Without a jerk limit the acceleration at a jump is the value just after it, and 0 after the end.

        Examples
        --------
        >>> way, velocity, _ = MoveProfile.fastest(2.0, 1.0, 2.0, 4.0).at([0.0, 0.5, 1.5, 3.0])
        >>> way.tolist()[-1], velocity.tolist()
        (2.0, [0.0, 0.5, 1.0, 0.0])
        """
        t = np.clip(np.asarray(time, dtype=np.float64), 0.0, self.duration)
        late = t >= 0.5 * self.duration
        folded = np.where(late, self.duration - t, t)
        way, velocity, acceleration = self._first_half(folded, late)
        way = np.where(late, self.distance - way, way)
        acceleration = np.where(late, -acceleration, acceleration)
        return way, velocity, np.where(t >= self.duration, 0.0, acceleration)

    def _first_half(
        self, t: FloatArray, mirrored: npt.NDArray[np.bool_]
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Cubics of the first four segments, evaluated at times up to half of the duration.

        At a jump of the acceleration: the value just after it, or just before it in mirrored time.
        """
        ramp, steady, peak = self.jerk_time, self.acceleration_time, self.acceleration
        jerk = peak / ramp if ramp else 0.0
        begins = np.array([0.0, ramp, ramp + steady, 2.0 * ramp + steady])
        speeds = np.array([0.0, 0.5 * peak * ramp, peak * (0.5 * ramp + steady), self.speed])
        ways = np.array(
            [
                0.0,
                peak * ramp**2 / 6.0,
                peak * (ramp**2 / 6.0 + 0.5 * ramp * steady + 0.5 * steady**2),
                0.5 * self.speed * (2.0 * ramp + steady),
            ]
        )
        after, before = (np.searchsorted(begins, t, side=side) - 1 for side in ("right", "left"))
        segment = np.where(mirrored, np.maximum(before, 0), after)
        s = t - begins[segment]
        a = np.array([0.0, peak, peak, 0.0])[segment]
        j = np.array([jerk, 0.0, -jerk, 0.0])[segment]
        v = speeds[segment]
        way = ways[segment] + s * (v + s * (a / 2.0 + s * (j / 6.0)))
        return way, np.minimum(v + s * (a + s * (j / 2.0)), self.speed), a + s * j


def move(
    begin: float,
    end: float,
    *,
    speed: float,
    acceleration: float,
    jerk: float = math.inf,
    sampling_period: float,
    dwell: float = 0.0,
    limits: Limits | None = None,
) -> Trajectory:
    """The fastest move from one position to another, from rest to rest, and a dwell.

    Parameters
    ----------
    begin, end : float
        Positions, m or rad.
    speed, acceleration, jerk : float
        Limits of this move, SI; an infinite jerk gives a trapezoidal velocity.
    sampling_period : float
        Time between two samples, s.
    dwell : float
        Rest after the move, s; move and dwell together are rounded up to whole sampling periods.
    limits : Limits, optional
        Limits of the axis.

    Raises
    ------
    SettingError
        If a value is not possible or the move exceeds the limits of the axis.

    Examples
    --------
    >>> there = move(0.1, 2.1, speed=1.0, acceleration=2.0, jerk=4.0, sampling_period=0.5)
    >>> there.position.tolist()[-1], there.duration
    (2.1, 3.0)
    """
    profile = MoveProfile.fastest(abs(end - begin), speed, acceleration, jerk)
    name = f"move from {begin:g} to {end:g}"
    _check(name, limits, [profile], sorted((begin, end)))
    way, velocity, drive, _ = _sampled(profile, sampling_period, dwell)
    sign = math.copysign(1.0, end - begin)
    position = begin + sign * way
    position[way == profile.distance] = end
    return Trajectory(position, sign * velocity, sign * drive, sampling_period, name)


def trapezoids(
    distances: float | Sequence[float],
    speeds: float | Sequence[float],
    *,
    acceleration: float,
    jerk: float = math.inf,
    dwell: float = 0.0,
    sampling_period: float,
    start: float = 0.0,
    limits: Limits | None = None,
) -> Trajectory:
    """Moves there and back, at each speed over each distance, with a dwell after every move.

    Every move takes the shortest time that its limits allow, and begins at a sample: move and dwell together
    are rounded up to whole sampling periods. Moves too short to reach their speed or acceleration are exact too.

    Parameters
    ----------
    distances : float or sequence of float
        Lengths of the moves, m or rad; a negative one goes down first.
    speeds : float or sequence of float
        Speeds, m/s or rad/s.
    acceleration : float
        Greatest acceleration, m/s^2 or rad/s^2.
    jerk : float
        Greatest jerk, m/s^3 or rad/s^3; infinity gives trapezoidal velocities.
    dwell : float
        Rest after each move, s.
    sampling_period : float
        Time between two samples, s.
    start : float
        Position from which the moves go and to which they come back, m or rad.
    limits : Limits, optional
        Limits of the axis.

    Returns
    -------
    Trajectory
        From rest to rest at `start`.

    Raises
    ------
    SettingError
        If a value is not possible or a move exceeds the limits of the axis.

    Examples
    --------
    >>> there_and_back = trapezoids(
    ...     2.0, [1.0, 2.0], acceleration=2.0, jerk=4.0, dwell=0.5, sampling_period=0.01, start=0.1
    ... )
    >>> there_and_back.position.max().item(), there_and_back.position[-1].item(), there_and_back.duration
    (2.1, 0.1, 13.14)
    """
    ways = np.atleast_1d(np.asarray(distances, dtype=np.float64))
    rates = np.atleast_1d(np.asarray(speeds, dtype=np.float64))
    if ways.ndim > 1 or rates.ndim > 1 or not ways.size or not rates.size:
        raise SettingError(
            f"distances of shape {ways.shape} and speeds of shape {rates.shape} make no moves: give a number or "
            "a list of at least one for each"
        )
    order = [(float(speed), float(way)) for speed in rates for way in ways]
    profiles = [MoveProfile.fastest(abs(way), speed, acceleration, jerk) for speed, way in order]
    name = f"{2 * len(order)} moves at {', '.join(f'{speed:g}' for speed in rates)} m/s or rad/s"
    _check(name, limits, profiles, [start, *(start + way for _, way in order)])
    parts = []
    for profile, (_, way) in zip(profiles, order, strict=True):
        there, velocity, drive, back = _sampled(profile, sampling_period, dwell)
        sign = math.copysign(1.0, way)
        parts.append(sign * np.stack([there, velocity, drive])[:, :-1])
        parts.append(sign * np.stack([back, -velocity, -drive])[:, :-1])
    parts.append(np.zeros((3, 1)))
    position, velocity, drive = np.concatenate(parts, axis=1)
    return Trajectory(start + position, velocity, drive, sampling_period, name)


def _sampled(
    profile: MoveProfile, sampling_period: float, dwell: float
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Distance covered, velocity and acceleration of a move and its dwell, and the distance still to go."""
    intervals(dwell, sampling_period, "dwell")
    count = intervals(profile.duration, sampling_period, "move")
    whole = max(count, intervals(profile.duration + dwell, sampling_period, "move and dwell"))
    time = sampling_period * np.arange(whole + 1)
    time[count:] = profile.duration
    way, velocity, acceleration = profile.at(time)
    mirrored, _, _ = profile.at(profile.duration - time)
    return way, velocity, acceleration, mirrored


def _check(
    name: str, limits: Limits | None, profiles: Sequence[MoveProfile], positions: Sequence[float]
) -> None:
    if limits is not None:
        demand = Extremes(
            lowest=min(positions),
            highest=max(positions),
            speed=max(profile.speed for profile in profiles),
            acceleration=max(profile.acceleration for profile in profiles),
            jerk=max(profile.jerk for profile in profiles),
        )
        limits.check(name, demand, scaled=False)
