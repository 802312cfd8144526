"""An axis in one mode and its linear controller as one discrete linear system.

Its state z holds the state of the axis, that of the controller, and readings on their way to it; its inputs w are the
reference, the noise of the readings and the given force. A controller that remembers its last reading takes the
difference to the present one, divided by the period: here z holds that difference, which rounding spares.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symid.arrays import FloatArray
from symid.simulation.controller import LinearLaw
from symid.simulation.loop import Loop
from symid.simulation.mode import StickSlipMode
from symid.simulation.reading import Reader


@dataclass(frozen=True, eq=False)
class LoopSystem:
    """z[k + 1] = matrix @ z + inputs @ w + offset; force = force_state @ z + force_input @ w.

    Parameters
    ----------
    matrix : array of shape (m, m)
    inputs : array of shape (m, n_inputs)
    offset : array of shape (m,)
    force_state : array of shape (m,)
    force_input : array of shape (n_inputs,)
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


def loop_system(loop: Loop, mode: StickSlipMode, law: LinearLaw) -> LoopSystem:
    """The system of a loop in a mode without varying laws."""
    n, n_memory = 2 * len(mode.plant.bodies), len(law.C)
    pipes = _pipes(n + n_memory, loop.controlled)
    size = max([n + n_memory, *(pipe.stop for pipe in pipes)])
    readings = _readings(loop, mode, pipes, size)
    last = _last_readings(law, pipes)
    memory = np.eye(n_memory, size, n)
    for i, s in last.items():
        memory[i] = readings[s] - memory[i]
    force_state = law.D[3:] @ readings + law.C @ memory
    force_input = np.append(law.D, 1.0)
    step = mode.step(loop.period)
    change = np.outer(step.drive, force_state)
    change[:, :n] += step.transition - np.eye(n)
    change_input = np.outer(step.drive, force_input)
    matrix, inputs, offset = np.zeros((size, size)), np.zeros((size, force_input.size)), np.zeros(size)
    matrix[:n], inputs[:n], offset[:n] = np.eye(n, size) + change, change_input, step.offset
    remembered = slice(n, n + n_memory)
    matrix[remembered] = law.A @ memory + law.B[:, 3:] @ readings
    inputs[remembered, :-1] = law.B
    for i, s in last.items():
        row = readings[s, :n]
        matrix[n + i], inputs[n + i], offset[n + i] = row @ change, row @ change_input, row @ step.offset
        inputs[n + i, 3 + s] -= 1.0
    for reader, pipe in zip(loop.controlled, pipes, strict=True):
        if pipe.stop > pipe.start:
            row, drive, constant = reader.of_begin(mode) if reader.is_between else reader.of_state(mode)
            matrix[pipe.start] = drive * force_state
            matrix[pipe.start, :n] += row
            inputs[pipe.start], offset[pipe.start] = drive * force_input, constant
            matrix[range(pipe.start + 1, pipe.stop), range(pipe.start, pipe.stop - 1)] = 1.0
    return LoopSystem(matrix, inputs, offset, force_state, force_input, memory, pipes)


def _pipes(begin: int, readers: Sequence[Reader]) -> tuple[slice, ...]:
    pipes = []
    for reader in readers:
        pipes.append(slice(begin, begin + reader.age + reader.is_between))
        begin = pipes[-1].stop
    return tuple(pipes)


def _readings(loop: Loop, mode: StickSlipMode, pipes: Sequence[slice], size: int) -> FloatArray:
    """Readings of the controller as rows on z."""
    rows = np.zeros((len(pipes), size))
    for row, reader, pipe in zip(rows, loop.controlled, pipes, strict=True):
        if pipe.stop > pipe.start:
            row[pipe.stop - 1] = 1.0
        else:
            row[: 2 * len(mode.plant.bodies)] = reader.of_state(mode)[0]
    return rows


def _last_readings(law: LinearLaw, pipes: Sequence[slice]) -> dict[int, int]:
    """Which parts of a controller's state are the last reading of which sensor without delay."""
    units = np.hstack([np.zeros((len(pipes), 3)), np.eye(len(pipes))])
    return {
        i: s
        for i in range(len(law.C))
        for s, pipe in enumerate(pipes)
        if pipe.stop == pipe.start and not law.A[i].any() and np.array_equal(law.B[i], units[s])
    }
