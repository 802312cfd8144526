"""The course of a simulation: blocks of samples while the loop is linear, single samples where it is not.

A block is tried first. The sample at which it breaks off, because a joint sticks or slips or the force reaches its
limit, is made by the engine, which locates events exactly. Where blocks break off soon, samples are made one by one.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from symid.arrays import FloatArray
from symid.simulation.engine import Engine
from symid.simulation.linear_loop import LinearLoop
from symid.simulation.loop import Loop, runaway
from symid.simulation.mode import StickSlipMode
from symid.simulation.sample_code import compiled
from symid.simulation.sensor_channel import MotionRecord

_SHORTEST, _LONGEST = 128, 4096
"""Samples of a block: after an event, and the maximum."""
_POOR = 16
"""Fewest samples for which a block is faster than single samples."""
_MODES = 64
"""Number of modes whose matrices and code are cached."""


class SimulationRun:
    """A simulation in progress; its record holds the first state, or it continues the run `after` which it comes."""

    def __init__(self, loop: Loop, record: MotionRecord, after: SimulationRun | None = None) -> None:
        self.loop, self.record = loop, record
        self._made: int = after._made if after else 0
        self._memory: Any = after._memory if after else loop.start
        self._engine = Engine(loop.plant, record.states[self._made].copy())
        self._block, self._singly = _SHORTEST, 0
        self._by_mode: OrderedDict[StickSlipMode, _Ways] = OrderedDict()
        if loop.is_accelerated and not after:
            record.accelerations[0] = self._engine.acceleration(np.zeros(loop.n_drives))

    def advance(self, end: int) -> None:
        """Advance until `end` samples are made; SettingError if the axis runs away."""
        try:
            if self._made == 0:
                self._one()
            while self._made < end:
                ways = self._ways_of_mode()
                if ways.linear is not None and self._singly == 0:
                    self._by_block(ways.linear, min(self._made + self._block, end))
                else:
                    self._by_sample(ways.sampled, min(self._made + (self._singly or _LONGEST), end))
        except OverflowError as error:  # of a law's expression
            raise runaway(self.loop.trajectories[0].time[self._made]) from error

    def _ways_of_mode(self) -> _Ways:
        mode = self._engine.mode
        if mode not in self._by_mode:
            self._by_mode[mode] = _Ways(self.loop, mode)
            if len(self._by_mode) > _MODES:
                self._by_mode.popitem(last=False)
        self._by_mode.move_to_end(mode)
        return self._by_mode[mode]

    def _one(self) -> None:
        """A single sample by the controller's own law and the engine: the first one, and one that ends a block."""
        k = self._made
        readings = [reader.read(self.record, k) for reader in self.loop.controlled]
        self._event(
            *self.loop.force(
                k, self.loop.inputs[k, : 3 * self.loop.n_drives].tolist(), readings, self._memory
            )
        )

    def _by_block(self, linear: LinearLoop, end: int) -> None:
        wanted = end - self._made
        made, self._memory = linear.advance(self.record, self._made, end, self._memory)
        self._made += made
        self._engine.state = self.record.states[self._made].copy()
        if made == wanted:
            self._block = min(4 * self._block, _LONGEST)
        else:
            self._one()
            self._block, self._singly = _SHORTEST, 0 if made >= _POOR else 2 * _POOR

    def _by_sample(self, sampled: Callable[..., Any], end: int) -> None:
        loop, record, k = self.loop, self.record, self._made
        pasts = [reader.past(record, k).tolist() for reader in loop.controlled]
        columns = [range(k, end), *loop.inputs[k:end].T.tolist()]
        state = record.states[k]
        limits = self._engine.mode.limits(state).ravel().tolist()
        kept = self._memory.tolist() if loop.law else self._memory
        out, pending, memory = sampled(columns, pasts, state.tolist(), kept, limits)
        made = self._write(np.array(out))
        self._memory = self._remembered(memory)
        self._engine.state = record.states[self._made].copy()
        self._singly = max(self._singly - made, 0)
        if pending is not None:
            forces, memory = pending
            self._event(forces, self._remembered(memory))
            self._singly = max(self._singly - 1, 0)

    def _remembered(self, memory: Any) -> Any:
        return np.array(memory, dtype=float) if self.loop.law else memory

    def _write(self, out: FloatArray) -> int:
        """Write the results of a mode's code to the record."""
        loop, record, size = self.loop, self.record, self._engine.state.size
        sent = size + loop.n_drives
        width = sent + (size // 2 if loop.is_accelerated else 0) + len(loop.between)
        out = out.reshape(-1, width)
        begin, end = self._made, self._made + len(out)
        record.states[begin + 1 : end + 1] = out[:, :size]
        record.forces[begin:end] = out[:, size:sent]
        if loop.is_accelerated:
            record.accelerations[begin + 1 : end + 1] = out[:, sent : sent + size // 2]
        for i, reader in enumerate(reversed(loop.between), start=1):
            record.between[reader.signal][begin:end] = out[:, -i]
        self._made = end
        return len(out)

    def _event(self, forces: Sequence[float], memory: Any) -> None:
        """One sample by the engine, which locates events."""
        record, k, engine, n = self.record, self._made, self._engine, len(self.loop.plant.bodies)
        self.loop.at(k, forces)
        for duration, readers in self.loop.pieces:
            engine.advance(forces, duration)
            for reader in readers:
                value = (
                    engine.acceleration(forces) if reader.order == 2 else engine.state[reader.order * n :][:n]
                )
                record.between[reader.signal][k] = reader.row @ value
        record.forces[k], record.states[k + 1] = forces, engine.state
        if self.loop.moment is not None:
            self.loop.moment.settle(engine.state[:n])
        if self.loop.is_accelerated:
            record.accelerations[k + 1] = engine.acceleration(forces)
        self._memory, self._made = memory, k + 1


class _Ways:
    """Matrices of one mode, and its code, made when first needed."""

    def __init__(self, loop: Loop, mode: StickSlipMode) -> None:
        self._loop, self._mode = loop, mode
        law = loop.law
        self.linear = LinearLoop(loop, mode, law) if law and LinearLoop.applies(loop, mode) else None

    @cached_property
    def sampled(self) -> Callable[..., Any]:
        """Function that makes samples one by one."""
        return compiled(self._loop, self._mode)
