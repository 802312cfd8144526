"""The effect of a mass that changes during a log."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from symid.arrays import ComplexArray, FloatArray, least_squares
from symid.axis import Weight
from symid.diagnosis.effects.effect import (
    Effect,
    MatchedFilter,
    ParametersBefore,
    Placed,
    Shape,
    best_peaks,
    joint_units,
)
from symid.diagnosis.prediction.hidden_equation import MassChange
from symid.diagnosis.prediction.joint import RecordedJoint
from symid.diagnosis.prediction.prediction import Prediction
from symid.diagnosis.prediction.record import Record
from symid.diagnosis.prediction.response import axis_response
from symid.diagnosis.prediction.weighting import starting_pulses
from symid.units import Unit

_TRIALS = 4
_MASS_CHANGES = (-0.3, -0.1, -0.03, -0.01, 0.01, 0.03, 0.1, 0.3)
_LARGE_CHANGES = (-0.45, -0.3, -0.15, 0.15, 0.3, 0.5, 0.8)
"""Changes relative to the mass before them, after which the fitted mass may hold."""
_USUAL_CHANGE = 0.1
_MOST_OF_OTHER = 2.0
_MOMENTS_TRIED = np.linspace(0.1, 0.9, 17)
"""Times relative to the log at which the usual change is also tried."""
_CHANGES_WITHIN = np.array([0.1, 0.9])
"""Part of the log in which a mass may change: at its ends, unknown states decay."""
_MOMENTS = np.linspace(0.03, 0.97, 48)
"""Times of a change that are tried in another log, relative to its length."""
_CLOSE = 2.0
"""Distance of the times that are tried where those are too coarse, in periods of the highest frequency used. A body
that rings after the change shows its time to within some milliseconds, and nothing beside."""
_SMOOTH = 4
"""Points of the fine grid over which a mass changes where the motion has no jump."""
_FADES = 30.0
"""Periods of the highest frequency used in which a unit step fades, so that it ends within the log."""
_ALIKE = 1e-12
"""Relative singular value below which combinations of pulses count as none."""
_UNSETTLED = 12
"""Points around the change, and after the end of the log, at which pulses have not yet decayed."""


class PayloadChangeEffect(Effect):
    """The mass of a body and its weight grow by dm at the time t0; before and after it the axis is linear."""

    name = "payload_change"
    amplitudes = ("share",)
    shape_names = ("dm", "t0")
    moments = ("t0",)
    fixed = True
    per_log = True

    def places(self, prediction: Prediction) -> Iterable[str]:
        return tuple(prediction.loaded)

    def shapes(self, prediction: Prediction, place: str, matched_filter: MatchedFilter) -> Iterable[Shape]:
        body, record = prediction.loaded[place], prediction.record
        response = -prediction.response.of_force(body.direction)
        load = _load(prediction, body)
        inertial = record.from_grid(load)
        energy = np.sum(record.fine(response * prediction.density * inertial) ** 2, axis=0) * record.in_log
        if not 0 < energy.sum() < np.inf:
            return []
        # Matched filter for the force of an added mass from each time on: its correlation with the residual, less the
        # part that a constant change of the mass would explain, relative to its energy.
        later = np.cumsum((matched_filter(response) * load * record.in_log)[::-1])[::-1]
        after = np.cumsum(energy[::-1])[::-1] / energy.sum()
        score = (later - after * later[0]) ** 2 / (after * (1 - after) + 1e-2)
        step = max(1, score.size // 400)
        times = best_peaks(score[::step], record.fine_time[::step], _TRIALS)
        mass = abs(_effective_mass(prediction, body))
        first, last = _CHANGES_WITHIN * record.log.n_samples * record.log.sampling_period
        spread = record.duration * _MOMENTS_TRIED
        moments = {
            x: [*times, *map(float, spread)] if abs(x) == _USUAL_CHANGE else times for x in _MASS_CHANGES
        }
        return [(x * mass, t) for x in _MASS_CHANGES for t in moments[x] if first < t < last]

    def is_plausible(self, prediction: Prediction, placed: Placed) -> bool:
        """The larger of both masses is less than twice the other: else one of them has lost its inertia."""
        before = _effective_mass(prediction, prediction.loaded[placed.at])
        smaller, larger = sorted((before, before + placed.shape[0]))
        return larger < _MOST_OF_OTHER * smaller

    def changes_to(self, prediction: Prediction, place: str) -> Iterable[ParametersBefore]:
        """The fitted mass of a hidden body may be that after the change; the error is not linear in its mass."""
        record, values = prediction.record, dict(prediction.parameters)
        names = {body.name: body.inertial for body in prediction.axis.free_bodies}
        name = names.get(place)
        if name not in values or not record.is_predicted(prediction.loaded[place].direction):
            return
        for share in _LARGE_CHANGES:
            before = values[name] / (1 + share)
            changes = [(share * before, time) for time in _MOMENTS_TRIED * record.duration]
            yield values | {name: before}, changes

    def varies_with_parameters(self, prediction: Prediction, place: str) -> bool:
        """A hidden body has another resonance after the change."""
        return prediction.record.is_predicted(prediction.loaded[place].direction)

    def shapes_of_log(self, prediction: Prediction, placed: Placed) -> Iterable[Shape]:
        record = prediction.record
        # A load that is gripped at rest sets a vertical axis moving.
        begins = record.fine_time[1:][np.diff(record.moving.astype(np.int8)) > 0]
        return [(placed.shape[0], float(time)) for time in (*_MOMENTS * record.duration, *begins)]

    def close_shapes(self, prediction: Prediction, placed: Placed, reach: float) -> Iterable[Shape]:
        record = prediction.record
        if not record.is_predicted(prediction.loaded[placed.at].direction):
            return []
        change, moment = placed.shape
        earliest, latest = np.clip(moment / record.duration + np.array([-reach, reach]), *_MOMENTS[[0, -1]])
        times = np.arange(earliest * record.duration, latest * record.duration, _CLOSE / record.band_hz)
        return [(change, float(time)) for time in times]

    def mass_change(self, prediction: Prediction, placed: Placed) -> MassChange | None:
        body, (change, moment) = prediction.loaded[placed.at], placed.shape
        if not prediction.record.is_predicted(body.direction):
            return None
        return MassChange(body.direction, change, _gravity(prediction, body), moment)

    def columns(self, prediction: Prediction, place: str, shape: Shape) -> ComplexArray:
        """Change of the outputs by the added inertia, computed with the axis that has it throughout.

        The motion x of the axis as modelled obeys (M + dm) x'' + ... = f + dm x''. From t0 on the last term is absent,
        and the body weighs dm g more, so that the outputs change by the response of the axis with dm to -dm (x'' + g)
        from then on. The hidden bodies keep their motion at t0.
        """
        record, (change, moment) = prediction.record, shape
        body = prediction.loaded[place]
        other, free = prediction.response.memory.of(
            (self, place), change, lambda: _with_change(prediction, body.direction, change)
        )
        if record.is_predicted(body.direction):  # the motion of the axis as modelled has no jump
            load = _load(prediction, body) * _later(record, moment, _SMOOTH)
        else:
            load = _with_sharp_jump(prediction, body, shape) * _later(record, moment)
        return free.taken_from(-change * other * record.from_grid(load), moment)[None]

    def units(self, prediction: Prediction, place: str) -> tuple[str, ...]:
        force, length = joint_units(prediction, place)
        return "1", str(force * Unit.of("s") ** 2 / length), "s"


@dataclass(frozen=True, eq=False)
class _FreeMotion:
    """Motion of the axis with the other mass after the log, which a periodic record continues before the change."""

    record: Record
    outputs: ComplexArray  # for pulses of force at the end of the log and their rates, (n, n_outputs, n_bins)
    forces: FloatArray  # first of these outputs on the fine grid, (n, n_fine)

    def taken_from(self, changed: ComplexArray, moment: float) -> ComplexArray:
        """Outputs that change at a moment, without the motion that fits them where their change should be zero."""
        if not len(self.outputs):
            return changed
        time, margin = self.record.fine_time, _UNSETTLED * self.record.fine_time[1]
        first, last = np.searchsorted(time, (moment - margin, self.record.duration + margin))
        forces, change = self.forces, self.record.fine(changed[0])
        # Normal equations suffice: a difference of pulses below their resolution changes the outputs as little.
        before, after = slice(first), slice(last, None)
        normal = forces[:, before] @ forces[:, before].T + forces[:, after] @ forces[:, after].T
        onto = forces[:, before] @ change[before] + forces[:, after] @ change[after]
        amounts = least_squares(normal, onto, _ALIKE)
        return np.asarray(changed - np.tensordot(amounts, self.outputs, 1))


def _with_change(
    prediction: Prediction, direction: FloatArray, change: float
) -> tuple[ComplexArray, _FreeMotion]:
    """For the axis with the other mass: outputs for a force on the body, and its motion after the log."""
    record = prediction.record
    inertia = np.asarray(change * (1j * record.omega) ** 2, dtype=np.complex128)
    other = axis_response(record, prediction.parameters, [*prediction.impedances, (direction, inertia)])
    hidden = [other.of_force(free) for free in prediction.free_directions]
    outputs = starting_pulses(record, hidden, (record.duration,))
    forces = record.fine(outputs[:, 0]) if hidden else np.zeros((0, record.n_fine))
    return other.of_force(direction), _FreeMotion(record, outputs, forces)


def _effective_mass(prediction: Prediction, body: RecordedJoint) -> float:
    """Mass of the axis at a body, while the others move as little as they can."""
    d = body.direction
    return float(d @ prediction.response.plant.mass @ d) / float(d @ d) ** 2


def _load(prediction: Prediction, body: RecordedJoint) -> FloatArray:
    """Force of a body by its mass, on the fine grid: its acceleration, and that of its declared weight."""
    return np.asarray(body.a + _gravity(prediction, body))


def _gravity(prediction: Prediction, body: RecordedJoint) -> float:
    """Acceleration by which a body weighs against its positive direction, m/s^2; 0 without a declared weight."""
    weights = (own for own in prediction.axis.elements if isinstance(own, Weight))
    return sum((own.acceleration for own in weights if own.body.name == body.name), start=0.0)


def _later(record: Record, moment: float, points: int = 1) -> FloatArray:
    """A step from 0 to 1 at a moment of the log, over a number of points of the fine grid."""
    time = record.fine_time
    return np.asarray(np.clip(0.5 + (time - moment) / (points * time[1]), 0, 1) * record.in_log)


def _with_sharp_jump(prediction: Prediction, body: RecordedJoint, shape: Shape) -> FloatArray:
    """The load of a driven body with the part of its jump beyond the band of the log, on the fine grid.

    The forces on the body do not jump, so that a(-) + g falls to (a(-) + g) m/(m + dm). The measured acceleration is
    limited to the band and is half-way through the jump at its moment.
    """
    record, (change, moment) = prediction.record, shape
    mass = 1 / float(body.direction @ np.linalg.pinv(prediction.response.plant.mass) @ body.direction)
    share = change / (mass + change)
    load = _load(prediction, body)
    before = float(np.interp(moment, record.fine_time, load)) / (1 - share / 2)
    beyond = record.memory.of("step beyond the band", moment, lambda: _step_beyond_band(record, moment))
    return np.asarray(load - share * before * beyond)


def _step_beyond_band(record: Record, moment: float) -> FloatArray:
    """A step at a moment, which fades, less its part in the band, on the fine grid."""
    fading = np.exp(-np.clip(record.fine_time - moment, 0.0, None) * record.band_hz / _FADES)
    step = _later(record, moment) * fading
    return np.asarray(step - record.fine(record.from_grid(step)))
