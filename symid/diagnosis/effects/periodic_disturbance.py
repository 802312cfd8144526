"""The effect of a sinusoidal force, and its distinction from lines of the motion and from vibration modes."""

import math
from collections.abc import Iterable

import numpy as np

from symid.arrays import ComplexArray
from symid.diagnosis.effects.effect import (
    JointEffect,
    MatchedFilter,
    Placed,
    Shape,
    best_peaks,
    joint_units,
    sampled,
)
from symid.diagnosis.prediction.joint import RecordedJoint
from symid.diagnosis.prediction.prediction import Prediction

_TRIALS = 4
_SHARE_OF_BAND = 0.6
_LINE = 3.0  # amplitude of a spectral line relative to its neighbourhood
_NEIGHBOURS = 8
_FAST = 0.1
_AROUND_MODE = 0.25
"""Neighbourhood of a frequency in which a mode is sought, relative to it."""
_PEAK = 3.0
"""Gain at a mode relative to the median of its neighbourhood: a damping ratio below some 5 %."""
_FEWEST_CYCLES = 4.0  # of a disturbance within a log; with fewer, it is any slow course
_SAME = 0.15
"""Relative difference of amplitude and frequency in two logs below which it is the same disturbance."""
_OWN = 0.5
"""Share of the power of the speed at a frequency from which on it is that of the motion: friction, inertia and weight
then make such a force, and a disturbance fitted in their place leaves them none (the swing of a double pendulum)."""
_HARMONICS = 5
"""Cycles of a disturbance per cycle of the motion up to which it may be a harmonic of the motion."""


class PeriodicDisturbanceEffect(JointEffect):
    """Sinusoidal force As sin(2 pi f t) + Ac cos(2 pi f t)."""

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

    def recurs(self, found: Placed, here: Placed) -> bool:
        """It has the same amplitude and frequency, whatever its phase."""
        pairs = (
            (math.hypot(*found.amplitudes), math.hypot(*here.amplitudes)),
            (found.shape[0], here.shape[0]),
        )
        return all(abs(other - own) < _SAME * own for own, other in pairs)

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

    def forces(self, prediction: Prediction, joint: RecordedJoint, shape: Shape) -> ComplexArray:
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

    The bins at the frequency are compared with the median of their neighbours. Where most of the speed is at the
    frequency, its force is one of the motion whatever the model leaves of it. A controller counteracts a slow
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
    power = np.abs(np.fft.rfft((velocity - velocity.mean()) * np.hanning(velocity.size))) ** 2
    if power[at - 1 : at + 2].sum() > _OWN * power.sum():
        return True
    line = float(lines[at - 1 : at + 2].max())
    return line > max(_LINE * float(np.median(lines[low:high])), amplitude)
