"""The stretches of a log in which its axis moves, with its forces between the samples."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from symid.arrays import BoolArray, FloatArray, IntArray, combination_of, runs_of_true
from symid.data import Log
from symid.output_error.force_course import Course, force_between
from symid.signal_processing import LowPass, central_difference
from symid.simulation import ForwardDynamics
from symid.simulation.plants import JointLaw, ScaledLaw

_FINEST = 8
_FINE_ENOUGH = 8000.0
"""Rate of the parts of the sampling intervals that is fine enough, Hz."""
_STANDSTILL_SHARE = 0.01
_SHORTEST_STANDSTILL = 3
_REVERSALS_APART = 12
"""Distance of two reversals, in margins, above which reversals are cut out."""
_EXCERPTS = 4  # evenly spread


@dataclass(frozen=True, eq=False)
class JointMotion:
    """Displacement and velocity of a joint in the parts of the sampling intervals, and at the samples."""

    # q, v: shape (n_samples, n_parts): within the intervals
    q: FloatArray
    v: FloatArray
    # q_at, v_at: shape (n_samples,): at the samples
    q_at: FloatArray
    v_at: FloatArray

    def at(self, samples: BoolArray | IntArray) -> JointMotion:
        """The motion at some of the samples."""
        return JointMotion(self.q[samples], self.v[samples], self.q_at[samples], self.v_at[samples])


@dataclass(frozen=True, eq=False)
class LogRun:
    """A log, cut into stretches in which the axis moves; one after the other in each array."""

    signals: tuple[str, ...]  # sensors, the columns of the readings
    period: float  # sampling period, s
    time: FloatArray  # shape (n,): times of the whole log, s
    readings: FloatArray  # shape (n_samples, n_outputs): their readings
    # shape (n_samples, n_parts, n_drives): drive forces in each part of the interval after each sample
    drive: FloatArray
    # shape (n_samples, n_drives): drive forces at the samples, as accelerometers see them
    drive_at: FloatArray
    # drive_rate, drive_rate_at: change of the forces for a recording that is later by one sample; 0 for held
    # forces
    drive_rate: FloatArray
    drive_rate_at: FloatArray
    course: Course  # course of the forces between samples
    late: float  # samples by which the forces are taken to be recorded late
    forces: FloatArray  # shape (n, n_drives): the forces of the whole log
    kept: BoolArray  # shape (n,): samples of the log that are in the stretches
    # motion of each joint with nonlinear laws; None where sensors do not determine it
    motions: tuple[JointMotion | None, ...]
    starts: tuple[int, ...]  # first sample of each stretch
    steps: FloatArray  # shape (n_outputs,): rms of the second differences of each reading

    @property
    def parts(self) -> int:
        """Parts of a sampling interval."""
        return int(self.drive.shape[1])

    @property
    def determines_motion(self) -> bool:
        """Whether sensors determine the motion of every joint with nonlinear laws."""
        return all(motion is not None for motion in self.motions)

    @property
    def known_motions(self) -> tuple[JointMotion, ...]:
        """Motions of all joints; an undetermined one is taken to rest."""
        still = np.zeros(len(self.readings))
        return tuple(motion or motion_between(still, still, self.parts) for motion in self.motions)

    def excerpt(self, n_samples: int) -> LogRun:
        """Part of the run: a limited number of samples from a few evenly spread places."""
        total = len(self.readings)
        if total <= n_samples:
            return self
        # Every part begins with an unknown state, as does each stretch within it.
        length = n_samples // _EXCERPTS
        firsts = np.linspace(0, total - length, _EXCERPTS).astype(int)
        chosen = (firsts[:, None] + np.arange(length)).ravel()
        joints = [bisect_left(self.starts, int(first)) for first in firsts]
        starts = {i * length for i in range(_EXCERPTS)} | {
            i * length + start - int(first)
            for i, (first, joint) in enumerate(zip(firsts, joints, strict=True))
            for start in self.starts[joint:]
            if start < first + length
        }
        kept = np.zeros_like(self.kept)
        kept[np.flatnonzero(self.kept)[chosen]] = True
        return replace(
            self,
            readings=self.readings[chosen],
            drive=self.drive[chosen],
            drive_at=self.drive_at[chosen],
            drive_rate=self.drive_rate[chosen],
            drive_rate_at=self.drive_rate_at[chosen],
            kept=kept,
            motions=tuple(m and m.at(chosen) for m in self.motions),
            starts=tuple(sorted(starts)),
        )

    def recorded_later(self, samples: float) -> LogRun:
        """The run with the forces taken as recorded later by a number of samples."""
        return replace(self, late=self.late + samples).driven_by(self.forces)

    def driven_by(self, forces: FloatArray) -> LogRun:
        """The run with other forces of the whole log."""
        drive, at, rate, rate_at = (
            x[self.kept] for x in force_between(forces, self.course, self.parts, self.late)
        )
        return replace(self, forces=forces, drive=drive, drive_at=at, drive_rate=rate, drive_rate_at=rate_at)


def run_of(
    dynamics: ForwardDynamics,
    log: Log,
    signals: Sequence[str],
    course: Course,
    *,
    cutoff_hz: float,
    late: float = 0.0,
    standstill: float | None = None,
) -> LogRun:
    """Forces and stretches of a log whose forces were recorded `late`, s; negative if they act later than recorded.

    Velocities of joints with friction are filtered at `cutoff_hz`; a joint that friction can hold counts as resting
    below the speed `standstill`; 0 cuts nothing.
    """
    recorded = np.stack([log[drive.signal] for drive in dynamics.axis.drives], axis=-1)
    parts = min(_FINEST, max(1, math.ceil(_FINE_ENOUGH * log.sampling_period)))
    samples = late / log.sampling_period
    forces = force_between(recorded, course, parts, samples)
    lowpass = LowPass(min(cutoff_hz, 0.4 * log.sampling_frequency))
    motions = tuple(
        _measured_motion(dynamics, direction, log, lowpass, parts) for direction, _ in dynamics.laws
    )
    margin = math.ceil(0.5 * log.sampling_frequency / lowpass.cutoff_hz)
    # While friction may hold a joint, its force is not a function of the motion: long rests are left out.
    moving = np.ones(log.n_samples, dtype=bool)
    for motion, (direction, terms) in zip(motions, dynamics.laws, strict=True):
        can_hold = JointLaw(direction, tuple(ScaledLaw(1.0, t.forces, t.code) for t in terms)).can_hold
        if motion is not None and can_hold and standstill != 0:
            moving &= ~_resting(motion, standstill, margin)
    kept, starts = _stretches(moving, shortest=max(16, 4 * len(dynamics.bodies)))
    readings = np.stack([log[name] for name in signals], axis=1)
    return LogRun(
        signals=tuple(signals),
        period=log.sampling_period,
        time=log.time,
        readings=readings[kept],
        drive=forces[0][kept],
        drive_at=forces[1][kept],
        drive_rate=forces[2][kept],
        drive_rate_at=forces[3][kept],
        course=course,
        late=samples,
        forces=recorded,
        kept=kept,
        motions=tuple(m and m.at(kept) for m in motions),
        starts=starts,
        steps=_steps(readings[kept], starts),
    )


def _steps(readings: FloatArray, starts: Sequence[int]) -> FloatArray:
    """Rms of the second differences of readings within their stretches; 1 where they are 0."""
    joints = [start - k for start in starts[1:] for k in (1, 2)]
    bends = np.delete(np.diff(readings, n=2, axis=0), joints, axis=0)
    squares = np.sum(bends**2, axis=0)
    return np.asarray(np.sqrt(np.divide(squares, len(bends), out=np.ones_like(squares), where=squares > 0)))


def read_orders(dynamics: ForwardDynamics, log: Log) -> dict[str, int]:
    """Order of the derivative that each motion sensor of a log reads, by its signal."""
    read = ((name, sensor.order) for name, sensor in dynamics.sensors.items() if name in log.signals)
    return {name: order for name, order in read if order is not None}


def _measured_motion(
    dynamics: ForwardDynamics, direction: FloatArray, log: Log, lowpass: LowPass, parts: int
) -> JointMotion | None:
    """Motion of a joint that is a combination of measured positions; None if it is not.

    Without a position, of measured speeds: the displacement is the integral, from 0 on.
    """
    orders = read_orders(dynamics, log)
    lowest = min(orders.values(), default=0)
    names = [name for name, order in orders.items() if order == lowest < 2]
    if not names:
        return None
    rows = np.stack([dynamics.sensors[name][0] for name in names])
    shares = combination_of(rows, direction)
    if shares is None:
        return None
    reading = sum(share * log[name] for share, name in zip(shares, names, strict=True))
    read = lowpass.apply(reading, log.sampling_frequency)
    if lowest == 1:
        return motion_between(np.cumsum(read) * log.sampling_period, read, parts)
    return motion_between(read, central_difference(read, log.sampling_period), parts)


def motion_between(q: FloatArray, v: FloatArray, parts: int) -> JointMotion:
    """Motion in the parts of the intervals from that at the samples, by straight lines."""
    share = (np.arange(parts) + 0.5) / parts
    inner = [np.append(x[1:], x[-1])[:, None] * share + x[:, None] * (1 - share) for x in (q, v)]
    return JointMotion(inner[0], inner[1], q, v)


def _resting(motion: JointMotion, standstill: float | None, margin: int) -> BoolArray:
    """Flags of samples in long standstills, and around reversals that are far from each other.

    At a reversal friction jumps, at a moment that filtered velocities determine only to a few samples. Where the axis
    reverses all the time little would be left; the jumps are then taken at the sign changes of the filtered velocity.
    """
    speed = np.abs(motion.v_at)
    slow = speed < (_STANDSTILL_SHARE * speed.max() if standstill is None else standstill)
    resting = np.zeros(speed.size, dtype=bool)
    for begin, end in runs_of_true(slow):
        if end - begin >= _SHORTEST_STANDSTILL:
            resting[max(begin - margin, 0) : end + margin] = True
    # Only reversals far from their neighbours are left out.
    reversals = np.flatnonzero(np.diff(np.signbit(motion.v_at)))
    apart = np.diff(np.concatenate([[-np.inf], reversals, [np.inf]])) > _REVERSALS_APART * margin
    for reversal in reversals[apart[:-1] & apart[1:]]:
        resting[max(reversal + 1 - margin, 0) : reversal + 1 + margin] = True
    return resting


def _stretches(moving: BoolArray, shortest: int) -> tuple[BoolArray, tuple[int, ...]]:
    """Samples of the stretches that are long enough, and the index of the first one of each stretch among them."""
    kept, starts, count = np.zeros(moving.size, dtype=bool), [], 0
    for begin, end in runs_of_true(moving):
        if end - begin >= shortest:
            kept[begin:end] = True
            starts.append(count)
            count += end - begin
    return kept, tuple(starts)
