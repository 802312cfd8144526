"""Blocks of samples of a linear controller and an axis in one mode, by a linear recursion.

The whole block is computed first; then it is kept up to the last sample in which no sliding joint turns round, every
stuck joint holds, and the controller is linear.

The state z of the recursion holds the state of the axis, those of the controllers, and readings on their way to them;
its inputs w are the references, the noise of the readings and the given forces. A controller that remembers its last
reading takes the difference to the present one, divided by the period: here z holds that difference, which rounding
spares.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symid.arrays import BoolArray, FloatArray
from symid.simulation.loop import Loop, LoopLaw
from symid.simulation.mode import StickSlipMode
from symid.simulation.recursion import Recursion
from symid.simulation.sensor_channel import MotionRecord

_LARGEST = 16
"""Largest number of states for a recursion; with more, such as a long delay, single samples are faster."""


class LinearLoop:
    """The recursion of a loop in one mode."""

    def __init__(self, loop: Loop, mode: StickSlipMode, law: LoopLaw) -> None:
        self._loop, self._mode = loop, mode
        self._system = loop_system(loop, mode, law)
        self._inputs = self._system.inputs.T.copy()
        self._recursion = Recursion(self._system.matrix)

    @staticmethod
    def applies(loop: Loop, mode: StickSlipMode) -> bool:
        """Whether a loop in this mode is a linear recursion: nothing varies or is rounded, and it is not too large."""
        size = 2 * len(mode.plant.bodies) + sum(reader.age + 1 for reader in loop.controlled)
        return (
            loop.law is not None
            and loop.steps == 1
            and not any(law.timed for law in mode.plant.laws)
            and not mode.varying
            and size + len(loop.law.A) <= _LARGEST * loop.n_drives
            and all(
                reader.step == 0 and reader.misread is None and reader.order < 2 for reader in loop.controlled
            )
        )

    def advance(self, record: MotionRecord, k: int, end: int, memory: FloatArray) -> tuple[int, FloatArray]:
        """Advance from sample k up to `end`; returns the samples made and the controller's state after them."""
        system, inputs, n = self._system, self._loop.inputs[k:end], record.states.shape[1]
        with np.errstate(all="ignore"):
            states = self._recursion.states(
                self._start(record, k, memory), inputs @ self._inputs + system.offset
            )
            forces = states[:-1] @ system.force_state.T + inputs @ system.force_input.T
            good = self._is_smooth(states[:, :n], forces)
        made = len(good) if good.all() else int(np.argmin(good))
        self._write(record, k, states[: made + 1, :n], forces[:made])
        return made, np.asarray(system.memory @ states[made])

    def _start(self, record: MotionRecord, k: int, memory: FloatArray) -> FloatArray:
        system, n = self._system, record.states.shape[1]
        start = np.zeros(len(system.matrix))
        start[:n] = record.states[k]
        for reader, pipe in zip(self._loop.controlled, system.pipes, strict=True):
            if pipe.stop > pipe.start:
                past = reader.past(record, k)
                start[pipe] = (past if reader.is_between else past[:-1])[::-1]
        held = slice(n, n + memory.size)
        own = system.memory[:, held]  # diagonal, with 1 or -1: its own inverse
        start[held] = own @ (memory - system.memory @ start)
        return start

    def _is_smooth(self, states: FloatArray, forces: FloatArray) -> BoolArray:
        """For each sample, whether its force is that of the linear law and no event happens until the next one."""
        mode, n = self._mode, states.shape[1]
        good = np.all(np.abs(forces) <= self._loop.limits, axis=1)
        # The block ends before the first sample with an event; the engine makes that sample and locates the event.
        for speed in mode.speeds:
            good &= states[1:] @ speed >= 0.0
        for row, (low, high) in zip(mode.flow.holding_rows, mode.limits(states[0]), strict=True):
            pushed = forces @ (row[n:] @ mode.plant.drives) + row[n:] @ mode.constant
            needed = states @ row[:n]
            for held in (needed[:-1] + pushed, needed[1:] + pushed):
                good &= (held >= low) & (held <= high)
        return np.asarray(good)

    def _write(self, record: MotionRecord, k: int, states: FloatArray, forces: FloatArray) -> None:
        mode, end, n = self._mode, k + len(forces), states.shape[1]
        record.states[k + 1 : end + 1] = states[1:]
        record.forces[k:end] = forces
        if self._loop.is_accelerated:
            rows = mode.flow.acceleration_rows
            pushed = forces @ (rows[:, n:] @ mode.plant.drives).T + rows[:, n:] @ mode.constant
            record.accelerations[k + 1 : end + 1] = states[1:] @ rows[:, :n].T + pushed
        for reader in self._loop.between:
            row, drives, constant = reader.of_begin(mode)
            record.between[reader.signal][k:end] = states[:-1] @ row + forces @ drives + constant


