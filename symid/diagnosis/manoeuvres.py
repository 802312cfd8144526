"""Motions worth a trial as the next experiment, from rest to rest within travel, speed and acceleration."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import reduce

import numpy as np

from symid.arrays import FloatArray
from symid.errors import SettingError
from symid.simulation import Limits, MoveProfile, Trajectory, frequency_lines, multisine, trapezoids

_LOWEST_HZ, _STEP_HZ = 3.0, 1.0
_FADE = 0.5
_USED = 0.9
_SHAKEN = 0.5
"""Share of the speed of a move that a multisine on it may add, so that it never reverses."""
_SHAKING_ROOM = 0.2
"""Share of the stroke that a multisine may take."""
_HARDNESS = (0.25, 0.5, 0.75, 1.0)
_MOST_MOVES = 200


@dataclass(frozen=True)
class Room:
    """What a motion may use.

    Parameters
    ----------
    limits : Limits
        Travel, speed, acceleration and jerk.
    seconds : float
        Duration, about.
    highest_hz : float
        Highest frequency of a multisine.
    sampling_period : float
        s.
    unit : str
        Of the position.
    hardest : float
        Jerk that no motion may exceed; moves have that of the limits, a multisine has more.
    """

    limits: Limits
    seconds: float
    highest_hz: float
    sampling_period: float
    unit: str
    hardest: float = np.inf

    @property
    def stroke(self) -> float:
        """Length of the travel that is used."""
        return _USED * (self.limits.travel[1] - self.limits.travel[0])

    @property
    def begin(self) -> float:
        """Lower end of it."""
        return self.limits.travel[0] + (1 - _USED) / 2 * (self.limits.travel[1] - self.limits.travel[0])

    @property
    def centre(self) -> float:
        """Middle of the travel."""
        return float(np.mean(self.limits.travel))

    def gentler(self, share: float) -> Room:
        """The same with a share of the acceleration and the jerk."""
        less = replace(
            self.limits, acceleration=share * self.limits.acceleration, jerk=share * self.limits.jerk
        )
        return replace(self, limits=less)


def manoeuvres(room: Room) -> list[Trajectory]:
    """Motions within a room, each named after what it does; those that do not fit are left out.

    Examples
    --------
    >>> limits = Limits((0.0, 0.3), speed=0.5, acceleration=4.0, jerk=80.0)
    >>> found = manoeuvres(Room(limits, seconds=4.0, highest_hz=50.0, sampling_period=1e-3, unit="m"))
    >>> found[0].name
    'slow move over 0.27 m and back at 0.135 m/s'
    >>> all(np.ptp(motion.position) <= 0.3 for motion in found)
    True
    """
    found = []
    for make in _MANOEUVRES:
        try:
            found.append(make(room).checked(replace(room.limits, jerk=room.hardest)))
        except SettingError:
            continue
    return found


def _slow(room: Room) -> Trajectory:
    speed = min(2 * room.stroke / room.seconds, room.limits.speed)
    name = f"slow move over {room.stroke:.3g} {room.unit} and back at {speed:.3g} {room.unit}/s"
    return _shuttle(room, room.stroke, speed, room.seconds, name)


def _cycle(room: Room) -> Trajectory:
    speed = _USED * room.limits.speed
    name = f"one cycle over {room.stroke:.3g} {room.unit} and back at {speed:.3g} {room.unit}/s, repeated"
    return _shuttle(room, room.stroke, speed, room.seconds, name)


def _reversals(room: Room) -> Trajectory:
    speed = _USED * room.limits.speed
    way = min(1.2 * speed**2 / room.limits.acceleration, room.stroke)
    name = f"fast reversals: {way:.3g} {room.unit} to and fro at up to {speed:.3g} {room.unit}/s"
    return _shuttle(room, way, speed, room.seconds, name)


def _staircase(room: Room) -> Trajectory:
    speeds = _USED * room.limits.speed * np.geomspace(0.05, 1.0, 6)
    return _speeds(room, speeds, "staircase of speeds")


def _slow_staircase(room: Room) -> Trajectory:
    speeds = room.limits.speed * np.geomspace(0.005, 0.1, 6)
    return _speeds(room, speeds, "staircase of low speeds")


def _fast_staircase(room: Room) -> Trajectory:
    speeds = _USED * room.limits.speed * np.linspace(0.4, 1.0, 5)
    return _speeds(room, speeds, "staircase of high speeds")


def _speeds(room: Room, speeds: FloatArray, what: str) -> Trajectory:
    part = room.seconds / len(speeds)
    ways = [min(room.stroke, 0.5 * part * speed) for speed in speeds]
    name = f"{what}: {speeds[0]:.3g} to {speeds[-1]:.3g} {room.unit}/s in both directions"
    moves = (_shuttle(room, way, float(speed), part) for way, speed in zip(ways, speeds, strict=True))
    return _joined(moves, name)


def _accelerations(room: Room) -> Trajectory:
    moves, speed = [], _USED * room.limits.speed
    for share in _HARDNESS:
        own = room.gentler(share)
        way = min(1.2 * speed**2 / own.limits.acceleration, room.stroke)
        moves.append(_shuttle(own, way, speed, room.seconds / len(_HARDNESS)))
    top = room.limits.acceleration
    name = f"moves with accelerations of {_HARDNESS[0] * top:.3g} to {top:.3g} {room.unit}/s^2"
    return _joined(moves, name)


def _small_reversals(room: Room) -> Trajectory:
    ways = room.stroke * np.geomspace(2e-4, 2e-2, 5)
    part = room.seconds / len(ways)
    name = f"slow reversals over {ways[0]:.2g} to {ways[-1]:.2g} {room.unit}"
    return _joined((_shuttle(room, way, way / 0.4, part) for way in ways), name)


def _shaking(room: Room) -> Trajectory:
    shaking = _multisine(room, _USED * room.limits.speed, room.centre, room.seconds)
    return replace(shaking, name=f"multisine of {_LOWEST_HZ:g} to {room.highest_hz:.3g} Hz about one place")


def _shaken_move(room: Room) -> Trajectory:
    speed = min(_USED / (1 + _SHAKEN) * room.limits.speed, 4 * room.stroke / room.seconds)
    way = (1 - _SHAKING_ROOM) * room.stroke
    moves = _shuttle(room, way, speed, room.seconds).shifted(_SHAKING_ROOM / 2 * room.stroke)
    shaking = _multisine(room.gentler(_SHAKEN), _SHAKEN * speed, 0.0, moves.duration)
    n = max(moves.n_samples, shaking.n_samples)
    position, velocity, acceleration = (
        _lengthened(getattr(moves, kind), n) + _lengthened(getattr(shaking, kind), n)
        for kind in ("position", "velocity", "acceleration")
    )
    name = (
        f"multisine of {_LOWEST_HZ:g} to {room.highest_hz:.3g} Hz on moves over {way:.3g} {room.unit} and back "
        f"at {speed:.3g} {room.unit}/s"
    )
    return Trajectory(position, velocity, acceleration, room.sampling_period, name)


def _lengthened(values: FloatArray, n: int) -> FloatArray:
    """Continued at rest."""
    return np.pad(values, (0, n - values.size), mode="edge")


def _shuttle(room: Room, way: float, speed: float, seconds: float, name: str = "moves") -> Trajectory:
    """Moves to and fro from the lower end, as many as fill a time."""
    limits = room.limits
    profile = MoveProfile.fastest(way, speed, limits.acceleration, limits.jerk)
    pairs = int(np.clip(seconds // (2 * profile.duration), 1, _MOST_MOVES))
    moves = trapezoids(
        [way] * pairs,
        speed,
        acceleration=limits.acceleration,
        jerk=limits.jerk,
        sampling_period=room.sampling_period,
        start=room.begin,
    )
    return replace(moves, name=name)


def _joined(parts: Iterable[Trajectory], name: str) -> Trajectory:
    return replace(reduce(Trajectory.then, parts), name=name)


def _multisine(room: Room, speed: float, centre: float, seconds: float) -> Trajectory:
    """Lines of equal acceleration that repeat every second: at most the limit, a speed and a bit of the stroke."""
    lines = frequency_lines(_LOWEST_HZ, np.floor(room.highest_hz), _STEP_HZ)
    steady = max(np.floor(seconds) - 2 * _FADE, 1.0)

    def made(size: float) -> Trajectory:
        return multisine(
            lines,
            size,
            sampling_period=room.sampling_period,
            quantity="acceleration",
            seconds=steady,
            fade=_FADE,
            centre=centre,
        )

    trial = made(1.0).extremes
    room_about = 0.5 * _SHAKING_ROOM * room.stroke
    travel = max(trial.highest - centre, centre - trial.lowest)
    limits = (_USED * room.limits.acceleration / trial.acceleration, speed / trial.speed, room_about / travel)
    return made(min(limits))


_MANOEUVRES: tuple[Callable[[Room], Trajectory], ...] = (
    _slow,
    _cycle,
    _reversals,
    _staircase,
    _slow_staircase,
    _fast_staircase,
    _accelerations,
    _small_reversals,
    _shaking,
    _shaken_move,
)
