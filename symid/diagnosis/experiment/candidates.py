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
class Envelope:
    """Limits of a motion."""

    limits: Limits  # travel, speed, acceleration and jerk
    seconds: float  # duration, about
    highest_hz: float  # highest frequency of a multisine
    sampling_period: float  # s
    unit: str  # of the position
    # jerk that no motion may exceed; moves have that of the limits, a multisine has more
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

    def gentler(self, share: float) -> Envelope:
        """The same with a share of the acceleration and the jerk."""
        less = replace(
            self.limits, acceleration=share * self.limits.acceleration, jerk=share * self.limits.jerk
        )
        return replace(self, limits=less)


def candidate_motions(envelope: Envelope) -> list[Trajectory]:
    """Motions within a envelope, each named after what it does; those that do not fit are left out.

    >>> limits = Limits((0.0, 0.3), speed=0.5, acceleration=4.0, jerk=80.0)
    >>> found = candidate_motions(Envelope(limits, seconds=4.0, highest_hz=50.0, sampling_period=1e-3, unit="m"))
    >>> found[0].name
    'slow move over 0.27 m and back at 0.135 m/s'
    >>> all(np.ptp(motion.position) <= 0.3 for motion in found)
    True
    """
    found = []
    for make in _MANOEUVRES:
        try:
            found.append(make(envelope).checked(replace(envelope.limits, jerk=envelope.hardest)))
        except SettingError:
            continue
    return found


def _slow(envelope: Envelope) -> Trajectory:
    speed = min(2 * envelope.stroke / envelope.seconds, envelope.limits.speed)
    name = f"slow move over {envelope.stroke:.3g} {envelope.unit} and back at {speed:.3g} {envelope.unit}/s"
    return _shuttle(envelope, envelope.stroke, speed, envelope.seconds, name)


def _cycle(envelope: Envelope) -> Trajectory:
    speed = _USED * envelope.limits.speed
    name = f"one cycle over {envelope.stroke:.3g} {envelope.unit} and back at {speed:.3g} {envelope.unit}/s, repeated"
    return _shuttle(envelope, envelope.stroke, speed, envelope.seconds, name)


def _reversals(envelope: Envelope) -> Trajectory:
    speed = _USED * envelope.limits.speed
    way = min(1.2 * speed**2 / envelope.limits.acceleration, envelope.stroke)
    name = f"fast reversals: {way:.3g} {envelope.unit} to and fro at up to {speed:.3g} {envelope.unit}/s"
    return _shuttle(envelope, way, speed, envelope.seconds, name)


def _staircase(envelope: Envelope) -> Trajectory:
    speeds = _USED * envelope.limits.speed * np.geomspace(0.05, 1.0, 6)
    return _speeds(envelope, speeds, "staircase of speeds")


def _slow_staircase(envelope: Envelope) -> Trajectory:
    speeds = envelope.limits.speed * np.geomspace(0.005, 0.1, 6)
    return _speeds(envelope, speeds, "staircase of low speeds")


def _fast_staircase(envelope: Envelope) -> Trajectory:
    speeds = _USED * envelope.limits.speed * np.linspace(0.4, 1.0, 5)
    return _speeds(envelope, speeds, "staircase of high speeds")


def _speeds(envelope: Envelope, speeds: FloatArray, what: str) -> Trajectory:
    part = envelope.seconds / len(speeds)
    ways = [min(envelope.stroke, 0.5 * part * speed) for speed in speeds]
    name = f"{what}: {speeds[0]:.3g} to {speeds[-1]:.3g} {envelope.unit}/s in both directions"
    moves = (_shuttle(envelope, way, float(speed), part) for way, speed in zip(ways, speeds, strict=True))
    return _joined(moves, name)


def _accelerations(envelope: Envelope) -> Trajectory:
    moves, speed = [], _USED * envelope.limits.speed
    for share in _HARDNESS:
        own = envelope.gentler(share)
        way = min(1.2 * speed**2 / own.limits.acceleration, envelope.stroke)
        moves.append(_shuttle(own, way, speed, envelope.seconds / len(_HARDNESS)))
    top = envelope.limits.acceleration
    name = f"moves with accelerations of {_HARDNESS[0] * top:.3g} to {top:.3g} {envelope.unit}/s^2"
    return _joined(moves, name)


