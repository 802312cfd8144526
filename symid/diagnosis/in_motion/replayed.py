"""Simulation of an axis along a log, with the measured force and the controller of the machine.

If the machine moved as the simulated axis does, its controller would send

    F = F measured + C (q measured - q simulated),

where C is its law from position to force. The measured force already contains the response to the reference, to
feed-forwards and to external signals, so that only C must be known: this is the closed loop along the log's reference.
If the log does not determine C, an observer, which is a slow cascade, keeps the simulated axis near the measured
motion.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np
import scipy

from symid.arrays import BoolArray, FloatArray
from symid.data import REFERENCE, Log
from symid.diagnosis.in_motion.declared import ExplainedAxis
from symid.diagnosis.prediction.corners import SLOW, near_reversals
from symid.diagnosis.prediction.joined_logs import JoinedLogs
from symid.diagnosis.prediction.record import Record
from symid.errors import SettingError
from symid.instrumental import cascade_of_log
from symid.signal_processing import LowPass, derivatives
from symid.simulation import Cascade, Plant, Replay, Trajectory, plant_of, simulate, without_noise
from symid.simulation.plants import JUST_MOVING, misreading

_LEAST_RATE = 1000.0
"""Least rate of the simulated controller, Hz."""
_OBSERVER_HZ = 2.0
"""Least bandwidth of the observer: it moves a free mass to the measured position with two poles at half of it."""
_HOLDS = 2.0
"""Stiffness of the observer relative to the largest negative one of the axis, such as that of a pendulum upright."""
_PLACES, _NEAR = 200, 0.05
"""Positions at which that is sought, and their distance relative to the range: the slope is the mean over it."""
_EXPLAINED = 0.9
"""Least share of the force's variance that a cascade read from a log must explain to count as its controller."""
_AT_REST = 0.01
"""Initial speed, relative to the highest, below which the axis starts at rest."""
_SWING = 0.01  # states of hidden bodies whose response is found, relative to range and speed of the position
_ENDS = 8
_HIGHEST = 0.4
"""Highest cutoff of differentiated signals, relative to the sampling frequency."""
_STIFFEST = 50.0
"""Highest eigenfrequency of a simulated axis, in rad per sample: a stiffer one would take thousands of steps."""


@dataclass(frozen=True, eq=False)
class Part:
    """A log with the samples that count, as one drive sees it."""

    log: Log  # one log
    used: BoolArray  # shape (n_samples,): samples that took no part in any choice
    record: Record  # the record that contains the log
    drive: int = 0  # index of the drive

    @property
    def signal(self) -> str:
        """The position next to the drive."""
        return self.record.driven[self.drive]

    @property
    def force(self) -> str:
        return self.record.forces[self.drive]

    @property
    def reference_column(self) -> str:
        """Column of the drive's own reference, or of the common one."""
        own = f"{REFERENCE}_{self.force}"
        return own if own in self.log.signals else REFERENCE

    @property
    def has_reference(self) -> bool:
        return self.reference_column in self.log.signals

    @property
    def reference(self) -> FloatArray:
        return self.log[self.reference_column]

    @property
    def position(self) -> FloatArray:
        return self.log[self.signal]

    def low_passed(self, values: FloatArray) -> FloatArray:
        return LowPass(_cutoff(self.record)).by_spectrum(values, self.log.sampling_frequency)

    def speed_of(self, position: FloatArray) -> FloatArray:
        """Derivative of a position in the band of the motion."""
        return derivatives(self.low_passed(position), self.log.sampling_period, 1)[0]

    @cached_property
    def speed(self) -> FloatArray:
        return self.speed_of(self.position)

    @cached_property
    def near_reversal(self) -> BoolArray:
        """Samples near a moment at which the axis stops, starts or reverses."""
        course = self.speed_of(self.reference) if self.has_reference else self.speed
        direction = np.where(np.abs(course) < SLOW * np.abs(course).max(), 0.0, np.sign(course))
        return near_reversals(np.diff(direction, prepend=direction[0]) != 0, self.log.sampling_frequency)

    @cached_property
    def factor(self) -> int:
        """Samples of the simulated controller for each of the log."""
        return max(1, math.ceil(_LEAST_RATE * self.log.sampling_period - 1e-9))

    @cached_property
    def path(self) -> Trajectory:
        """The measured position as the reference of a cascade, differentiated as the cascade does."""
        n, period = self.log.n_samples, self.log.sampling_period / self.factor
        position = self.position
        if self.factor > 1:
            places = np.arange((n - 1) * self.factor + 1) / self.factor
            position = scipy.interpolate.CubicSpline(np.arange(n), position)(places)
        speed = np.diff(position, prepend=position[0]) / period
        return Trajectory(position, speed, np.zeros_like(speed), period, f"position of {self.log.source}")

    @cached_property
    def forces(self) -> FloatArray:
        """Drive force that acted, on average, from each sample of the simulated controller to the next."""
        acted = self.path.time + self.path.sampling_period / 2 + self.record.time_late(self.force)
        return np.asarray(np.interp(acted, since_begin(self.log), self.log[self.force]))

    @property
    def start(self) -> tuple[float, float]:
        """Position and velocity at the first sample; a very small velocity counts as 0."""
        slope, value = np.polyfit(np.arange(_ENDS), self.position[:_ENDS], 1)
        speed = float(slope) / self.log.sampling_period
        return float(value), speed if abs(speed) > _AT_REST * np.abs(self.speed).max() else 0.0


