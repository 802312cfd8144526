"""The course of a simulation: the compiled loop, and the engine for samples with an event.

The compiled loop asks the controllers' own laws where the force of a drive reaches its limit. It passes events in which
joints stick, slip or reverse as long as it knows the stick-slip mode after them; before a mode that has not been met
yet it stops, and the engine makes the sample.
"""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np

from symid.arrays import FloatArray
from symid.simulation.engine import Engine
from symid.simulation.loop import Loop, LoopLaw, runaway
from symid.simulation.loop_numbers import ChannelNumbers, LawNumbers
from symid.simulation.mode_table import KnownModes
from symid.simulation.sensor_channel import MotionRecord


class SimulationRun:
    """A simulation in progress: it begins at the first state of its record, or continues the run `after`."""

    def __init__(self, loop: Loop, record: MotionRecord, after: SimulationRun | None = None) -> None:
        from symid.simulation import sample_loop  # numba takes 0.3 s to import

        self.loop, self.record, self._compiled = loop, record, sample_loop
        self._made: int = after._made if after else 0
        self._engine = Engine(loop.plant, record.states[self._made].copy())
        self._law = loop.law or LoopLaw.unknown(loop.n_drives, len(loop.controlled))
        self._states: Any = after._states if after else loop.start
        self._after = np.zeros(len(self._law.after))
        self._asked = -1
        self._error: Exception | None = None
        self._ask = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64)(self._answer)
        self._laws = LawNumbers.of(loop)
        self._channels = ChannelNumbers.of(loop, first_program=self._laws.parameters.size)
        if loop.is_accelerated and not after:
            record.accelerations[0] = self._engine.acceleration(np.zeros(loop.n_drives))
        self._known = KnownModes(loop, self._engine)
        self._current = np.zeros(1, dtype=np.int64)

    def advance(self, end: int) -> None:
        """Advance until `end` samples are made; SettingError if the axis runs away."""
        # A linear law holds from the second sample on.
        if self._made == 0:
            self._advance(1, self._law._replace(limits=np.full(self.loop.n_drives, -1.0)))
        while self._made < end:
            self._advance(end, self._law)

    def _advance(self, end: int, law: LoopLaw) -> None:
        """Advance to the next event and over it, or to `end`."""
        table, memory = self._known.table, self._states if self.loop.law else self._after
        table.events.wanted[:] = self._known.modes[self._current[0]].signs
        self._made += self._compiled.advance(
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
        if self.loop.moment is not None:
            self.loop.moment.recall(self._laws.memories)
        if self._made < end:
            if self._asked != self._made:
                self._answer(self._made)
            if self._error is not None:
                raise self._error
            self._engine.mode = self._known.modes[self._current[0]]
            try:
                self._event()
            except OverflowError as error:  # of a law's expression
                raise runaway(self.loop.trajectories[0].time[self._made]) from error
            self._known.place_of(table.events.wanted)
            self._current[0] = self._known.place(self._engine.mode)

    def _answer(self, k: int) -> int:
        """Set the forces of a sample by the controllers' own laws; return 0, or 1 for an error, which is stored."""
        references, readings = self._channels.references[k].tolist(), self._channels.readings.tolist()
        self._asked = k
        try:
            forces, states = self.loop.force(k, references, readings, self._states)
        except Exception as error:  # noqa: BLE001  it cannot pass through compiled code
            self._error = error
            return 1
        self.record.forces[k] = forces
        if self.loop.law:
            self._after[:] = states
        else:
            self._states = states
        return 0

    def _event(self) -> None:
        """Advance one sample with the engine, which locates events, under the recorded forces."""
        loop, record, k, engine = self.loop, self.record, self._made, self._engine
        engine.state, forces = record.states[k].copy(), record.forces[k].copy()
        if loop.moment is not None:
            loop.moment.time = (k + 0.5) * loop.period
            loop.moment.load = float(forces[0] if forces.size == 1 else np.abs(forces).sum())
        for piece, duration in enumerate(loop.durations):
            engine.advance(forces, duration)
            for i in np.flatnonzero(self._channels.pieces == piece):
                motion = np.concatenate([engine.state, self._acceleration(forces)])
                record.between[i, k] = self._channels.between[i] @ motion
        record.states[k + 1] = engine.state
        if loop.moment is not None:
            loop.moment.settle(engine.state[: len(loop.plant.bodies)])
            for row, memory in zip(self._laws.memories, loop.moment.memories, strict=True):
                row[:] = memory.place, memory.state
        record.accelerations[k + 1] = self._acceleration(forces)
        if loop.law:
            self._states[:] = self._after
        self._made = k + 1

    def _acceleration(self, forces: FloatArray) -> FloatArray:
        if not self.loop.is_accelerated:
            return np.zeros(len(self.loop.plant.bodies))
        return self._engine.acceleration(forces)
