"""The course of a simulation: the compiled loop, and the tasks that it leaves to Python.

The compiled loop asks the controllers' own laws where the force of a drive reaches its limit. It stops before a sample
with a stick-slip mode that has not been met yet, and makes that sample once the mode is in its table.
"""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np

from symid.simulation.loops.loop import Loop, LoopLaw, runaway
from symid.simulation.loops.loop_numbers import ChannelNumbers, KnownModes, LawNumbers
from symid.simulation.loops.sensor_channel import MotionRecord


class SimulationRun:
    """A simulation in progress: it begins at the first state of its record, or continues the run `after`."""

    def __init__(self, loop: Loop, record: MotionRecord, after: SimulationRun | None = None) -> None:
        from symid.simulation.compiled_loop import sample_loop  # numba takes 0.3 s to import

        self.loop, self.record, self._compiled = loop, record, sample_loop
        self._made: int = after._made if after else 0
        self._law = loop.law or LoopLaw.unknown(loop.n_drives, len(loop.controlled))
        self._states: Any = after._states if after else loop.start
        self._after = np.zeros(len(self._law.after))
        self._answer: tuple[int, tuple[float, ...]] = (-1, ())
        self._error: Exception | None = None
        self._ask = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64)(self._asked)
        self._laws = LawNumbers.of(loop)
        start, memories = record.states[self._made], self._laws.memories
        if after:
            memories[:] = after._laws.memories
        else:
            memories[:, 0] = self._laws.slides @ start[: len(loop.plant.bodies)]
        self._channels = ChannelNumbers.of(loop, first_program=self._laws.parameters.size)
        self._known = KnownModes(loop, start)
        self._current = np.zeros(1, dtype=np.int64)

    def advance(self, end: int) -> None:
        """Advance until `end` samples are made; SettingError if the axis runs away."""
        # A linear law holds from the second sample on.
        if self._made == 0:
            self._advance(1, self._law._replace(limits=np.full(self.loop.n_drives, -1.0)))
        self._advance(end, self._law)

    def _advance(self, end: int, law: LoopLaw) -> None:
        memory = self._states if self.loop.law else self._after
        while self._made < end:
            table = self._known.table
            made, why = self._compiled.advance(
                self._made,
                end,
                self._ask,
                law,
                self.loop.given,
                self._channels,
                self._laws,
                table,
                self._current,
                self.record,
                memory,
                self._after,
            )
            self._made += made
            if self._error is not None:
                raise self._error
            if why == self._compiled.RUNAWAY:
                raise runaway(self.loop.trajectories[0].time[self._made])
            if why == self._compiled.UNKNOWN_MODE:
                self._known.add(table.events.wanted.tolist())

    def _asked(self, k: int) -> int:
        """Set the forces of a sample by the controllers' own laws; return 0, or 1 for an error, which is stored."""
        if self._answer[0] != k:  # else the sample is made again, in a mode that was not known
            references, readings = self._channels.references[k].tolist(), self._channels.readings.tolist()
            try:
                forces, states = self.loop.force(k, references, readings, self._states)
            except Exception as error:  # noqa: BLE001  it cannot pass through compiled code
                self._error = error
                return 1
            self._answer = k, forces
            if self.loop.law:
                self._after[:] = states
            else:
                self._states = states
        self.record.forces[k] = self._answer[1]
        return 0