@dataclass(frozen=True, eq=False)
class LoopSystem:
    """z[k + 1] = matrix @ z + inputs @ w + offset; forces = force_state @ z + force_input @ w.

    Parameters
    ----------
    matrix : array of shape (m, m)
    inputs : array of shape (m, n_inputs)
    offset : array of shape (m,)
    force_state : array of shape (n_drives, m)
    force_input : array of shape (n_drives, n_inputs)
    memory : array of shape (n_memory, m)
        The controller's state is memory @ z. Its own columns are diagonal, with 1 or -1.
    pipes : tuple of slice
        Places of each controlled sensor's readings on their way, newest first; empty without delay.
    """

    matrix: FloatArray
    inputs: FloatArray
    offset: FloatArray
    force_state: FloatArray
    force_input: FloatArray
    memory: FloatArray
    pipes: tuple[slice, ...]


def loop_system(loop: Loop, mode: StickSlipMode, law: LoopLaw) -> LoopSystem:
    """The system of a loop in a mode without varying laws."""
    n, n_memory = 2 * len(mode.plant.bodies), len(law.A)
    pipes: list[slice] = []
    size = n + n_memory
    for reader in loop.controlled:
        pipes.append(slice(size, size + reader.age + reader.is_between))
        size = pipes[-1].stop
    # readings of the controllers as rows on z
    readings = np.zeros((len(pipes), size))
    for row, reader, pipe in zip(readings, loop.controlled, pipes, strict=True):
        if pipe.stop > pipe.start:
            row[pipe.stop - 1] = 1.0
        else:
            row[:n] = reader.of_state(mode)[0]
    # Where the controller remembers its last reading, z holds present less last reading instead: the memory is their
    # difference, read off again.
    last = _last_readings(law, pipes)
    memory = np.eye(n_memory, size, n)
    for i, s in last.items():
        memory[i] = readings[s] - memory[i]
    n_drives = len(law.D)
    references = 3 * n_drives
    force_state = law.D[:, references:] @ readings + law.C @ memory
    force_input = np.hstack([law.D, np.eye(n_drives)])
    # The axis: `change` is what a sample adds to its state. Differences of readings follow from `change` alone, so
    # that the readings themselves, which are far larger, do not round them.
    step = mode.step(loop.period)
    change = step.drives @ force_state
    change[:, :n] += step.transition - np.eye(n)
    change_input = step.drives @ force_input
    matrix, inputs, offset = np.zeros((size, size)), np.zeros((size, force_input.shape[1])), np.zeros(size)
    matrix[:n], inputs[:n], offset[:n] = np.eye(n, size) + change, change_input, step.offset
    # The controllers.
    remembered = slice(n, n + n_memory)
    matrix[remembered] = law.A @ memory + law.B[:, references:] @ readings
    inputs[remembered, :-n_drives] = law.B
    for i, s in last.items():
        row = readings[s, :n]
        matrix[n + i], inputs[n + i], offset[n + i] = row @ change, row @ change_input, row @ step.offset
        inputs[n + i, references + s] -= 1.0
    # Delayed readings: a new one enters its shift register, the others move on by one place.
    for reader, pipe in zip(loop.controlled, pipes, strict=True):
        if pipe.stop > pipe.start:
            row, drives, constant = reader.of_begin(mode) if reader.is_between else reader.of_state(mode)
            matrix[pipe.start] = drives @ force_state
            matrix[pipe.start, :n] += row
            inputs[pipe.start], offset[pipe.start] = drives @ force_input, constant
            matrix[range(pipe.start + 1, pipe.stop), range(pipe.start, pipe.stop - 1)] = 1.0
    return LoopSystem(matrix, inputs, offset, force_state, force_input, memory, tuple(pipes))


def _last_readings(law: LoopLaw, pipes: Sequence[slice]) -> dict[int, int]:
    """Which parts of a controller's state are the last reading of which sensor without delay."""
    units = np.hstack([np.zeros((len(pipes), 3 * len(law.D))), np.eye(len(pipes))])
    return {
        i: s
        for i in range(len(law.A))
        for s, pipe in enumerate(pipes)
        if pipe.stop == pipe.start and not law.A[i].any() and np.array_equal(law.B[i], units[s])
    }