def _small_reversals(envelope: Envelope) -> Trajectory:
    ways = envelope.stroke * np.geomspace(2e-4, 2e-2, 5)
    part = envelope.seconds / len(ways)
    name = f"slow reversals over {ways[0]:.2g} to {ways[-1]:.2g} {envelope.unit}"
    return _joined((_shuttle(envelope, way, way / 0.4, part) for way in ways), name)


def _shaking(envelope: Envelope) -> Trajectory:
    shaking = _multisine(envelope, _USED * envelope.limits.speed, envelope.centre, envelope.seconds)
    return replace(
        shaking, name=f"multisine of {_LOWEST_HZ:g} to {envelope.highest_hz:.3g} Hz about one place"
    )


def _shaken_move(envelope: Envelope) -> Trajectory:
    speed = min(_USED / (1 + _SHAKEN) * envelope.limits.speed, 4 * envelope.stroke / envelope.seconds)
    way = (1 - _SHAKING_ROOM) * envelope.stroke
    moves = _shuttle(envelope, way, speed, envelope.seconds).shifted(_SHAKING_ROOM / 2 * envelope.stroke)
    shaking = _multisine(envelope.gentler(_SHAKEN), _SHAKEN * speed, 0.0, moves.duration)
    n = max(moves.n_samples, shaking.n_samples)
    position, velocity, acceleration = (
        _lengthened(getattr(moves, kind), n) + _lengthened(getattr(shaking, kind), n)
        for kind in ("position", "velocity", "acceleration")
    )
    name = (
        f"multisine of {_LOWEST_HZ:g} to {envelope.highest_hz:.3g} Hz on moves over {way:.3g} {envelope.unit} and back "
        f"at {speed:.3g} {envelope.unit}/s"
    )
    return Trajectory(position, velocity, acceleration, envelope.sampling_period, name)


def _lengthened(values: FloatArray, n: int) -> FloatArray:
    """Continued at rest."""
    return np.pad(values, (0, n - values.size), mode="edge")


def _shuttle(envelope: Envelope, way: float, speed: float, seconds: float, name: str = "moves") -> Trajectory:
    """Moves to and fro from the lower end, as many as fill a time."""
    limits = envelope.limits
    profile = MoveProfile.fastest(way, speed, limits.acceleration, limits.jerk)
    pairs = int(np.clip(seconds // (2 * profile.duration), 1, _MOST_MOVES))
    moves = trapezoids(
        [way] * pairs,
        speed,
        acceleration=limits.acceleration,
        jerk=limits.jerk,
        sampling_period=envelope.sampling_period,
        start=envelope.begin,
    )
    return replace(moves, name=name)


def _joined(parts: Iterable[Trajectory], name: str) -> Trajectory:
    return replace(reduce(Trajectory.then, parts), name=name)


def _multisine(envelope: Envelope, speed: float, centre: float, seconds: float) -> Trajectory:
    """Lines of equal acceleration that repeat every second: at most the limit, a speed and a bit of the stroke."""
    lines = frequency_lines(_LOWEST_HZ, np.floor(envelope.highest_hz), _STEP_HZ)
    steady = max(np.floor(seconds) - 2 * _FADE, 1.0)

    def made(size: float) -> Trajectory:
        return multisine(
            lines,
            size,
            sampling_period=envelope.sampling_period,
            quantity="acceleration",
            seconds=steady,
            fade=_FADE,
            centre=centre,
        )

    trial = made(1.0).extremes
    room_about = 0.5 * _SHAKING_ROOM * envelope.stroke
    travel = max(trial.highest - centre, centre - trial.lowest)
    limits = (
        _USED * envelope.limits.acceleration / trial.acceleration,
        speed / trial.speed,
        room_about / travel,
    )
    return made(min(limits))


_MANOEUVRES: tuple[Callable[[Envelope], Trajectory], ...] = (
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