@dataclass(frozen=True, eq=False)
class Driver:
    """Force that moves the simulated axis in addition to the measured one."""

    kind: Literal["given", "identified", "observer"]  # "given", "identified" or "observer"
    cascade: Cascade  # its gains
    share: float  # share of the force's variance that it explains; nan for an observer


def _cutoff(record: Record) -> float:
    return min(record.motion_hz, _HIGHEST * record.log.sampling_frequency)


def parts_of(record: Record, run: JoinedLogs, allowed: BoolArray | None) -> Iterator[Part]:
    """The logs of a run with the samples that count."""
    at = np.rint(record.log.sampling_period * np.arange(record.log.n_samples) / record.fine_time[1]).astype(
        int
    )
    counted = np.ones(at.size, dtype=bool) if allowed is None else allowed[np.minimum(at, allowed.size - 1)]
    begins = np.flatnonzero(np.diff(run.recorded.astype(np.int8), prepend=0) == 1)
    for begin, log in zip(begins, run.parts, strict=True):
        used = counted[begin : begin + log.n_samples]
        if used.any():
            yield Part(log, used, record)


def falling_stiffness(explained: ExplainedAxis, part: Part) -> float:
    """Largest negative stiffness of the laws of an axis along a log, as its drive feels it; 0 if there is none."""
    plant, position = plant_of(explained.axis, explained.values), part.position
    q, step = np.linspace(position.min(), position.max(), _PLACES), _NEAR * float(np.ptp(position))
    moved = plant.follows({part.signal: (0.0, 1.0)})[len(plant.bodies) :]
    slope, v = np.zeros(q.size), np.full(q.size, JUST_MOVING)
    for law in plant.laws:
        share = float(law.direction @ moved)
        of_motion = replace(law, terms=tuple(term for term in law.terms if term.memory < 0))
        slope += share * (of_motion.force(share * (q + step), v) - of_motion.force(share * q, v)) / step
    return max(-float(slope.min()), 0.0)


def driver_of(
    record: Record, parts: Sequence[Part], given: Cascade | None, inertia: float, falling: float = 0.0
) -> Driver:
    """The controller given, or read from the log, or an observer for an inertia; parts are of one drive.

    An observer is stiffer than the negative stiffness `falling` of the axis, which would otherwise tip over in
    simulation where the machine was balanced.
    """
    position = parts[0].signal
    if given is not None:
        cascade = replace(given, signal=position)
        return Driver("given", cascade, _share_explained(cascade, parts))
    if all(part.has_reference for part in parts):
        read = cascade_of_log(
            parts[0].log, parts[0].force, position, _cutoff(record), parts[0].reference_column
        )
        if read is not None and (share := _share_explained(read, parts)) >= _EXPLAINED:
            return Driver("identified", read, share)
    hz = max(_OBSERVER_HZ, math.sqrt(_HOLDS * falling / inertia) / math.pi)
    observer = Cascade(position, math.pi * hz / 2, inertia * math.tau * hz, 0.0)
    return Driver("observer", observer, math.nan)


