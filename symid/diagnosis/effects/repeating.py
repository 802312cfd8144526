"""Effects that are periodic along the stroke: in a force, dry friction, the force constant or a position reading.

Each is a sine and a cosine of the displacement times a factor: 1, the direction of motion, or the drive force. The
pitch is estimated from the residual by a Fourier transform along the stroke.
"""

import math
from collections.abc import Iterable, Iterator

import numpy as np
import scipy

from symid.arrays import ComplexArray, FloatArray
from symid.axis import length_unit
from symid.diagnosis.effects.effect import Effect, MatchedFilter, Placed, Shape, best_peaks, joint_units
from symid.diagnosis.effects.from_law import LawEffect
from symid.diagnosis.effects.signals import DriveEffect, drive_at
from symid.diagnosis.prediction.joint import RecordedJoint
from symid.diagnosis.prediction.prediction import Prediction
from symid.units import Unit

_LEAST_PITCH = 1e-3  # shortest pitch along a straight stroke, m
_MOST_WAVES = 150  # largest number of periods per turn: slots and pole pairs of a motor, teeth of a gear
_MOST_BINS = 2**20  # along the stroke, 8 for the shortest pitch: memory does not grow without bound
_MOST_PARTS = 16  # of the way between two samples
_SPEEDS_OF_ENERGY = 48  # bins of the speed, each with its share of the energy of a wave
_WAVES_OF_ENERGY = 400  # waves at which the energy is computed; others are interpolated
_LEAST_STROKE = 5e-3  # m or rad
_TRIALS = 4  # pitches tried
_IN_BAND = 0.95  # share of the band up to which a wave counts
_STEEPEST_RIPPLE = 0.2  # slope of the error of a reading
_ROUNDS = 5  # from a reading to the true position; each leaves at most that slope of the error before
_BOTH_BENDS = 0.75  # of a wave, whatever its phase; less is a stiffness
_MOST_OF_CONSTANT = 0.5  # ripple of a force constant relative to its mean; that of motors is a tenth of it


class CoggingEffect(LawEffect):
    """Force ripple along the stroke."""

    def is_possible(self, prediction: Prediction, placed: Placed) -> bool:
        """The stroke shows both bends of a wave."""
        return _repeats(prediction.joints[placed.at], _BOTH_BENDS * placed.shape[0])

    def is_plausible(self, prediction: Prediction, placed: Placed) -> bool:
        """The ripple repeats within the stroke."""
        return _repeats(prediction.joints[placed.at], placed.shape[0])

    def places(self, prediction: Prediction) -> Iterable[str]:
        return [name for name, joint in prediction.joints.items() if joint.stroke > _LEAST_STROKE]

    def shapes(self, prediction: Prediction, place: str, matched_filter: MatchedFilter) -> Iterable[Shape]:
        joint = prediction.joints[place]
        return [*_of_joint_force(prediction, joint, matched_filter), (joint.stroke,)]

    def courses(self, joint: RecordedJoint, shape: Shape) -> tuple[FloatArray, ...]:
        """Sine and cosine along the stroke, without parts above the band."""
        return tuple(wave * _in_band(joint, shape[0]) for wave in super().courses(joint, shape))


class PeriodicFrictionEffect(LawEffect):
    """Dry friction with a periodic level; periods up to the length of the stroke are tried."""

    def shapes(self, prediction: Prediction, place: str, matched_filter: MatchedFilter) -> Iterator[Shape]:
        yield from super().shapes(prediction, place, matched_filter)
        joint = prediction.joints[place]
        direction = joint.averaged(np.sign(joint.v))
        for shape in _of_joint_force(prediction, joint, matched_filter, direction):
            if self.bounded(prediction, place, shape) == shape:
                yield shape


class ForceConstantRippleEffect(DriveEffect):
    """The acting force differs from the logged one by a share that is periodic along the stroke."""

    name = "force_constant_ripple"
    amplitudes = ("As", "Ac")
    shape_names = ("pitch",)

    @property
    def is_of_command(self) -> bool:
        """The motor acts on its current, after any delay or lag."""
        return False

    def is_possible(self, prediction: Prediction, placed: Placed) -> bool:
        """It repeats within the stroke and leaves most of the constant."""
        repeats = _repeats(_joint_of(prediction, placed.at), placed.shape[0])
        return repeats and math.hypot(*placed.amplitudes) < _MOST_OF_CONSTANT

    def places(self, prediction: Prediction) -> Iterable[str]:
        found = super().places(prediction)
        return [place for place in found if _joint_of(prediction, place).stroke > _LEAST_STROKE]

    def shapes(self, prediction: Prediction, place: str, matched_filter: MatchedFilter) -> Iterable[Shape]:
        response = _of_output(prediction, drive_at(prediction, place))
        joint, force = _joint_of(prediction, place), _force_course(prediction, place)
        unit = length_unit(prediction.axis.drives[drive_at(prediction, place)].at)
        return repeating_pitches(prediction, joint, unit, matched_filter, response, force)

    def columns(self, prediction: Prediction, place: str, shape: Shape) -> ComplexArray:
        joint = _joint_of(prediction, place)
        waves = joint.memory.of((self, place), shape, lambda: np.stack(ripple(joint, shape[0])))
        changes = prediction.record.from_grid(_force_course(prediction, place) * waves)
        return self._force(prediction, place, *changes)

    def units(self, prediction: Prediction, place: str) -> tuple[str, ...]:
        return "1", "1", str(length_unit(prediction.axis.drives[drive_at(prediction, place)].at))


