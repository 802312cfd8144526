"""Effects in the drive and in the readings."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Iterable

import numpy as np

from symid.arrays import ComplexArray, FloatArray
from symid.diagnosis.effects.base import ACTUATOR, Effect, MatchedFilter, Placed, Shape
from symid.diagnosis.effects.forces import repeating_pitches, ripple
from symid.diagnosis.scene import Joint, Scene

_LONGEST_DELAY = 0.05
_STEPS = np.array([0.15, 0.3, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 11.0, 16.0])
_DELAYS = np.concatenate([-_STEPS[::-1], _STEPS])
_LIMITS = (0.05, 0.07, 0.1, 0.13, 0.16, 0.2, 0.25, *(0.05 * k for k in range(6, 20)), 0.98)
"""Of the largest logged force: a controller that winds up asks for many times what the drive gives."""
_STEEPEST_RIPPLE = 0.2
_USUAL_LIMIT = 0.3
"""Of the largest force; below it a limit may cut few samples: an axis without force would show no error either."""
_MOSTLY_BELOW = 0.9


class DriveEffect(Effect):
    """An effect between the force that is logged and the one that acts."""

    def places(self, scene: Scene) -> Iterable[str]:
        return (ACTUATOR,)

    def _force(self, scene: Scene, *changes: ComplexArray) -> ComplexArray:
        """Changes of the predicted force, none of the further readings."""
        columns = np.zeros((len(changes), *scene.record.measured.shape), dtype=complex)
        columns[:, 0] = changes
        return columns


class TransferEffect(Effect):
    """An effect that adds to one predicted output that output under a transfer function."""

    @abstractmethod
    def transfer(self, scene: Scene, shape: Shape) -> ComplexArray:
        """The transfer function for unit amplitude, of shape (n_bins,)."""

    def output(self, scene: Scene, place: str) -> int:
        """Which output; the drive force unless said otherwise."""
        return 0

    def columns(self, scene: Scene, place: str, shape: Shape) -> ComplexArray:
        return self._under(scene, place, shape, scene.predicted)[None]

    def passed_on(self, scene: Scene, placed: Placed, outputs: ComplexArray) -> ComplexArray:
        return np.asarray(placed.amplitudes[0] * self._under(scene, placed.at, placed.shape, outputs))

    def _under(self, scene: Scene, place: str, shape: Shape, outputs: ComplexArray) -> ComplexArray:
        changed, at = np.zeros_like(outputs), self.output(scene, place)
        changed[..., at, :] = self.transfer(scene, shape) * outputs[..., at, :]
        return changed


class Delay(TransferEffect, DriveEffect):
    """The force acts later than it is logged: u(t - T)."""

    name = "delay"
    amplitudes = ("share",)
    shape_names = ("T",)
    fixed = True

    def is_plausible(self, scene: Scene, placed: Placed) -> bool:
        return abs(placed.shape[0]) < _LONGEST_DELAY

    def shapes(self, scene: Scene, place: str, matched_filter: MatchedFilter) -> Iterable[Shape]:
        return [(float(x * scene.record.log.sampling_period),) for x in _DELAYS]

    def transfer(self, scene: Scene, shape: Shape) -> ComplexArray:
        return np.asarray(np.expm1(1j * scene.record.omega * shape[0]), dtype=np.complex128)

    def units(self, scene: Scene, place: str) -> tuple[str, ...]:
        return "1", "s"


class ActuatorLag(TransferEffect, DriveEffect):
    """The force follows the logged one like a first-order system: T u(1) + u = logged."""

    name = "actuator_lag"
    amplitudes = ("T",)
    positive = True

    def transfer(self, scene: Scene, shape: Shape) -> ComplexArray:
        return np.asarray(1j * scene.record.omega, dtype=np.complex128)

    def units(self, scene: Scene, place: str) -> tuple[str, ...]:
        return ("s",)


class Saturation(DriveEffect):
    """The force does not exceed a limit."""

    name = "saturation"
    amplitudes = ("share",)
    shape_names = ("limit",)
    fixed = True

    def is_plausible(self, scene: Scene, placed: Placed) -> bool:
        return placed.shape[0] > 1.01 * _least_limit(scene)

    def shapes(self, scene: Scene, place: str, matched_filter: MatchedFilter) -> Iterable[Shape]:
        top, least = _top_force(scene), _least_limit(scene)
        return [(share * top,) for share in _LIMITS if share * top > least]

    def bounded(self, scene: Scene, place: str, shape: Shape) -> Shape:
        return (float(np.clip(shape[0], _least_limit(scene), _top_force(scene))),)

    def columns(self, scene: Scene, place: str, shape: Shape) -> ComplexArray:
        force = scene.record.whole_force
        return self._force(scene, scene.record.from_samples(force - np.clip(force, -shape[0], shape[0])))

    def units(self, scene: Scene, place: str) -> tuple[str, ...]:
        return "1", _drive_unit(scene)


_MOST_BEND = 0.6
"""Change of the gain at the largest force, relative to the gain: with 1 more command would give no more force."""


class GainNonlinearity(DriveEffect):
    """The force is not proportional to the logged one: a term in its square (with sign) or cube."""

    name = "gain_nonlinearity"
    amplitudes = ("bend",)

    def __init__(self, power: int) -> None:
        self.power = power

    def is_possible(self, scene: Scene, amplitudes: tuple[float, ...]) -> bool:
        """More command gives more force."""
        largest = float(np.abs(scene.record.whole_force).max())
        return abs(amplitudes[0]) * self.power * largest ** (self.power - 1) < _MOST_BEND

    def columns(self, scene: Scene, place: str, shape: Shape) -> ComplexArray:
        force = scene.record.whole_force
        return self._force(scene, scene.record.from_samples(force * np.abs(force) ** (self.power - 1)))

    def units(self, scene: Scene, place: str) -> tuple[str, ...]:
        unit = scene.axis.signal_units[scene.axis.only_drive.signal]
        return (str(unit ** (1 - self.power)),)


class GainAsymmetry(DriveEffect):
    """The gain differs by the direction of the force."""

    name = "gain_nonlinearity"
    amplitudes = ("difference",)

    def is_possible(self, scene: Scene, amplitudes: tuple[float, ...]) -> bool:
        return abs(amplitudes[0]) < _MOST_BEND

    def columns(self, scene: Scene, place: str, shape: Shape) -> ComplexArray:
        return self._force(scene, scene.record.from_samples(np.abs(scene.record.whole_force)))

    def units(self, scene: Scene, place: str) -> tuple[str, ...]:
        return ("1",)


class EncoderRipple(Effect):
    """A position reading with an error As sin(2 pi q/p) + Ac cos(2 pi q/p)."""

    name = "encoder_ripple"
    amplitudes = ("As", "Ac")
    shape_names = ("pitch",)

    def is_plausible(self, scene: Scene, placed: Placed) -> bool:
        """The reading still rises with the position, by far."""
        slope = math.tau * math.hypot(*placed.amplitudes) / placed.shape[0]
        return slope < _STEEPEST_RIPPLE

    def places(self, scene: Scene) -> Iterable[str]:
        sensors = scene.record.dynamics.sensors
        return [name for name in scene.record.signals if sensors[name][1] == 0]

    def shapes(self, scene: Scene, place: str, matched_filter: MatchedFilter) -> Iterable[Shape]:
        response = self._response(scene, place)
        return repeating_pitches(scene, _reading(scene, place), matched_filter(response), response)

    def columns(self, scene: Scene, place: str, shape: Shape) -> ComplexArray:
        return self._response(scene, place) * self._waves(scene, place, shape)[:, None, :]

    def misreading(self, scene: Scene, placed: Placed) -> ComplexArray | None:
        if placed.at != scene.record.signals[0]:
            return None
        return np.asarray(np.tensordot(placed.amplitudes, self._waves(scene, placed.at, placed.shape), 1))

    def _waves(self, scene: Scene, place: str, shape: Shape) -> ComplexArray:
        """Spectra of the error for unit amplitudes, of shape (n_amplitudes, n_bins)."""
        return scene.record.from_grid(np.stack(ripple(scene, _reading(scene, place), shape[0])))

    def _response(self, scene: Scene, place: str) -> ComplexArray:
        """Outputs as predicted, for an error of the reading."""
        if place == scene.record.signals[0]:
            return -scene.response.of_position
        response = np.zeros_like(scene.response.of_position)
        response[scene.record.signals.index(place)] = 1.0
        return response

    def units(self, scene: Scene, place: str) -> tuple[str, ...]:
        return (str(scene.axis.signal_units[place]),) * 3


class SensorDelay(TransferEffect):
    """A reading is late against the position from which all is predicted: y(t - T); early where T is negative."""

    name = "sensor_delay"
    amplitudes = ("share",)
    shape_names = ("T",)
    fixed = True

    def is_plausible(self, scene: Scene, placed: Placed) -> bool:
        return abs(placed.shape[0]) < _LONGEST_DELAY

    def places(self, scene: Scene) -> Iterable[str]:
        return scene.record.signals[1:]

    def shapes(self, scene: Scene, place: str, matched_filter: MatchedFilter) -> Iterable[Shape]:
        period = scene.record.log.sampling_period
        times = [float(x * period) for x in _DELAYS]
        return [(time,) for time in (*times, *_apparent_delay(scene, place)) if abs(time) < _LONGEST_DELAY]

    def output(self, scene: Scene, place: str) -> int:
        return scene.record.signals.index(place)

    def transfer(self, scene: Scene, shape: Shape) -> ComplexArray:
        return np.asarray(np.expm1(-1j * scene.record.omega * shape[0]), dtype=np.complex128)

    def units(self, scene: Scene, place: str) -> tuple[str, ...]:
        return "1", "s"


def _apparent_delay(scene: Scene, place: str) -> list[float]:
    """Delay of a position against the driven one if nothing else came between them: y = r q + z - T r dq/dt."""
    record = scene.record
    if record.dynamics.sensors[place][1]:
        return []
    q, y = (record.log[name] for name in (record.signals[0], place))
    speed = np.gradient(q, record.log.sampling_period)
    ratio, late, _ = np.linalg.lstsq(np.stack([q, speed, np.ones_like(q)]).T, y, rcond=None)[0]
    return [float(-late / ratio)] if ratio and late else []


def _reading(scene: Scene, signal: str) -> Joint:
    record = scene.record
    place = record.signals.index(signal)
    spectrum = record.measured[place] if place else record.motion
    return Joint(signal, record.dynamics.sensors[signal][0], spectrum, spectrum, record)


def _drive_unit(scene: Scene) -> str:
    return str(scene.axis.signal_units[scene.axis.only_drive.signal])


def _least_limit(scene: Scene) -> float:
    """Lowest limit of the force that is worth a trial."""
    return min(_USUAL_LIMIT * _top_force(scene), float(np.quantile(_force_size(scene), _MOSTLY_BELOW)))


def _top_force(scene: Scene) -> float:
    """Largest force of the log; its last samples, where a log may end in the middle of a blow, do not count."""
    force = _force_size(scene)
    return float(force[: -max(1, force.size // 100)].max())


def _force_size(scene: Scene) -> FloatArray:
    return np.asarray(np.abs(scene.record.whole_force[: scene.record.log.n_samples]))
