"""Candidate motions for the next experiment, from rest to rest within travel, speed and acceleration."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import partial, reduce

import numpy as np

from symid.arrays import FloatArray
from symid.errors import SettingError
from symid.simulation import Limits, MoveProfile, Trajectory, frequency_lines, multisine, trapezoids

_LOWEST_HZ, _STEP_HZ = 3.0, 1.0
_FADE = 0.5
_USED = 0.9  # share of a limit that a motion uses
_ADDED_SPEED = 0.5
"""Speed of a multisine relative to that of the move it is added to, which then never reverses."""
_MULTISINE_STROKE = 0.2  # share of the stroke that a multisine may take
_ACCELERATIONS = (0.25, 0.5, 0.75, 1.0)  # of the moves that differ by acceleration, as shares of the largest
_STAIRCASES = (
    ("staircase of speeds", _USED, np.geomspace(0.05, 1.0, 6)),
    ("staircase of low speeds", 1.0, np.geomspace(0.005, 0.1, 6)),
    ("staircase of high speeds", _USED, np.linspace(0.4, 1.0, 5)),
)
_MOST_MOVES = 200  # there and back in one motion


@dataclass(frozen=True)
class Envelope:
    """Limits that candidate motions stay within: travel, speed, acceleration, jerk and band."""

    limits: Limits  # travel, speed, acceleration and jerk
    seconds: float  # approximate duration
    highest_hz: float  # highest frequency of a multisine
    sampling_period: float  # s
    unit: str  # of the position
    hardest: float = np.inf  # jerk that no motion may exceed; that of the limits applies to moves only

    @property
    def stroke(self) -> float:
        """Length of the travel that is used."""
        return _USED * (self.limits.travel[1] - self.limits.travel[0])

    @property
    def begin(self) -> float:
        """Lower end of the travel that is used."""
        return self.limits.travel[0] + (1 - _USED) / 2 * (self.limits.travel[1] - self.limits.travel[0])

    @property
    def centre(self) -> float:
        """Middle of the travel, m or rad."""
        return float(np.mean(self.limits.travel))

    def gentler(self, share: float) -> Envelope:
        """The same envelope with a share of the acceleration and the jerk."""
        less = replace(
            self.limits, acceleration=share * self.limits.acceleration, jerk=share * self.limits.jerk
        )
        return replace(self, limits=less)


def candidate_motions(envelope: Envelope) -> list[Trajectory]:
    """Motions within an envelope, with descriptive names; those that do not fit are left out.

    >>> limits = Limits((0.0, 0.3), speed=0.5, acceleration=4.0, jerk=80.0)
    >>> found = candidate_motions(Envelope(limits, seconds=4.0, highest_hz=50.0, sampling_period=1e-3, unit="m"))
    >>> found[0].name
    'slow move over 0.27 m and back at 0.135 m/s'
    >>> all(np.ptp(motion.position) <= 0.3 for motion in found)
    True
    """
    found = []
    for make in _MOTIONS:
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
    name = f"fast reversals: {way:.3g} {envelope.unit} back and forth at up to {speed:.3g} {envelope.unit}/s"
    return _shuttle(envelope, way, speed, envelope.seconds, name)


def _staircase(what: str, share: float, steps: FloatArray, envelope: Envelope) -> Trajectory:
    speeds = share * envelope.limits.speed * steps
    part = envelope.seconds / len(speeds)
    ways = [min(envelope.stroke, 0.5 * part * speed) for speed in speeds]
    name = f"{what}: {speeds[0]:.3g} to {speeds[-1]:.3g} {envelope.unit}/s in both directions"
    moves = (_shuttle(envelope, way, float(speed), part) for way, speed in zip(ways, speeds, strict=True))
    return _joined(moves, name)


def _accelerations(envelope: Envelope) -> Trajectory:
    moves, speed = [], _USED * envelope.limits.speed
    for share in _ACCELERATIONS:
        own = envelope.gentler(share)
        way = min(1.2 * speed**2 / own.limits.acceleration, envelope.stroke)
        moves.append(_shuttle(own, way, speed, envelope.seconds / len(_ACCELERATIONS)))
    top = envelope.limits.acceleration
    name = f"moves with accelerations of {_ACCELERATIONS[0] * top:.3g} to {top:.3g} {envelope.unit}/s^2"
    return _joined(moves, name)


def _small_reversals(envelope: Envelope) -> Trajectory:
    ways = envelope.stroke * np.geomspace(2e-4, 2e-2, 5)
    part = envelope.seconds / len(ways)
    name = f"slow reversals over {ways[0]:.2g} to {ways[-1]:.2g} {envelope.unit}"
    return _joined((_shuttle(envelope, way, way / 0.4, part) for way in ways), name)


def _multisine_at_centre(envelope: Envelope) -> Trajectory:
    wave = _multisine(envelope, _USED * envelope.limits.speed, envelope.centre, envelope.seconds)
    return replace(wave, name=f"multisine of {_LOWEST_HZ:g} to {envelope.highest_hz:.3g} Hz about one place")


def _multisine_on_moves(envelope: Envelope) -> Trajectory:
    speed = min(_USED / (1 + _ADDED_SPEED) * envelope.limits.speed, 4 * envelope.stroke / envelope.seconds)
    way = (1 - _MULTISINE_STROKE) * envelope.stroke
    moves = _shuttle(envelope, way, speed, envelope.seconds).shifted(_MULTISINE_STROKE / 2 * envelope.stroke)
    wave = _multisine(envelope.gentler(_ADDED_SPEED), _ADDED_SPEED * speed, 0.0, moves.duration)
    n = max(moves.n_samples, wave.n_samples)

    def sum_of(kind: str) -> FloatArray:
        parts = (getattr(moves, kind), getattr(wave, kind))
        first, second = (np.pad(part, (0, n - part.size), mode="edge") for part in parts)  # then at rest
        return np.asarray(first + second)

    name = (
        f"multisine of {_LOWEST_HZ:g} to {envelope.highest_hz:.3g} Hz on moves over {way:.3g} {envelope.unit} and back "
        f"at {speed:.3g} {envelope.unit}/s"
    )
    kinds = (sum_of("position"), sum_of("velocity"), sum_of("acceleration"))
    return Trajectory(*kinds, envelope.sampling_period, name)


def _shuttle(envelope: Envelope, way: float, speed: float, seconds: float, name: str = "moves") -> Trajectory:
    """Moves there and back from the lower end, repeated for a duration."""
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
    """Lines of equal acceleration with a period of one second, within acceleration, speed and a share of the stroke."""
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
    allowed = 0.5 * _MULTISINE_STROKE * envelope.stroke
    travel = max(trial.highest - centre, centre - trial.lowest)
    acceleration = _USED * envelope.limits.acceleration / trial.acceleration
    return made(min(acceleration, speed / trial.speed, allowed / travel))


_MOTIONS: tuple[Callable[[Envelope], Trajectory], ...] = (
    *(_slow, _cycle, _reversals),
    *(partial(_staircase, *staircase) for staircase in _STAIRCASES),
    *(_accelerations, _small_reversals, _multisine_at_centre, _multisine_on_moves),
)
