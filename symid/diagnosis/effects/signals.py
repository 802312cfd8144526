"""Effects in drives and readings."""

from abc import abstractmethod
from collections.abc import Iterable, Sequence

import numpy as np

from symid.arrays import ComplexArray, FloatArray
from symid.diagnosis.effects.effect import ACTUATOR, Effect, Key, MatchedFilter, Placed, Shape
from symid.diagnosis.prediction.prediction import Prediction
from symid.units import Unit

LATE_FORCES = ("delay", "actuator_lag")
"""Effects that are nearly equal, so that a log does not determine both."""


def time_of(item: Placed) -> float:
    """Time of a delay or lag of a force, s."""
    (time,) = item.shape or item.amplitudes
    return time


def with_equivalents(keys: Iterable[Key]) -> frozenset[Key]:
    """Effects and places, with those that are nearly equal to one of them: a delay and a lag of the same drive."""
    present = frozenset(keys)
    return present | {(name, at) for own, at in present if own in LATE_FORCES for name in LATE_FORCES}


_LONGEST_DELAY = 0.05
_LONGEST_FILTER = (0.01, 10)  # of a record: s, or samples if these take longer
_STEPS = np.array([0.15, 0.3, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 11.0, 16.0])
_DELAYS = np.concatenate([-_STEPS[::-1], _STEPS])
_LIMITS = (0.05, 0.07, 0.1, 0.13, 0.16, 0.2, 0.25, *(0.05 * k for k in range(6, 20)), 0.98)
"""Force limits that are tried, relative to the largest logged force, which integral windup can raise far above them."""
_USUAL_LIMIT = 0.3  # relative to the largest force; a lower limit may clip few samples only
_MOSTLY_BELOW, _SEARCHED_BELOW = 0.9, 0.7
"""Shares of the samples that a plausible limit leaves alone, and one that is tried: an integrator winds up for long."""
_MOST_BEND, _USUAL_BEND = 0.9, 0.6  # change of the gain at the largest force, relative to the gain
_BUT_FOR_PEAKS = 0.98
"""Share of the samples to which the former applies: a loop with such a gain has force peaks."""


class DriveEffect(Effect):
    """An effect between the logged force and the acting force; with several drives, its place is the signal of one."""

    def places(self, prediction: Prediction) -> Iterable[str]:
        forces = prediction.record.forces
        return forces if len(forces) > 1 else (ACTUATOR,)

    @property
    def is_of_command(self) -> bool:
        return True

    def _force(self, prediction: Prediction, place: str, *changes: ComplexArray) -> ComplexArray:
        """Columns that change the predicted force of a drive only."""
        columns = np.zeros((len(changes), *prediction.record.measured.shape), dtype=complex)
        columns[:, drive_at(prediction, place)] = changes
        return columns


class CommandEffect(DriveEffect):
    """An effect whose force follows from the logged one at each instant."""

    @abstractmethod
    def added(self, force: FloatArray, shape: Shape) -> FloatArray:
        """Force that it adds to a logged one, for a unit amplitude."""

    def columns(self, prediction: Prediction, place: str, shape: Shape) -> ComplexArray:
        record, force, key = prediction.record, _whole_force(prediction, place), (self, place)
        signal = force_at(record.forces, place)
        change = record.memory.of(key, shape, lambda: record.in_time(signal, self.added(force, shape)))
        return self._force(prediction, place, change)


def drive_at(prediction: Prediction, place: str) -> int:
    """Index of the drive at a place."""
    forces = prediction.record.forces
    return forces.index(force_at(forces, place))


def force_at(forces: Sequence[str], place: str) -> str:
    """Signal of the drive at a place, from the signals of all drives."""
    return forces[0] if place == ACTUATOR else place


def _whole_force(prediction: Prediction, place: str) -> FloatArray:
    """Logged force of a drive at all samples of a period."""
    return np.asarray(prediction.record.whole_forces[drive_at(prediction, place)])


