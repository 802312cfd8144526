"""An axis with its controllers: the constants of a simulation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.linalg import block_diag

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
class LoopLaw:
    """The linear laws of all drives as one: state' = A state + B w, forces = C state + D w + given.

    w holds the references of all drives, position, velocity and acceleration of each, then the readings.

    Parameters
    ----------
    A : array of shape (n_state, n_state)
    B : array of shape (n_state, 3 n_drives + n_signals)
    C : array of shape (n_drives, n_state)
    D : array of shape (n_drives, 3 n_drives + n_signals)
    limits : tuple of float
        Largest force of each drive for which the matrices are valid.
    is_given : tuple of bool
        Which drives have a given force.
    """

    A: FloatArray
    B: FloatArray
    C: FloatArray
    D: FloatArray
    limits: tuple[float, ...]
    is_given: tuple[bool, ...]

    @classmethod
    def of(cls, laws: Sequence[LinearLaw], places: Sequence[Sequence[int]]) -> LoopLaw:
        """The laws of all drives, and the places of the readings of each among all."""
        n_signals = 1 + max((place for own in places for place in own), default=-1)
        inputs = [
            [*range(3 * i, 3 * i + 3), *(3 * len(laws) + place for place in own)]
            for i, own in enumerate(places)
        ]
        n_inputs = 3 * len(laws) + n_signals
        B, D = np.zeros((sum(len(law.A) for law in laws), n_inputs)), np.zeros((len(laws), n_inputs))
        first = 0
        for i, (law, columns) in enumerate(zip(laws, inputs, strict=True)):
            B[first : first + len(law.A), columns], D[i, columns] = law.B, law.D
            first += len(law.A)
        return cls(
            A=block_diag(*(law.A for law in laws)),
            B=B,
            C=block_diag(*(law.C.reshape(1, -1) for law in laws)),
            D=D,
            limits=tuple(min(law.limit, RUNAWAY) for law in laws),
            is_given=tuple(law.given.size > 0 for law in laws),
        )


@dataclass(frozen=True, eq=False)
class Loop:
    """A plant whose drives are under controllers along trajectories, whose sampling period is that of the controllers.

    The engine makes `steps` in one sample. Laws of the plant may depend on a `moment` beside the motion.
    """

    plant: Plant
    trajectories: tuple[Trajectory, ...]
    controllers: tuple[Controller, ...]
    readers: Sequence[SensorChannel]
    steps: int
    moment: Moment | None = None

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
        """The controllers as matrices, if all can be written so."""
        laws = [law for law in self._laws if law is not None]
        if len(laws) < self.n_drives:
            return None
        signals = [reader.signal for reader in self.controlled]
        return LoopLaw.of(laws, [[signals.index(s) for s in c.signals] for c in self.controllers])

    @cached_property
    def limits(self) -> tuple[float, ...]:
        """Largest force of each drive for which `law` holds."""
        return self.law.limits if self.law else (0.0,) * self.n_drives

    @cached_property
    def start(self) -> Any:
        """State of the controllers: one array if `law` holds for it, else an array for each."""
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
        return tuple(by_signal[signal] for signal in signals)

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
        """References, noise of the controlled signals and given forces by sample, in columns."""
        samples = np.arange(self.trajectories[0].n_samples)
        given = [
            law.given[np.minimum(samples, law.given.size - 1)]
            if law is not None and law.given.size
            else np.zeros(samples.size)
            for law in self._laws
        ]
        paths = [x for path in self.trajectories for x in (path.position, path.velocity, path.acceleration)]
        return np.column_stack([*paths, *(reader.noise for reader in self.controlled), *given])

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

    def at(self, k: int, forces: Sequence[float]) -> None:
        """Set what laws depend on beside the motion: the middle of sample k, and the size of the forces that act."""
        if self.moment is not None:
            self.moment.time, self.moment.load = (k + 0.5) * self.period, sum(map(abs, forces))

    def force(
        self, k: int, references: Sequence[float], readings: Sequence[float], memory: Any
    ) -> tuple[tuple[float, ...], Any]:
        """Forces of the controllers at sample k, and their new state, as `start`."""
        measured = {reader.signal: value for reader, value in zip(self.controlled, readings, strict=True)}
        states = np.split(memory, self._ends) if self.law else memory
        forces, kept = [], []
        for i, (controller, state) in enumerate(zip(self.controllers, states, strict=True)):
            command = Command(k, *references[3 * i : 3 * i + 3])
            force, after = controller.force(command, measured, state, self.period)
            if not abs(force) < RUNAWAY:
                raise runaway(self.trajectories[0].time[k])
            forces.append(float(force))
            kept.append(after)
        return tuple(forces), np.concatenate(kept) if self.law else tuple(kept)

    @cached_property
    def _ends(self) -> list[int]:
        """Where the states of the second and later controllers begin."""
        return list(np.cumsum([controller.start.size for controller in self.controllers[:-1]], dtype=int))


def runaway(time: float) -> SettingError:
    """Error message of an unstable loop."""
    return SettingError(f"the axis runs away at t = {time:g} s: lower the controller's gains")
