"""Blocks of samples of a linear controller and an axis in one mode, by a linear recursion.

The whole block is computed first; then it is kept up to the last sample in which no sliding joint turns round, every
stuck joint holds, and the controller is linear.
"""

from __future__ import annotations

import numpy as np

from symid.arrays import BoolArray, FloatArray
from symid.simulation.controller import LinearLaw
from symid.simulation.loop import Loop
from symid.simulation.loop_system import loop_system
from symid.simulation.mode import StickSlipMode
from symid.simulation.record import MotionRecord
from symid.simulation.recursion import Recursion

_LARGEST = 16
"""Largest number of states for a recursion; with more, such as a long delay, single samples are faster."""


class LinearLoop:
    """The recursion of a loop in one mode.

    Parameters
    ----------
    loop : Loop
        Axis and controller.
    mode : StickSlipMode
        Which joints slide or stick.
    law : LinearLaw
        The controller.
    """

    def __init__(self, loop: Loop, mode: StickSlipMode, law: LinearLaw) -> None:
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
            and not mode.varying
            and size + len(loop.law.C) <= _LARGEST
            and all(reader.step == 0 and reader.order < 2 for reader in loop.controlled)
        )

    def advance(self, record: MotionRecord, k: int, end: int, memory: FloatArray) -> tuple[int, FloatArray]:
        """Advance from sample k up to `end`; returns the samples made and the controller's state after them."""
        system, inputs, n = self._system, self._loop.inputs[k:end], record.states.shape[1]
        with np.errstate(all="ignore"):
            states = self._recursion.states(
                self._start(record, k, memory), inputs @ self._inputs + system.offset
            )
            forces = states[:-1] @ system.force_state + inputs @ system.force_input
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
        good = np.abs(forces) <= self._loop.limit
        # The block ends before the first sample with an event; the engine makes that sample and locates the event.
        for speed in mode.speeds:
            good &= states[1:] @ speed >= 0.0
        for row, (low, high) in zip(mode.flow.holding_rows, mode.limits(states[0]), strict=True):
            pushed = forces * (row[n:] @ mode.plant.drive) + row[n:] @ mode.constant
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
            pushed = np.outer(forces, rows[:, n:] @ mode.plant.drive) + rows[:, n:] @ mode.constant
            record.accelerations[k + 1 : end + 1] = states[1:] @ rows[:, :n].T + pushed
        for reader in self._loop.between:
            row, drive, constant = reader.of_begin(mode)
            record.between[reader.signal][k:end] = states[:-1] @ row + drive * forces + constant