class TransferEffect(Effect):
    """An effect that adds to one predicted output the same output filtered by a transfer function."""

    @property
    def is_of_command(self) -> bool:
        return False

    @abstractmethod
    def transfer(self, prediction: Prediction, shape: Shape) -> ComplexArray:
        """The transfer function for unit amplitude, of shape (n_bins,)."""

    def output(self, prediction: Prediction, place: str) -> int:
        """Index of the output; the force of the drive by default."""
        return drive_at(prediction, place)

    def columns(self, prediction: Prediction, place: str, shape: Shape) -> ComplexArray:
        return self._under(prediction, place, shape, prediction.outputs)[None]

    def passed_on(self, prediction: Prediction, placed: Placed, outputs: ComplexArray) -> ComplexArray:
        return np.asarray(placed.amplitudes[0] * self._under(prediction, placed.at, placed.shape, outputs))

    def _under(self, prediction: Prediction, place: str, shape: Shape, outputs: ComplexArray) -> ComplexArray:
        changed, at = np.zeros_like(outputs), self.output(prediction, place)
        memory = prediction.record.memory
        transfer = memory.of((self, "transfer"), shape, lambda: self.transfer(prediction, shape))
        changed[..., at, :] = transfer * outputs[..., at, :]
        return changed


class TimeEffect(TransferEffect):
    """An effect whose only value is a time T: a delay, or the time constant of a filter."""

    amplitudes = ("share",)
    shape_names = ("T",)
    fixed = True

    def is_plausible(self, prediction: Prediction, placed: Placed) -> bool:
        return abs(placed.shape[0]) < _LONGEST_DELAY

    def units(self, prediction: Prediction, place: str) -> tuple[str, ...]:
        return "1", "s"


class DelayEffect(TimeEffect, DriveEffect):
    """The force acts later than logged: u(t - T)."""

    name = "delay"

    def shapes(self, prediction: Prediction, place: str, matched_filter: MatchedFilter) -> Iterable[Shape]:
        return [(float(x * prediction.record.log.sampling_period),) for x in _DELAYS]

    def transfer(self, prediction: Prediction, shape: Shape) -> ComplexArray:
        return np.asarray(np.expm1(1j * prediction.record.omega * shape[0]), dtype=np.complex128)


class ActuatorLagEffect(TransferEffect, DriveEffect):
    """The force follows the logged one as a first-order system: T u(1) + u = logged."""

    name = "actuator_lag"
    amplitudes = ("T",)
    positive = True

    def transfer(self, prediction: Prediction, shape: Shape) -> ComplexArray:
        return np.asarray(1j * prediction.record.omega, dtype=np.complex128)

    def units(self, prediction: Prediction, place: str) -> tuple[str, ...]:
        return ("s",)


class RecordedLagEffect(TimeEffect, DriveEffect):
    """The force is recorded through a first-order filter, as filtered currents are: it acts earlier, T < 0."""

    name = "actuator_lag"

    def is_possible(self, prediction: Prediction, placed: Placed) -> bool:
        """Recorders filter over milliseconds or some samples; a longer time stands for slow friction."""
        longest = max(_LONGEST_FILTER[0], _LONGEST_FILTER[1] * prediction.record.log.sampling_period)
        return -longest < placed.shape[0] < 0.0

    def shapes(self, prediction: Prediction, place: str, matched_filter: MatchedFilter) -> Iterable[Shape]:
        return [(float(-x * prediction.record.log.sampling_period),) for x in _STEPS]

    def bounded(self, prediction: Prediction, place: str, shape: Shape) -> Shape:
        return (float(np.clip(shape[0], -_LONGEST_DELAY, 0.0)),)

    def transfer(self, prediction: Prediction, shape: Shape) -> ComplexArray:
        return np.asarray(1 / (1 - 1j * prediction.record.omega * shape[0]) - 1, dtype=np.complex128)


class SaturationEffect(CommandEffect):
    """The force does not exceed a limit."""

    name = "saturation"
    amplitudes = ("share",)
    shape_names = ("limit",)
    fixed = True

    def is_plausible(self, prediction: Prediction, placed: Placed) -> bool:
        return placed.shape[0] > 1.01 * _least_limit(prediction, placed.at, _MOSTLY_BELOW)

    def shapes(self, prediction: Prediction, place: str, matched_filter: MatchedFilter) -> Iterable[Shape]:
        top, least = _top_force(prediction, place), _least_limit(prediction, place, _SEARCHED_BELOW)
        return [(share * top,) for share in _LIMITS if share * top > least]

    def bounded(self, prediction: Prediction, place: str, shape: Shape) -> Shape:
        least, top = _least_limit(prediction, place, _SEARCHED_BELOW), _top_force(prediction, place)
        return (float(np.clip(shape[0], least, top)),)

    def added(self, force: FloatArray, shape: Shape) -> FloatArray:
        return np.asarray(force - np.clip(force, -shape[0], shape[0]))

    def units(self, prediction: Prediction, place: str) -> tuple[str, ...]:
        return "1", str(_drive_unit(prediction, place))


