"""Candidate references: moves, chirps and multisines of one duration, each as large as the limits allow."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import product
from typing import Literal

import numpy as np

from symid.arrays import FloatArray
from symid.errors import SettingError
from symid.simulation import Limits, Trajectory, chirp, trapezoids, whole_periods
from symid.simulation.trajectories import MotionQuantity

DEFAULTS = ("default trapezoids", "default chirp")
"""Names of the references that `symid simulate` uses within the same limits."""
_USED = 0.95  # share of a limit that a reference uses; the rest is for overshoot
_BAND = (0.5, 20.0)  # Hz: the default of `symid simulate`
_BEYOND_MODES = 1.25  # times the highest mode, up to which a motion excites
_DWELL = 0.2  # s
_WAYS = (1.0, 0.3, 0.1, 0.03)  # lengths of moves, relative to the stroke
_SPEEDS = ((1.0,), (0.05, 0.3, 1.0))  # of the moves of one motion, relative to the largest
_JERK_TIME = 0.01  # s, in which the acceleration builds up if the jerk is not limited
_LINES = 21  # of a multisine
_PARTS = (0.2, 0.5)  # of the limits, for a multisine on top of moves
_CONSTANT: tuple[MotionQuantity, ...] = ("velocity", "acceleration")
_SWEEP: Literal["logarithmic"] = "logarithmic"
_Maker = Callable[[float], Trajectory]


def references(
    limits: Limits, seconds: float, rate: float, highest_mode: float, seeds: int = 2
) -> list[Trajectory]:
    """References from rest to rest, the two defaults first.

    Parameters
    ----------
    limits : Limits
        Length of the travel, speed, acceleration and jerk. References start at 0.
    seconds : float
        Duration of each reference; after its moves, the axis rests.
    rate : float
        Sampling rate, Hz.
    highest_mode : float
        Highest natural frequency of the axis, Hz; 0 if it has none.
    seeds : int
        Number of multisines with random phases for each band.

    Examples
    --------
    >>> found = references(Limits((-0.2, 0.2), 1.0, 8.0, 500.0), 4.0, 1000.0, 0.0)
    >>> found[0].name, found[1].name, {round(one.duration, 6) for one in found}
    ('default trapezoids', 'default chirp', {4.0})
    >>> max(float(np.ptp(one.position)) for one in found) <= 0.4
    True
    """
    whole, half = _vibrations(limits, rate, seconds, highest_mode, seeds), seconds / 2
    moves = list(_moves(limits, rate, half))
    halves = _vibrations(limits, rate, half, highest_mode, 0)
    found = [_default_moves(limits, rate, seconds), replace(next(whole), name=DEFAULTS[1])]
    found += [*_moves(limits, rate, seconds), *whole]
    for one, other in product(moves[1::2], halves):
        name = f"{one.name}, then {other.name}"
        found.append(replace(one.then(other), name=name))
    found += _superposed(limits, rate, seconds, highest_mode)
    count = round(seconds * rate) + 1
    return [_lasting(one, count) for one in found]


def references_apart(
    limits: Limits, apart: float, drives: int, seconds: float, rate: float, highest_mode: float
) -> list[tuple[Trajectory, ...]]:
    """References of several drives that differ by at most `apart`: common moves plus a separate multisine for each.

    >>> found = references_apart(Limits((-0.2, 0.2), 1.0, 8.0, 500.0), 1e-3, 2, 4.0, 1000.0, 0.0)
    >>> bool(max(np.abs(a.position - b.position).max() for a, b in found) <= 1e-3)
    True
    """
    half = replace(_part(limits, 0.5), travel=(-apart / 4, apart / 4))
    count, found = round(seconds * rate) + 1, []
    bands = [(max(0.2, 2 / seconds), top) for top in sorted({_BAND[1], _BEYOND_MODES * highest_mode}) if top]
    for band, (i, move) in product(bands, enumerate(_moves(limits, rate, seconds))):
        waves = [_largest(half, partial(_multisine, band, seconds, rate, seed)) for seed in range(drives)]
        base, name = _lasting(scaled(move, 0.5), count), f"{move.name}, halved ({i})"
        name = f"{name}, with a multisine for each drive up to {band[1]:.3g} Hz"
        moved = [_changed(np.add, base, _lasting(wave, count)) for wave in waves]
        found.append(tuple(replace(one, name=name) for one in moved))
    return found


def scaled(trajectory: Trajectory, share: float) -> Trajectory:
    """The motion multiplied by a factor."""
    return _changed(lambda part: share * part, trajectory)


def _changed(change: Callable[..., FloatArray], motion: Trajectory, *others: Trajectory) -> Trajectory:
    """A motion whose position, velocity and acceleration are a function of those of the given motions."""
    names = ("position", "velocity", "acceleration")
    parts = {name: change(*(getattr(one, name) for one in (motion, *others))) for name in names}
    return motion.with_motion(**parts)


def _default_moves(limits: Limits, rate: float, seconds: float) -> Trajectory:
    """Trapezoids of `symid simulate`, shortened until they fit into the duration."""
    way, speeds = _stroke(limits), [limits.speed / 5, limits.speed / 2, limits.speed]
    made = _trapezoids(limits, rate, way, speeds, _DWELL)
    while made.duration > seconds:
        way /= 1.2
        made = _trapezoids(limits, rate, way, speeds, _DWELL)
        if way * rate < limits.speed * 1e-3:
            raise SettingError(f"{seconds:g} s are too short for moves there and back: give more time")
    return replace(made, name=DEFAULTS[0])


def _moves(
    limits: Limits, rate: float, seconds: float, kinds: tuple[tuple[float, ...], ...] = _SPEEDS
) -> Iterator[Trajectory]:
    """Moves of several lengths at one or three speeds, repeated as often as they fit."""
    for share, speeds in product(_WAYS, kinds):
        way = share * _stroke(limits)
        top = _USED * min(limits.speed, float(np.sqrt(way * limits.acceleration)))
        once = _trapezoids(limits, rate, way, [part * top for part in speeds], 0.0)
        times = int(seconds // once.duration)
        if times:
            repeated = once.lasting(times * once.duration)
            kind = "one speed" if len(speeds) == 1 else f"{len(speeds)} speeds"
            length = "the longest moves" if share == 1.0 else f"moves over {share:.0%} of the longest"
            yield replace(repeated, name=f"{length} at {kind}")


def _superposed(limits: Limits, rate: float, seconds: float, highest_mode: float) -> Iterator[Trajectory]:
    """Moves at one speed with a multisine on top; each uses its part of the limits."""
    low = max(0.2, 2 / seconds)
    for part, high in product(_PARTS, sorted({_BAND[1], _BEYOND_MODES * highest_mode} - {0.0})):
        small, large = _part(limits, part), _part(limits, 1.0 - part)
        wave = _largest(small, partial(_multisine, (low, high), seconds, rate, 0))
        for move in _moves(large, rate, seconds, _SPEEDS[:1]):
            name = f"{move.name}, with a multisine of {part:.0%} up to {high:.3g} Hz"
            yield replace(_changed(np.add, _lasting(move, wave.n_samples), wave), name=name)


def _part(limits: Limits, part: float) -> Limits:
    """The limits multiplied by a factor."""
    low, high = limits.travel
    return Limits(
        (part * low, part * high), part * limits.speed, part * limits.acceleration, part * limits.jerk
    )


def _trapezoids(limits: Limits, rate: float, way: float, speeds: list[float], dwell: float) -> Trajectory:
    jerk = limits.jerk if np.isfinite(limits.jerk) else limits.acceleration / _JERK_TIME
    return trapezoids(
        way,
        speeds,
        acceleration=_USED * limits.acceleration,
        jerk=_USED * jerk,
        dwell=dwell,
        sampling_period=1.0 / rate,
    )


def _vibrations(
    limits: Limits, rate: float, seconds: float, highest_mode: float, seeds: int
) -> Iterator[Trajectory]:
    """Chirps, the default of `symid simulate` first, and multisines."""
    top = max(_BAND[1], _BEYOND_MODES * highest_mode)
    tops = sorted({_BAND[1], 5.0, top})
    bands = [(max(0.2, 2 / seconds), high) for high in tops]
    for (low, high), quantity in product(dict.fromkeys([_BAND, *bands]), _CONSTANT):
        made = partial(chirp, low, high, seconds, sampling_period=1 / rate, quantity=quantity, sweep=_SWEEP)
        name = f"chirp of constant {quantity}, {low:g} to {high:.3g} Hz"
        yield replace(_largest(limits, made), name=name)
    for (low, high), seed in product(bands, [None, *range(seeds)]):
        phases = "Schroeder's phases" if seed is None else f"phases of seed {seed}"
        waves = _largest(limits, partial(_multisine, (low, high), seconds, rate, seed))
        yield replace(waves, name=f"multisine, {low:g} to {high:.3g} Hz, {phases}")


def _multisine(
    band: tuple[float, float], seconds: float, rate: float, seed: int | None, size: float
) -> Trajectory:
    """Lines of equal velocity, spaced logarithmically."""
    rng = None if seed is None else np.random.default_rng(seed)
    return whole_periods(np.geomspace(*band, _LINES), size, seconds, rate, rng=rng)


def _largest(limits: Limits, made: _Maker) -> Trajectory:
    """The motion scaled to use its share of the tightest limit."""
    motion = made(1.0)
    trial = motion.extremes
    reached = (trial.highest - trial.lowest, trial.speed, trial.acceleration, trial.jerk)
    allowed = (_stroke(limits) / _USED, limits.speed, limits.acceleration, limits.jerk)
    return scaled(motion, _USED * min(a / r for a, r in zip(allowed, reached, strict=True)))


def _stroke(limits: Limits) -> float:
    return _USED * (limits.travel[1] - limits.travel[0])


def _lasting(motion: Trajectory, count: int) -> Trajectory:
    """The trajectory extended by rest, or cut, to a number of samples."""
    still = np.zeros(max(count - motion.n_samples, 0))
    return motion.with_motion(
        position=np.append(motion.position, still + motion.position[-1])[:count],
        velocity=np.append(motion.velocity, still)[:count],
        acceleration=np.append(motion.acceleration, still)[:count],
    )