class EncoderRippleEffect(Effect):
    """A position reading with an error As sin(2 pi q/p) + Ac cos(2 pi q/p)."""

    name = "encoder_ripple"
    amplitudes = ("As", "Ac")
    shape_names = ("pitch",)

    def is_possible(self, prediction: Prediction, placed: Placed) -> bool:
        return _repeats(_reading(prediction, placed.at), placed.shape[0])

    def is_plausible(self, prediction: Prediction, placed: Placed) -> bool:
        """The slope of the reading remains close to 1."""
        slope = math.tau * math.hypot(*placed.amplitudes) / placed.shape[0]
        return slope < _STEEPEST_RIPPLE

    def places(self, prediction: Prediction) -> Iterable[str]:
        sensors = prediction.record.dynamics.sensors
        return [name for name in prediction.record.signals if sensors[name][1] == 0]

    def shapes(self, prediction: Prediction, place: str, matched_filter: MatchedFilter) -> Iterable[Shape]:
        response = self._response(prediction, place)
        reading, unit = _reading(prediction, place), prediction.axis.signal_units[place]
        return repeating_pitches(prediction, reading, unit, matched_filter, response)

    def columns(self, prediction: Prediction, place: str, shape: Shape) -> ComplexArray:
        def waves() -> ComplexArray:
            return prediction.record.from_grid(np.stack(ripple(_reading(prediction, place), shape[0])))

        found = prediction.record.memory.of((self, place), shape, waves)
        return np.asarray(self._response(prediction, place) * found[:, None, :])

    def change(self, prediction: Prediction, placed: Placed) -> ComplexArray:
        return self._response(prediction, placed.at) * _error_of_reading(prediction, placed)

    def misreading(self, prediction: Prediction, placed: Placed) -> ComplexArray | None:
        driven = prediction.record.driven
        if placed.at not in driven:
            return None
        found = np.zeros_like(prediction.record.motions)
        found[driven.index(placed.at)] = _error_of_reading(prediction, placed)
        return found

    def _response(self, prediction: Prediction, place: str) -> ComplexArray:
        """Response of the predicted outputs to an error of the reading."""
        record = prediction.record
        if place in record.driven:
            return np.asarray(-prediction.response.of_positions[record.driven.index(place)])
        return _of_output(prediction, record.signals.index(place))

    def units(self, prediction: Prediction, place: str) -> tuple[str, ...]:
        return (str(prediction.axis.signal_units[place]),) * 3


def _error_of_reading(prediction: Prediction, placed: Placed) -> ComplexArray:
    """Spectrum of the ripple of an encoder, which repeats along the true position, the reading less the ripple."""
    values = (placed.shape, placed.amplitudes)
    return prediction.record.memory.of(("ripple", placed.at), values, lambda: _ripple_of(prediction, placed))


def _ripple_of(prediction: Prediction, placed: Placed) -> ComplexArray:
    reading, (pitch,) = _reading(prediction, placed.at), placed.shape
    sine, cosine = placed.amplitudes
    error = np.zeros_like(reading.q)
    for _ in range(_ROUNDS):
        phase = 2 * math.pi / pitch * (reading.q - error)
        error = sine * np.sin(phase) + cosine * np.cos(phase)
    return prediction.record.from_grid(error * _in_band(reading, pitch))


def _repeats(joint: RecordedJoint, pitch: float) -> bool:
    """Whether the stroke contains a whole period; a part of one is any smooth course along the stroke."""
    return pitch < joint.stroke


def ripple(joint: RecordedJoint, pitch: float) -> tuple[FloatArray, FloatArray]:
    """Sine and cosine along the stroke, without parts above the band."""
    phase = 2 * math.pi / pitch * joint.q
    below = _in_band(joint, pitch)
    return np.sin(phase) * below, np.cos(phase) * below


