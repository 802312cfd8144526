"""An axis with its controllers: everything that stays constant during a simulation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from symid.arrays import FloatArray
from symid.errors import SettingError
from symid.simulation.controllers.controller import Command, Controller, LinearLaw, linear_law
from symid.simulation.loops.sensor_channel import SensorChannel
from symid.simulation.plants.imperfect_plant import DahlMemory
from symid.simulation.plants.plant import Plant
from symid.simulation.trajectories.trajectory import Trajectory

RUNAWAY = 1e100
"""Drive force beyond which the loop counts as unstable."""


class LoopLaw(NamedTuple):
    """The linear laws of all drives as one, in terms of w: the controllers' states, references, readings and forces.

    The references are position, velocity and acceleration for each drive. The forces are the sent ones after the static
    nonlinearities (gains and limits) of the drives.
    """

    after: FloatArray  # shape (n_state, n_w): the state after a sample is after @ w
    # shape (n_drives, n_w): sent forces are sent @ w and given ones; those that act are acting @ w
    sent: FloatArray
    acting: FloatArray
    limits: FloatArray  # shape (n_drives,): largest sent force of each drive for which the matrices are valid

    @classmethod
    def of(cls, laws: Sequence[LinearLaw], places: Sequence[Sequence[int]], n_signals: int) -> LoopLaw:
        """Combine the laws of all drives; `places` are the indices of each controller's readings among all."""
        n_state, n_drives, first = sum(len(law.A) for law in laws), len(laws), 0
        n_known = n_state + 3 * n_drives + n_signals
        after, sent, acting = (np.zeros((m, n_known + n_drives)) for m in (n_state, n_drives, n_drives))
        for i, (law, own) in enumerate(zip(laws, places, strict=True)):
            inputs = [n_state + 3 * i + j for j in range(3)] + [n_state + 3 * n_drives + p for p in own]
            states = slice(first, first + len(law.A))
            columns = [*range(first, states.stop), *inputs]
            after[states, columns], sent[i, columns] = np.hstack([law.A, law.B]), np.append(law.C, law.D)
            if law.E is not None:
                after[states, n_known + i] = law.E
            if law.G is not None:
                acting[i, states] = law.G
            acting[i, n_known + i] = law.H
            first = states.stop
        return cls(after, sent, acting, np.array([min(law.limit, RUNAWAY) for law in laws]))

    @classmethod
    def unknown(cls, n_drives: int, n_signals: int) -> LoopLaw:
        """The law of controllers without matrices; its limits make the loop ask the controllers at every sample."""
        forces = np.zeros((n_drives, 4 * n_drives + n_signals))
        return cls(forces[:0], forces, forces, np.full(n_drives, -1.0))


@dataclass(frozen=True, eq=False)
class Loop:
    """A plant with a controller and a trajectory for each drive; the sampling period is that of the trajectories.

    One sample is advanced in `steps`. Laws of the plant may also depend on `memories`.
    """

    plant: Plant
    trajectories: tuple[Trajectory, ...]
    controllers: tuple[Controller, ...]
    readers: Sequence[SensorChannel]
    steps: int
    memories: tuple[DahlMemory, ...] = ()

    @property
    def period(self) -> float:
        """Time between two samples, s."""
        return self.trajectories[0].sampling_period

    @property
    def n_drives(self) -> int:
        """Number of drives of the axis."""
        return len(self.controllers)

    @cached_property
    def _laws(self) -> tuple[LinearLaw | None, ...]:
        return tuple(linear_law(controller, self.period) for controller in self.controllers)

    @cached_property
    def law(self) -> LoopLaw | None:
        """The controllers as matrices; None if one of them has no matrices."""
        laws = [law for law in self._laws if law is not None]
        if len(laws) < self.n_drives:
            return None
        signals = [reader.signal for reader in self.controlled]
        places = [[signals.index(s) for s in c.signals] for c in self.controllers]
        return LoopLaw.of(laws, places, len(signals))

    @cached_property
    def nonlinearities(self) -> tuple[tuple[str, ...], ...]:
        """Gains and limits in the law of each drive, as NumPy code in terms of F; none without matrices."""
        return tuple(() if law is None else law.nonlinearities for law in self._laws)

    @cached_property
    def start(self) -> Any:
        """Initial state of the controllers: one array if `law` exists, otherwise one array for each."""
        states = [controller.start for controller in self.controllers]
        return np.concatenate(states) if self.law else tuple(states)

    @cached_property
    def controlled(self) -> tuple[SensorChannel, ...]:
        """Sensors that the controllers read; SettingError if the axis has no such sensor."""
        by_signal = {reader.signal: reader for reader in self.readers}
        signals = dict.fromkeys(signal for controller in self.controllers for signal in controller.signals)
        if unknown := [signal for signal in signals if signal not in by_signal]:
            raise SettingError(
                f"the controller reads {unknown[0]!r}, which is not a sensor of this axis: use {', '.join(by_signal)}"
            )
        if nonlinear := [signal for signal in signals if by_signal[signal].law is not None]:
            raise SettingError(
                f"the controller reads {nonlinear[0]!r}, the force of a nonlinear spring: use another sensor"
            )
        return tuple(by_signal[signal] for signal in signals)

    @cached_property
    def between(self) -> tuple[SensorChannel, ...]:
        """Sensors whose values are taken between two samples."""
        return tuple(reader for reader in self.readers if reader.is_between)

    @cached_property
    def is_accelerated(self) -> bool:
        """Whether a sensor reads an acceleration."""
        return any(reader.reading.order == 2 for reader in self.readers)

    @cached_property
    def given(self) -> FloatArray:
        """Given forces, which add to those of the matrices; shape (n_samples, n_drives)."""
        n = self.trajectories[0].n_samples
        return np.column_stack([np.zeros(n) if law is None else law.given_at(n) for law in self._laws])

    @cached_property
    def moments(self) -> tuple[float, ...]:
        """Times within a sample at which its pieces end, s: steps, and moments of sensors."""
        steps = (self.period * i / self.steps for i in range(1, self.steps + 1))
        return tuple(sorted({*steps, *(reader.moment for reader in self.between)}))

    @cached_property
    def durations(self) -> tuple[float, ...]:
        """Durations of the pieces, s."""
        if not self.between:
            return (self.period / self.steps,) * self.steps
        return tuple(end - begin for begin, end in pairwise((0.0, *self.moments)))

    def force(
        self, k: int, references: Sequence[float], readings: Sequence[float], memory: Any
    ) -> tuple[tuple[float, ...], Any]:
        """Forces of the controllers at sample k, and their new state in the form of `start`."""
        measured = {reader.signal: value for reader, value in zip(self.controlled, readings, strict=True)}
        ends = np.cumsum([controller.start.size for controller in self.controllers[:-1]], dtype=int)
        states = np.split(memory, ends) if self.law else memory
        forces, kept = [], []
        for i, (controller, state) in enumerate(zip(self.controllers, states, strict=True)):
            command = Command(k, *references[3 * i : 3 * i + 3])
            force, after = controller.force(command, measured, state, self.period)
            if not abs(force) < RUNAWAY:
                raise runaway(self.trajectories[0].time[k])
            forces.append(float(force))
            kept.append(after)
        return tuple(forces), np.concatenate(kept) if self.law else tuple(kept)


def runaway(time: float) -> SettingError:
    """Error for an unstable loop."""
    return SettingError(f"the axis runs away at t = {time:g} s: lower the controller's gains")