class GainNonlinearityEffect(CommandEffect):
    """The force is not proportional to the logged one: a term in its square (with sign) or cube."""

    name = "gain_nonlinearity"
    amplitudes = ("bend",)

    def __init__(self, power: int) -> None:
        self.power = power

    def is_possible(self, prediction: Prediction, placed: Placed) -> bool:
        """The force increases with the command, except in short peaks."""
        return self._change(prediction, placed) < _MOST_BEND

    def is_plausible(self, prediction: Prediction, placed: Placed) -> bool:
        """The gain changes by a limited factor, except in short peaks, as at the shock of a payload."""
        return self._change(prediction, placed) < _USUAL_BEND

    def _change(self, prediction: Prediction, placed: Placed) -> float:
        """Relative change of the gain at the force that all but short peaks do not exceed."""
        largest = float(np.quantile(np.abs(_whole_force(prediction, placed.at)), _BUT_FOR_PEAKS))
        return abs(placed.amplitudes[0]) * self.power * largest ** (self.power - 1)

    def added(self, force: FloatArray, shape: Shape) -> FloatArray:
        return np.asarray(force * np.abs(force) ** (self.power - 1))

    def units(self, prediction: Prediction, place: str) -> tuple[str, ...]:
        return (str(_drive_unit(prediction, place) ** (1 - self.power)),)


class GainAsymmetryEffect(CommandEffect):
    """The gain depends on the direction of the force."""

    name = "gain_nonlinearity"
    amplitudes = ("difference",)

    def is_possible(self, prediction: Prediction, placed: Placed) -> bool:
        return abs(placed.amplitudes[0]) < _USUAL_BEND

    def added(self, force: FloatArray, shape: Shape) -> FloatArray:
        return np.abs(force)

    def units(self, prediction: Prediction, place: str) -> tuple[str, ...]:
        return ("1",)


class SensorDelayEffect(TimeEffect):
    """A reading is late relative to the driven positions, y(t - T), or early if T is negative."""

    name = "sensor_delay"

    def places(self, prediction: Prediction) -> Iterable[str]:
        return prediction.record.readings

    def shapes(self, prediction: Prediction, place: str, matched_filter: MatchedFilter) -> Iterable[Shape]:
        times = [float(x * prediction.record.log.sampling_period) for x in _DELAYS]
        return [(x,) for x in (*times, *_apparent_delay(prediction, place)) if abs(x) < _LONGEST_DELAY]

    def output(self, prediction: Prediction, place: str) -> int:
        return prediction.record.signals.index(place)

    def transfer(self, prediction: Prediction, shape: Shape) -> ComplexArray:
        return np.asarray(np.expm1(-1j * prediction.record.omega * shape[0]), dtype=np.complex128)


def _apparent_delay(prediction: Prediction, place: str) -> list[float]:
    """Delay of a position relative to the driven one, if that is their only difference: y = r q + z - T r dq/dt."""
    record = prediction.record
    if record.dynamics.sensors[place][1] or record.n_drives > 1:
        return []
    q, y = (record.log[name] for name in (record.signals[0], place))
    speed = np.gradient(q, record.log.sampling_period)
    ratio, late, _ = np.linalg.lstsq(np.stack([q, speed, np.ones_like(q)]).T, y, rcond=None)[0]
    return [float(-late / ratio)] if ratio and late else []


def _drive_unit(prediction: Prediction, place: str) -> Unit:
    record = prediction.record
    return prediction.axis.signal_units[record.forces[drive_at(prediction, place)]]


def _least_limit(prediction: Prediction, place: str, share: float) -> float:
    """Lowest force limit that leaves a share of the samples alone, or one that is usual."""
    usual = float(np.quantile(_force_size(prediction, place), share))
    return min(_USUAL_LIMIT * _top_force(prediction, place), usual)


def _top_force(prediction: Prediction, place: str) -> float:
    """Largest force of the log, except for its last samples, since a log may end during an impact."""
    force = _force_size(prediction, place)
    return float(force[: -max(1, force.size // 100)].max())


def _force_size(prediction: Prediction, place: str) -> FloatArray:
    return np.asarray(np.abs(_whole_force(prediction, place)[: prediction.record.log.n_samples]))
