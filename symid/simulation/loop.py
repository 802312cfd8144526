"""An axis with its controller: the constants of a simulation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from symid.arrays import FloatArray
from symid.errors import SettingError
from symid.simulation.controller import Command, Controller, LinearLaw, linear_law
from symid.simulation.imperfect_plant import Moment
from symid.simulation.plant import Plant
from symid.simulation.sensor_channel import SensorChannel
from symid.simulation.trajectory import Trajectory

RUNAWAY = 1e100
"""Drive force beyond which the loop counts as unstable."""


@dataclass(frozen=True, eq=False)
class Loop:
    """A plant under a controller along a trajectory.

    Parameters
    ----------
    plant : Plant
        The axis.
    trajectory : Trajectory
        Reference; its sampling period is the controller's.
    controller : Controller
        The controller.
    readers : sequence of SensorChannel
        All sensors.
    steps : int
        Steps of the engine in one sample.
    moment : Moment, optional
        On which laws of the plant depend beside the motion.
    """

    plant: Plant
    trajectory: Trajectory
    controller: Controller
    readers: Sequence[SensorChannel]
    steps: int
    moment: Moment | None = None

    @property
    def period(self) -> float:
        """Time between two samples, s."""
        return self.trajectory.sampling_period

    @cached_property
    def law(self) -> LinearLaw | None:
        """The controller as matrices, if it can be written so."""
        return linear_law(self.controller, self.period)

    @cached_property
    def limit(self) -> float:
        """Largest force for which `law` holds."""
        return min(self.law.limit, RUNAWAY) if self.law else 0.0

    @cached_property
    def controlled(self) -> tuple[SensorChannel, ...]:
        """Sensors that the controller reads; SettingError if the axis has no such sensor."""
        by_signal = {reader.signal: reader for reader in self.readers}
        if unknown := [signal for signal in self.controller.signals if signal not in by_signal]:
            raise SettingError(
                f"the controller reads {unknown[0]!r}, which is not a sensor of this axis: use {', '.join(by_signal)}"
            )
        return tuple(by_signal[signal] for signal in self.controller.signals)

    @cached_property
    def between(self) -> tuple[SensorChannel, ...]:
        """Sensors whose values are taken between two samples."""
        return tuple(reader for reader in self.readers if reader.is_between)

    @cached_property
    def is_accelerated(self) -> bool:
        """Whether a sensor reads an acceleration."""
        return any(reader.order == 2 for reader in self.readers)

    @cached_property
    def inputs(self) -> FloatArray:
        """Reference, noise of the controlled signals and given force, of shape (n_samples, 3 + n_signals + 1)."""
        path, law = self.trajectory, self.law
        given = np.zeros(path.n_samples)
        if law and law.given.size:
            given = law.given[np.minimum(np.arange(path.n_samples), law.given.size - 1)]
        noise = [reader.noise for reader in self.controlled]
        return np.column_stack([path.position, path.velocity, path.acceleration, *noise, given])

    @cached_property
    def pieces(self) -> tuple[tuple[float, tuple[SensorChannel, ...]], ...]:
        """Durations into which a sample is cut, each with the sensors that take their value at its end."""
        moments: dict[float, tuple[SensorChannel, ...]] = {
            self.period * i / self.steps: () for i in range(1, self.steps + 1)
        }
        for reader in self.between:
            moments[reader.moment] = (*moments.get(reader.moment, ()), reader)
        if not self.between:
            return ((self.period / self.steps, ()),) * self.steps
        ends = sorted(moments)
        return tuple((end - begin, moments[end]) for begin, end in zip([0.0, *ends], ends, strict=False))

    def at(self, k: int, force: float) -> None:
        """Set what laws depend on beside the motion: the middle of sample k, and the force that acts."""
        if self.moment is not None:
            self.moment.time, self.moment.load = (k + 0.5) * self.period, abs(force)

    def force(
        self, k: int, reference: Sequence[float], readings: Sequence[float], memory: FloatArray
    ) -> tuple[float, FloatArray]:
        """Force of the controller at sample k, and its new state."""
        measured = {reader.signal: value for reader, value in zip(self.controlled, readings, strict=True)}
        force, memory = self.controller.force(Command(k, *reference), measured, memory, self.period)
        if not abs(force) < RUNAWAY:
            raise runaway(self.trajectory.time[k])
        return float(force), memory


def runaway(time: float) -> SettingError:
    """Error message of an unstable loop."""
    return SettingError(f"the axis runs away at t = {time:g} s: lower the controller's gains")
