"""Effects of forces, springs and masses that may be missing from a model."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from symid.arrays import ComplexArray, FloatArray
from symid.diagnosis.effects.effect import (
    Effect,
    JointEffect,
    LinearEffect,
    MatchedFilter,
    Placed,
    Shape,
    best_peaks,
    joint_units,
    sampled,
)
from symid.diagnosis.prediction.joint import Joint
from symid.diagnosis.prediction.prediction import Prediction
from symid.diagnosis.prediction.record import Record
from symid.diagnosis.prediction.response import response_of
from symid.diagnosis.prediction.weighting import starting_pulses
from symid.units import Unit

_TRIALS = 4
_SHARE_OF_BAND = 0.6
_PERIODS_OF_MODE = 3.0  # least periods of a mode within a log
_LOWEST_MODES = (0.5, 3.0)
"""Range of the lowest frequency sought, Hz: below it, a mode looks like a weight or a spring."""
_SHARE_OF_MOTION = 0.9
_MODES_APART = 1.5
"""Steps of the frequency of a mode, relative to its damping ratio: half the width of its resonance is 2."""
_MODES_TRIED = 6  # for each damping ratio, with the neighbours of each
_LEAST_LEFT = 1e-3  # of the square of a mode that inertia, damping and stiffness leave: less is not resolved
_MOST_DAMPING = 0.3  # damping ratio from which on a mode, beside a delay, looks like a lag
# Half of the squared acceleration must be more than 25 % off the mode, as a single sine does not separate the mode
# from inertia.
_NEAR_MODE, _AT_MODE = 0.25, 0.5
_MOST_OF_MASS = 0.95
_INSIDE = 0.99
_MASS_CHANGES = (-0.3, -0.1, -0.03, 0.03, 0.1, 0.3)
_USUAL_CHANGE = 0.1
_MOST_OF_OTHER = 2.0
_MOMENTS_TRIED = np.linspace(0.1, 0.9, 17)
"""Times relative to the log at which the usual change is also tried."""
_DAMPINGS = (0.01, 0.05, 0.2)
_LINE = 3.0  # amplitude of a spectral line relative to its neighbourhood
_NEIGHBOURS = 8
_FAST = 0.1
_AROUND_MODE = 0.25
"""Neighbourhood of a frequency in which a mode is sought, relative to it."""
_PEAK = 3.0
"""Gain at a mode relative to the median of its neighbourhood: a damping ratio below some 5 %."""
_FEWEST_CYCLES = 4.0  # of a disturbance within a log; with fewer, it is any slow course
_HARMONICS = 5
"""Cycles of a disturbance per cycle of the motion up to which it may be a harmonic of the motion."""
_CHANGES_WITHIN = np.array([0.1, 0.9])
"""Part of the log in which a mass may change: at its ends, unknown states decay."""
_MOMENTS = np.linspace(0.03, 0.97, 48)
"""Times of a change that are tried in another log, relative to its length."""
_UNSETTLED = 12
"""Points around the change, and after the end of the log, at which pulses have not yet decayed."""


class PeriodicDisturbanceEffect(JointEffect):
    """As sin(2 pi f t) + Ac cos(2 pi f t)."""

    name = "periodic_disturbance"
    amplitudes = ("As", "Ac")
    shape_names = ("f",)
    per_log = True

    def is_plausible(self, prediction: Prediction, placed: Placed) -> bool:
        """It has several cycles, and is not a line of the motion, which repeats."""
        frequency = placed.shape[0]
        if frequency * prediction.record.duration < _FEWEST_CYCLES:
            return False
        return not is_line_of_motion(prediction, frequency, math.hypot(*placed.amplitudes))

    def shapes(self, prediction: Prediction, place: str, matched_filter: MatchedFilter) -> Iterable[Shape]:
        response = -prediction.response.of_force(prediction.joints[place].direction)
        record = prediction.record
        wanted = matched_filter(response) * record.in_log
        padded = 4 * wanted.size
        frequency = np.fft.rfftfreq(padded, d=record.fine_time[1])
        strength = np.abs(np.fft.rfft(wanted, padded)) ** 2
        used = (frequency > _FEWEST_CYCLES / record.duration) & (frequency < _SHARE_OF_BAND * record.band_hz)
        power = np.sum(np.abs(response * prediction.density) ** 2, axis=0)
        energy = np.interp(frequency[used], record.omega / (2 * math.pi), power)
        return [(f,) for f in best_peaks(strength[used] / energy, frequency[used], _TRIALS)]

    def forces(self, prediction: Prediction, joint: Joint, shape: Shape) -> ComplexArray:
        phase = 2 * math.pi * shape[0] * prediction.record.fine_time
        inside = prediction.record.in_log
        return sampled(prediction, np.sin(phase) * inside, np.cos(phase) * inside)

    def units(self, prediction: Prediction, place: str) -> tuple[str, ...]:
        force = str(joint_units(prediction, place)[0])
        return force, force, "Hz"


def is_mode(prediction: Prediction, frequency: float) -> bool:
    """Whether hidden bodies resonate at a frequency: apparent inertias of the drives peak there."""
    hertz, response = prediction.record.omega / (2 * math.pi), prediction.response
    near = np.abs(hertz - frequency) < _AROUND_MODE * frequency
    if np.count_nonzero(near) < _NEIGHBOURS:
        return False
    at = int(np.argmin(np.abs(hertz[near] - frequency)))
    inertias = response.of_positions[:, : prediction.record.n_drives, near] / hertz[near] ** 2
    gains = np.abs(inertias).reshape(-1, np.count_nonzero(near))
    return bool(np.any(gains[:, at] > _PEAK * np.median(gains, axis=1)))


def is_line_of_motion(prediction: Prediction, frequency: float, amplitude: float) -> bool:
    """Whether the force of the motion has a spectral line at a frequency, stronger than a disturbance there.

    The bins at the frequency are compared with the median of their neighbours. A controller counteracts a slow
    disturbance, so that the motion shows little of it; a fast one is not a harmonic of the motion.
    """
    drives = range(prediction.record.n_drives)
    return any(_has_line(prediction, drive, frequency, amplitude) for drive in drives)


def _has_line(prediction: Prediction, drive: int, frequency: float, amplitude: float) -> bool:
    record = prediction.record
    inside = record.rows_in_log
    force = record.rows(prediction.outputs[drive] * record.taper)[inside]
    lines = np.abs(np.fft.rfft((force - force.mean()) * np.hanning(force.size))) / (force.size / 4)
    velocity = record.rows(1j * record.omega * record.motions[drive])[inside]
    fast = velocity[np.abs(velocity) > _FAST * np.abs(velocity).max()]
    cycles = np.count_nonzero(np.diff(np.signbit(fast))) / 2
    at = round(frequency * record.duration)
    if at > _HARMONICS * max(cycles, 1):
        return False
    low, high = max(at - _NEIGHBOURS, 1), min(at + _NEIGHBOURS + 1, lines.size)
    if at < 1 or at + 2 > lines.size or high - low < _NEIGHBOURS:
        return False
    line = float(lines[at - 1 : at + 2].max())
    return line > max(_LINE * float(np.median(lines[low:high])), amplitude)


class PayloadChangeEffect(Effect):
    """The mass of a body is larger by dm from the time t0 on; before and after, the axis is linear."""

    name = "payload_change"
    amplitudes = ("share",)
    shape_names = ("dm", "t0")
    moments = ("t0",)
    fixed = True
    per_log = True

    def places(self, prediction: Prediction) -> Iterable[str]:
        return tuple(prediction.bodies)

    def shapes(self, prediction: Prediction, place: str, matched_filter: MatchedFilter) -> Iterable[Shape]:
        body, record = prediction.bodies[place], prediction.record
        response = -prediction.response.of_force(body.direction)
        inertial = record.from_grid(body.a)
        energy = np.sum(record.fine(response * prediction.density * inertial) ** 2, axis=0) * record.in_log
        if not 0 < energy.sum() < np.inf:
            return []
        # Matched filter for an inertial force from each time on: its correlation with the residual, less the part that
        # a constant change of the mass would explain, relative to its energy.
        later = np.cumsum((matched_filter(response) * body.a * record.in_log)[::-1])[::-1]
        after = np.cumsum(energy[::-1])[::-1] / energy.sum()
        score = (later - after * later[0]) ** 2 / (after * (1 - after) + 1e-2)
        step = max(1, score.size // 400)
        times = best_peaks(score[::step], record.fine_time[::step], _TRIALS)
        mass = abs(float(body.direction @ prediction.response.plant.mass @ body.direction))
        first, last = _CHANGES_WITHIN * record.log.n_samples * record.log.sampling_period
        spread = record.duration * _MOMENTS_TRIED
        moments = {
            x: [*times, *map(float, spread)] if abs(x) == _USUAL_CHANGE else times for x in _MASS_CHANGES
        }
        return [(x * mass, t) for x in _MASS_CHANGES for t in moments[x] if first < t < last]

    def is_plausible(self, prediction: Prediction, placed: Placed) -> bool:
        """The larger of both masses is less than twice the other: else one of them has lost its inertia."""
        direction = prediction.bodies[placed.at].direction
        before = float(direction @ prediction.response.plant.mass @ direction)
        smaller, larger = sorted((before, before + placed.shape[0]))
        return larger < _MOST_OF_OTHER * smaller

    def shapes_of_log(self, record: Record, shape: Shape) -> Iterable[Shape]:
        return [(shape[0], float(share * record.duration)) for share in _MOMENTS]

    def columns(self, prediction: Prediction, place: str, shape: Shape) -> ComplexArray:
        """Change of the outputs by the added inertia, computed with the axis that has it throughout.

        The motion x of the axis as modelled obeys (M + dm) x'' + ... = f + dm x''. From t0 on the last term is absent,
        so that the outputs change by the response of the axis with dm to -dm x'' from then on. The hidden bodies keep
        their motion at t0.
        """
        record, (change, moment) = prediction.record, shape
        body = prediction.bodies[place]
        other, free = prediction.response.memory.of(
            (self, place), change, lambda: self._with_change(prediction, body.direction, change)
        )
        time = record.fine_time
        later = np.clip(0.5 + (time - moment) / (4 * time[1]), 0, 1) * record.in_log
        changed = -change * other * record.from_grid(body.a * later)
        return self._ended(record, changed, free, moment)[None]

    def _with_change(
        self, prediction: Prediction, direction: FloatArray, change: float
    ) -> tuple[ComplexArray, ComplexArray]:
        """For the axis with the other mass: outputs for a force on the body, and for pulses at the end of the log."""
        record = prediction.record
        inertia = np.asarray(change * (1j * record.omega) ** 2, dtype=np.complex128)
        other = response_of(record, prediction.parameters, [*prediction.impedances, (direction, inertia)])
        hidden = [other.of_force(free) for free in prediction.free_directions]
        return other.of_force(direction), starting_pulses(record, hidden, (record.duration,))

    def _ended(
        self, record: Record, changed: ComplexArray, free: ComplexArray, moment: float
    ) -> ComplexArray:
        """The change without the free motion after the log, which a periodic record continues before the change."""
        if not len(free):
            return changed
        # Pulses at the end of the log are fitted to the outputs where these should be zero, and subtracted.
        time, margin = record.fine_time, _UNSETTLED * record.fine_time[1]
        quiet = (time > record.duration + margin) | (time < moment - margin)
        columns = record.fine(free[:, 0])[:, quiet].T
        scale = np.linalg.norm(columns, axis=0)
        amounts = np.linalg.lstsq(columns / scale, record.fine(changed[0])[quiet], rcond=None)[0] / scale
        return np.asarray(changed - np.tensordot(amounts, free, 1))

    def units(self, prediction: Prediction, place: str) -> tuple[str, ...]:
        force, length = joint_units(prediction, place)
        return "1", str(force * Unit.of("s") ** 2 / length), "s"


class FlexibleModeEffect(LinearEffect):
    """An additional mass m on a spring, attached to a body, with natural frequency f and damping ratio D.

    Its dynamic stiffness is m s^2 (2 D wa s + wa^2) / (s^2 + 2 D wa s + wa^2) with wa = 2 pi f. The effect is the
    difference from m s^2, so that the declared mass remains the total mass.
    """

    name = "flexible_mode"
    amplitudes = ("m",)
    shape_names = ("f", "D")
    positive = True
    may_be_zero = ("D",)

    def is_plausible(self, prediction: Prediction, placed: Placed) -> bool:
        """Its mass is part of that of the body, and the axis moves at its frequency and at others."""
        body, record = prediction.bodies[placed.at], prediction.record
        whole = float(body.direction @ prediction.response.plant.mass @ body.direction)
        (mass,), (frequency, damping) = placed.amplitudes, placed.shape
        _, highest = _modes_seen(record)
        if not (mass < _MOST_OF_MASS * whole and frequency < _INSIDE * highest and damping < _MOST_DAMPING):
            return False
        omega = record.omega
        power = np.abs(omega**2 * body.modelled) ** 2
        near = np.abs(omega - 2 * math.pi * frequency) < _NEAR_MODE * omega
        return bool(power[near].sum() < _AT_MODE * power.sum())

    def joint(self, prediction: Prediction, place: str) -> Joint:
        return prediction.bodies[place]

    def shapes(self, prediction: Prediction, place: str, matched_filter: MatchedFilter) -> Iterable[Shape]:
        lowest, highest = _modes_seen(prediction.record)
        octaves = max(math.log(highest / lowest), 0.0)
        found = []
        for damping in _DAMPINGS:
            hertz = np.geomspace(lowest, highest, 1 + math.ceil(octaves / (_MODES_APART * damping)))
            score = self._scores(prediction, place, matched_filter, [(float(f), damping) for f in hertz])
            peaks = best_peaks(np.pad(score, 1), np.pad(hertz, 1, "edge"), _MODES_TRIED)
            apart = np.abs(np.log(np.divide.outer(hertz, peaks))).min(axis=1)
            found += [(float(f), damping) for f in hertz[apart < 1.01 * _MODES_APART * damping]]
        return found

    def _scores(
        self, prediction: Prediction, place: str, matched_filter: MatchedFilter, shapes: Sequence[Shape]
    ) -> FloatArray:
        """Square of the residual that each mode explains, as if the weights acted on frequencies alone."""
        body, record = prediction.bodies[place], prediction.record
        response = -prediction.response.of_force(body.direction)
        weighted = response * prediction.density * record.taper * body.modelled
        amplitude = np.linalg.norm(weighted, axis=0)
        # Apart from the inertia, damping and stiffness that the axis has: projection on 1, s and s^2.
        plain = np.stack([(1j * record.omega) ** k for k in range(3)]) * amplitude
        scale = np.linalg.norm(plain, axis=1, keepdims=True)
        plain = (plain / np.where(scale > 0, scale, 1.0)).conj()
        gram = np.linalg.pinv((plain @ plain.conj().T).real, rcond=1e-10, hermitian=True)
        wanted = record.from_grid(matched_filter(response)).conj() * body.modelled
        scores = np.zeros(len(shapes))
        for i, shape in enumerate(shapes):
            mode = self.stiffness(record.omega, shape)
            explained = max(float((mode @ wanted).real), 0.0)
            mode *= amplitude
            taken, whole = (plain @ mode).real, float(np.vdot(mode, mode).real)
            if whole > 0:
                scores[i] = explained**2 / max(whole - taken @ gram @ taken, _LEAST_LEFT * whole)
        return scores

    def bounded(self, prediction: Prediction, place: str, shape: Shape) -> Shape:
        lowest, highest = _modes_seen(prediction.record)
        return float(np.clip(shape[0], 0.5 * lowest, highest)), float(np.clip(shape[1], 1e-3, 1.0))

    def stiffness(self, omega: FloatArray, shape: Shape) -> ComplexArray:
        own, square = 2 * math.pi * shape[0], omega**2
        return np.asarray(-(square**2) / (own**2 - square + 2j * shape[1] * own * omega), dtype=np.complex128)

    def free_motion(self, prediction: Prediction, placed: Placed) -> tuple[ComplexArray, ...]:
        """Force of the mass that rings from before the log; a weakly damped one does so for long."""
        (frequency, damping), s = placed.shape, 1j * prediction.record.omega
        own = 2 * math.pi * frequency
        ringing = 1.0 / ((s / own) ** 2 + 2 * damping * (s / own) + 1.0)
        return (ringing * prediction.response.of_force(prediction.bodies[placed.at].direction),)

    def units(self, prediction: Prediction, place: str) -> tuple[str, ...]:
        force, length = joint_units(prediction, place)
        return str(force * Unit.of("s") ** 2 / length), "Hz", "1"


def _modes_seen(record: Record) -> tuple[float, float]:
    """Lowest and highest frequency of a mode that a log shows, Hz."""
    lowest = float(np.clip(_PERIODS_OF_MODE / record.duration, *_LOWEST_MODES))
    return lowest, _SHARE_OF_MOTION * record.motion_hz