def _share_explained(cascade: Cascade, parts: Sequence[Part]) -> float:
    """Share of the measured force's variance that a cascade explains along the log; nan without a reference."""
    left, whole = 0.0, 0.0
    for part in parts:
        if not part.has_reference:
            return math.nan
        log, period = part.log, part.log.sampling_period
        force = part.low_passed(log[part.force])
        reference, position = part.low_passed(part.reference), part.low_passed(part.position)
        speed, acceleration = derivatives(reference, period, 2)
        error = cascade.position_gain * (reference - position) + speed
        error -= np.diff(position, prepend=position[0]) / period
        sent = cascade.velocity_gain * (error + cascade.integral_gain * period * np.cumsum(error))
        sent += cascade.velocity_feedforward * speed + cascade.acceleration_feedforward * acceleration
        left, whole = (
            left + float(np.var(force - sent) * force.size),
            whole + float(np.var(force) * force.size),
        )
    return 1.0 - left / whole if whole else math.nan


def fastest(plant: Plant) -> float:
    """Largest magnitude of the eigenvalues of a plant without its laws, rad/s."""
    n = len(plant.bodies)
    returning = np.linalg.solve(plant.mass, np.hstack([plant.stiffness, plant.damping]))
    system = np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), -returning])
    return float(np.abs(np.linalg.eigvals(system)).max())


def simulated_positions(
    explained: ExplainedAxis, parts: Sequence[Part], drivers: Sequence[Driver]
) -> list[FloatArray]:
    """Noise-free readings of the position next to each drive of a simulated axis, at the samples of a log.

    Where a whole log begins in motion, hidden bodies may swing already: their state there is the one that leads nearest
    to the measured positions. For a part of a log it is not sought, as it would let a mode imitate friction.
    """

    def positions(added: FloatArray | float = 0.0) -> list[FloatArray]:
        run = replayed(explained, parts, drivers, added)
        return [np.asarray(run[part.signal][:: part.factor]) for part in parts]

    found = positions()
    swings = any(part.start[1] for part in parts) and all(part.used.all() for part in parts)
    if not swings or not (states := _hidden_states(explained, parts)).size:
        return found
    measured, without = np.concatenate([part.position for part in parts]), np.concatenate(found)
    columns = np.stack([np.concatenate(positions(state)) - without for state in states]).T
    other = positions(np.linalg.lstsq(columns, measured - without, rcond=1e-6)[0] @ states)
    return min(other, found, key=lambda moved: float(np.linalg.norm(measured - np.concatenate(moved))))


def _hidden_states(explained: ExplainedAxis, parts: Sequence[Part]) -> FloatArray:
    """Small displacements and velocities that leave the positions next to the drives, of shape (n_states, 2 n)."""
    plant = plant_of(explained.axis, explained.values)
    free = scipy.linalg.null_space(np.array([plant.sensors[part.signal].row for part in parts])).T
    return np.asarray(_SWING * np.kron(np.diag([np.ptp(parts[0].position), np.ptp(parts[0].speed)]), free))


def replayed(
    explained: ExplainedAxis,
    parts: Sequence[Part],
    drivers: Sequence[Driver],
    added: FloatArray | float = 0.0,
) -> Log:
    """Noise-free signals of a simulated axis along a log, at the samples of the simulated controller.

    `added`, of shape (2 n,), are displacements and velocities beside those in which its springs are in equilibrium.
    """
    log, axis = parts[0].log, explained.axis
    plant = plant_of(axis, explained.values)
    if fastest(plant) * log.sampling_period > _STIFFEST:
        raise SettingError(
            f"the axis with these values swings at {fastest(plant) / math.tau:.3g} Hz, too fast for the log's samples"
        )
    begin = {}
    for part in parts:
        place, speed = part.start
        # the measured start contains the reading error
        if (misread := misreading(axis, part.signal)) is not None:
            place = 2 * place - float(misread(np.array([place]))[0])
        begin[part.signal] = place, speed
    loops = [
        replace(driver.cascade, acceleration_feedforward=0.0, velocity_feedforward=0.0) for driver in drivers
    ]
    run = simulate(
        without_noise(axis),
        explained.values,
        [part.path for part in parts],
        [Replay(part.forces, loop) for part, loop in zip(parts, loops, strict=True)],
        start=plant.follows(begin) + added,
    )
    return run.log


def since_begin(log: Log) -> FloatArray:
    """Time since the beginning of a log, s."""
    return np.asarray(log.sampling_period * np.arange(log.n_samples), dtype=np.float64)