def repeating_pitches(
    prediction: Prediction,
    joint: RecordedJoint,
    unit: Unit,
    matched_filter: MatchedFilter,
    response: ComplexArray,
    factor: FloatArray | None = None,
) -> Iterable[Shape]:
    """Pitches at which a factor times a wave along the stroke explains most of the residual.

    `unit` is that of the displacement of the joint, which may differ from that of the drive. `response` is the response
    of the outputs to this signal. The output of the matched filter, times the factor, is summed in bins along the
    stroke; one Fourier transform of the bins gives the correlation with all waves. Each sample is spread over the way
    to the next: at a steady speed, samples at points have images at waves of their distance, which no motion shows.
    """
    low, high = joint.range
    inside = prediction.record.in_log
    weight = np.ones_like(joint.q) if factor is None else factor
    least = max(
        2 * math.pi / _MOST_WAVES if str(unit) == "rad" else _LEAST_PITCH, 8 * (high - low) / _MOST_BINS
    )
    n = max(256, math.ceil(8 * (high - low) / least))
    way = np.diff(joint.q, append=joint.q[-1])[inside]
    parts = min(_MOST_PARTS, 1 + int(2 * float(np.abs(way).max()) / least))
    spread = (joint.q[inside] + np.outer(np.arange(parts) / parts, way) - low) / (high - low)
    place = np.clip((spread * n).astype(int), 0, n - 1)
    filtered = np.tile((matched_filter(response) * weight)[inside], parts)
    along = np.bincount(place.ravel(), weights=filtered, minlength=n)
    padded = scipy.fft.next_fast_len(4 * n, real=True)
    waves = np.asarray(np.fft.rfftfreq(padded, d=(high - low) / n), dtype=np.float64)
    strength = np.abs(scipy.fft.rfft(along, padded)) ** 2
    used = (waves > 1.0 / (high - low)) & (waves < 1 / least)
    if not used.any():
        return ()
    score = strength[used] / _mean_square_of_waves(prediction, joint, waves[used], response, weight)
    return [(1 / wave,) for wave in best_peaks(score, waves[used], _TRIALS)]


def _of_joint_force(
    prediction: Prediction,
    joint: RecordedJoint,
    matched_filter: MatchedFilter,
    factor: FloatArray | None = None,
) -> Iterable[Shape]:
    """`repeating_pitches` of a force in a joint."""
    response = -prediction.response.of_force(joint.direction)
    _, unit = joint_units(prediction, joint.name)
    return repeating_pitches(prediction, joint, unit, matched_filter, response, factor)


def _of_output(prediction: Prediction, output: int) -> ComplexArray:
    """Response of the outputs to a signal that is added to one of them."""
    response = np.zeros_like(prediction.record.measured)
    response[output] = 1.0
    return response


def _mean_square_of_waves(
    prediction: Prediction,
    joint: RecordedJoint,
    waves: FloatArray,
    response: ComplexArray,
    weight: FloatArray,
) -> FloatArray:
    """Mean square of a unit wave along the stroke in the weighted outputs, from its frequency at each speed."""
    inside = prediction.record.in_log
    speeds, edges = np.histogram(np.abs(joint.v[inside]), bins=_SPEEDS_OF_ENERGY, weights=weight[inside] ** 2)
    middle = (edges[1:] + edges[:-1]) / 2
    power = np.sum(np.abs(response * prediction.density) ** 2, axis=0)
    frequency = prediction.record.omega / (2 * math.pi)
    coarse = np.linspace(waves[0], waves[-1], _WAVES_OF_ENERGY)
    energy = np.interp(np.outer(coarse, middle), frequency, power, right=0.0) @ speeds
    return np.asarray(np.interp(waves, coarse, energy) + 1e-3 * energy.max())


def _in_band(joint: RecordedJoint, pitch: float) -> FloatArray:
    """1 where the frequency of a wave of a pitch is within the band, else 0."""
    return np.asarray(np.abs(joint.v) < _IN_BAND * pitch * joint.record.band_hz, dtype=np.float64)


def _joint_of(prediction: Prediction, place: str) -> RecordedJoint:
    """The displacement along which a drive acts."""
    return prediction.joints_of_drives[drive_at(prediction, place)]


def _force_course(prediction: Prediction, place: str) -> FloatArray:
    """Force of a drive after its lag on the fine grid, within the log."""
    record = prediction.record
    return np.asarray(record.fine(prediction.acting[drive_at(prediction, place)]) * record.in_log)


def _reading(prediction: Prediction, signal: str) -> RecordedJoint:
    record = prediction.record
    place = record.signals.index(signal)
    spectrum = record.motions[place] if place < record.n_drives else record.measured[place]
    return RecordedJoint(signal, record.dynamics.sensors[signal][0], spectrum, spectrum, record)
