"""A loop and its stick-slip modes as records of arrays for the compiled `sample_loop`."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from itertools import chain
from typing import Any, NamedTuple

import numpy as np

from symid.arrays import FloatArray
from symid.simulation.loops.loop import Loop
from symid.simulation.loops.mode import StickSlipMode, StickSlipModes
from symid.simulation.plants.postfix import Program, program

_ARGUMENTS: tuple[str, ...] = ("q", "v", "F", "t", "z")
"""Arguments of a formula, before the forces F0, F1, ... of the drives; F is the load of the joints."""

Int64Array = np.ndarray[Any, np.dtype[np.int64]]


class LawNumbers(NamedTuple):
    """The laws of a plant, and programs of all formulas.

    There is a program for each term of a law, then one for each sensor with a reading error, then the gains and limits
    of the drives.
    """

    directions: FloatArray  # shape (n_laws, n)
    any_timed: bool  # whether one depends on more than the motion
    terms: Int64Array  # shape (n_laws + 1,): first term of each law, and the end of the last
    parameters: FloatArray  # shape (n_terms,)
    remembers: Int64Array  # shape (n_terms,): memory on which each term depends, or -1
    nonlinearities: Int64Array  # shape (n_drives + 1,): first program of each drive, and the end of the last
    # operations, operands: all programs, concatenated
    operations: Int64Array
    operands: FloatArray
    ends: Int64Array  # start of each program, and the end of the last
    # arguments, stack: space for the programs
    arguments: FloatArray
    stack: FloatArray
    slides: FloatArray  # shape (n_memories, n): directions of the joints with a memory
    reaches: FloatArray  # shape (n_memories,): displacement over which each builds up
    memories: FloatArray  # shape (n_memories, 2): displacement of the last update, and the state there

    @classmethod
    def of(cls, loop: Loop) -> LawNumbers:
        """The laws of a loop's plant, and the reading errors of its controlled sensors."""
        plant, n = loop.plant, len(loop.plant.bodies)
        terms = [term for law in plant.laws for term in law.terms]
        arguments = (*_ARGUMENTS, *(f"F{i}" for i in range(loop.n_drives)))
        programs = [_program(term.code, arguments) for term in terms]
        programs += [_program(r.misread, ("y",)) for r in loop.controlled if r.misread is not None]
        nonlinearities = len(programs) + np.cumsum([0, *map(len, loop.nonlinearities)])
        programs += [_program(code, arguments) for code in chain.from_iterable(loop.nonlinearities)]
        return cls(
            directions=np.array([law.direction for law in plant.laws]).reshape(-1, n),
            any_timed=any(law.timed for law in plant.laws),
            terms=np.cumsum([0, *(len(law.terms) for law in plant.laws)]),
            parameters=np.array([term.parameter for term in terms], dtype=float),
            remembers=np.array([term.memory for term in terms], dtype=np.int64),
            nonlinearities=nonlinearities,
            operations=np.concatenate([np.zeros(0, np.int64), *(p.operations for p in programs)]),
            operands=np.concatenate([np.zeros(0), *(p.operands for p in programs)]),
            ends=np.cumsum([0, *(p.operations.size for p in programs)]),
            arguments=np.zeros(len(arguments)),
            stack=np.zeros(max((p.depth for p in programs), default=1)),
            slides=np.array([memory.direction for memory in loop.memories]).reshape(-1, n),
            reaches=np.array([memory.reach for memory in loop.memories], dtype=float),
            memories=np.zeros((len(loop.memories), 2)),
        )


@cache
def _program(code: str, arguments: tuple[str, ...]) -> Program:
    return program(code, arguments)


class ChannelNumbers(NamedTuple):
    """References and sensors of a loop."""

    period: float  # time between two samples, s
    # shape (n_samples, 3 n_drives): position, velocity and acceleration of each drive's reference
    references: FloatArray
    readings: FloatArray  # shape (n_signals,): receives the readings of the controlled signals
    noise: FloatArray  # shape (n_samples, n_signals): their noise
    # shape (n_signals, 3 n): exact readings, as rows on displacements, velocities and accelerations
    rows: FloatArray
    ages: Int64Array  # shape (n_signals,): delay in whole samples
    places: Int64Array  # shape (n_signals,): row of `between` that it reads, or -1
    steps: FloatArray  # shape (n_signals,): resolutions
    misread: Int64Array  # shape (n_signals,): program of the reading error, or -1
    between: FloatArray  # shape (n_between, 3 n): rows of the sensors that take a value between two samples
    pieces: Int64Array  # shape (n_between,): piece of a sample at whose end they take it

    @classmethod
    def of(cls, loop: Loop, first_program: int) -> ChannelNumbers:
        """Sensors of a loop; `first_program` is the number of the first program of a reading error."""
        paths, controlled, between = loop.trajectories, loop.controlled, loop.between
        width, moments = 3 * len(loop.plant.bodies), loop.moments
        is_misread = [reader.misread is not None for reader in controlled]
        programs = first_program - 1 + np.cumsum(is_misread, dtype=np.int64)
        return cls(
            period=loop.period,
            references=np.column_stack(
                [x for path in paths for x in (path.position, path.velocity, path.acceleration)]
            ),
            readings=np.zeros(len(controlled)),
            noise=np.array([reader.noise for reader in controlled]).reshape(-1, paths[0].n_samples).T.copy(),
            rows=np.array([reader.motion_row for reader in controlled]).reshape(-1, width),
            ages=np.array([reader.age for reader in controlled], dtype=np.int64),
            places=np.array(
                [between.index(reader) if reader.is_between else -1 for reader in controlled], dtype=np.int64
            ),
            steps=np.array([reader.step for reader in controlled], dtype=float),
            misread=np.where(is_misread, programs, -1),
            between=np.array([reader.motion_row for reader in between]).reshape(-1, width),
            pieces=np.array([moments.index(reader.moment) for reader in between], dtype=np.int64),
        )


class ModeNumbers(NamedTuple):
    """Motion in a mode, cut into the pieces of a sample, in terms of z: state, forces of drives and varying laws, 1."""

    # shape (n_pieces, 2 n + n_stuck, n_z): state at the middle of each piece, and forces that stuck joints need
    # at its begin
    begins: FloatArray
    # shape (n_pieces, 2 n + n_stuck + n_sliding, n_z): state at the end of each piece; there, forces that stuck
    # joints need, and speeds of sliding joints, positive while they keep direction
    ends: FloatArray
    rates: FloatArray  # shape (n, n_z): accelerations
    # stuck, varying: laws of the stuck joints, and laws that are not affine
    stuck: Int64Array
    varying: Int64Array
    signs: FloatArray  # shape (n_varying,): directions of the varying laws, 0 for both
    limits: FloatArray  # shape (n_stuck, 2): lowest and highest force that each stuck joint can hold
    is_accelerated: bool  # whether a sensor reads an acceleration

    @classmethod
    def of(cls, mode: StickSlipMode, loop: Loop) -> ModeNumbers:
        """A mode over the pieces of a loop's sample."""
        plant, flow, n = loop.plant, mode.flow, len(loop.plant.bodies)
        # state and generalised forces as rows on z
        against = np.array([plant.laws[j].direction for j in mode.varying]).reshape(-1, n).T
        forces = np.hstack([plant.drives, -against, mode.constant[:, None]])
        state = np.eye(2 * n, 2 * n + forces.shape[1])
        motion = np.vstack([state, np.hstack([np.zeros((n, 2 * n)), forces])])

        def after(duration: float) -> FloatArray:
            return np.asarray(np.hstack(flow.transition(duration)) @ motion)

        begins = [np.vstack([after(duration / 2), flow.holding_rows @ motion]) for duration in loop.durations]
        ends = [np.vstack([after(duration), motion[2 * n :]]) for duration in loop.durations]
        checks = np.vstack([flow.holding_rows, np.pad(mode.speeds, ((0, 0), (0, n)))])
        return cls(
            begins=np.array(begins),
            ends=np.array([np.vstack([end[: 2 * n], checks @ end]) for end in ends]),
            rates=flow.acceleration_rows @ motion,
            stuck=np.array(flow.stuck, dtype=np.int64),
            varying=np.array(mode.varying, dtype=np.int64),
            signs=np.array([mode.signs[j] for j in mode.varying], dtype=float),
            limits=np.zeros((len(flow.stuck), 2)),
            is_accelerated=loop.is_accelerated,
        )


SLIDING, STUCK, VARYING = 1, 2, 4
"""Kinds of laws in a mode: of a joint that slides but could stick, of one that sticks, and a law that is not affine."""


class EventNumbers(NamedTuple):
    """Numbers of each mode that the location of events needs: m counts modes, j laws."""

    signs: FloatArray  # shape (m, j): directions of sliding joints
    kinds: Int64Array  # shape (m, j): sums of the kinds above
    reach: FloatArray  # shape (m,): time over which the series holds, s
    series: FloatArray  # shape (m, terms, 2 n, 3 n): Taylor series of the state, in terms of state and forces
    constant: FloatArray  # shape (m, n): constant forces
    holding: FloatArray  # shape (m, j, 3 n): forces that stuck joints need
    rates: FloatArray  # shape (m, n, 3 n): accelerations
    directions: FloatArray  # shape (j, n)
    impulses: (
        FloatArray  # shape (j, n): change of velocities by an impulse that changes that of its joint by 1
    )
    wanted: FloatArray  # shape (j,): receives the signs of a mode that is not in the table


class ModeTable(NamedTuple):
    """Numbers of all modes that the simulation has met so far."""

    # drives: shape (n, n_drives); durations: of the pieces of a sample, s
    drives: FloatArray
    durations: FloatArray
    is_accelerated: bool  # whether a sensor reads an acceleration
    # `ModeNumbers` of all modes, one after the other: numbers, and indices of laws
    numbers: FloatArray
    law_numbers: Int64Array
    # places, law_places: shape (m,): where those of each mode begin
    places: Int64Array
    law_places: Int64Array
    counts: Int64Array  # shape (m, 3): numbers of stuck, sliding and varying laws
    events: EventNumbers


class KnownModes:
    """The modes of a loop, in the order in which they were met, and their table; the first is that of a state."""

    def __init__(self, loop: Loop, state: FloatArray) -> None:
        self._loop, self._modes = loop, StickSlipModes(loop.plant)
        self._known: list[StickSlipMode] = []
        self._numbers: list[ModeNumbers] = []
        self.add(self._modes.start(state))

    def add(self, signs: Sequence[float]) -> None:
        """Add the mode with these signs to the table."""
        self._known.append(self._modes.of(tuple(signs)))
        self._numbers.append(ModeNumbers.of(self._known[-1], self._loop))
        self.table = self._made()

    def _made(self) -> ModeTable:
        loop, plant, modes = self._loop, self._loop.plant, self._known
        n, n_laws = len(plant.bodies), len(plant.laws)
        # Compiled code takes arrays of one type: the numbers of all modes in one vector, with the place of each mode.
        flat = [
            np.concatenate([x.ravel() for x in (b.begins, b.ends, b.rates, b.signs, b.limits)])
            for b in self._numbers
        ]
        laws = [np.concatenate([b.stuck, b.varying]) for b in self._numbers]
        holding = np.zeros((len(modes), n_laws, 3 * n))
        for rows, mode in zip(holding, modes, strict=True):
            rows[list(mode.flow.stuck)] = mode.flow.holding_rows
        events = EventNumbers(
            signs=np.array([mode.signs for mode in modes]).reshape(len(modes), n_laws),
            kinds=np.array([_kinds(mode) for mode in modes], dtype=np.int64).reshape(len(modes), n_laws),
            reach=np.array([mode.flow.reach for mode in modes]),
            series=np.array([mode.flow.terms for mode in modes]),
            constant=np.array([mode.constant for mode in modes]),
            holding=holding,
            rates=np.array([mode.flow.acceleration_rows for mode in modes]),
            directions=np.array([law.direction for law in plant.laws]).reshape(n_laws, n),
            impulses=np.array(self._modes.impulses).reshape(n_laws, n),
            wanted=np.zeros(n_laws),
        )
        return ModeTable(
            drives=np.ascontiguousarray(plant.drives),
            durations=np.array(loop.durations),
            is_accelerated=loop.is_accelerated,
            numbers=np.concatenate(flat),
            law_numbers=np.concatenate(laws),
            places=np.cumsum([0, *map(len, flat)])[:-1],
            law_places=np.cumsum([0, *map(len, laws)])[:-1],
            counts=np.array(
                [(len(m.flow.stuck), len(m.sliding), len(m.varying)) for m in modes], dtype=np.int64
            ),
            events=events,
        )


def _kinds(mode: StickSlipMode) -> list[int]:
    return [
        SLIDING * (j in mode.sliding) + STUCK * (j in mode.flow.stuck) + VARYING * (j in mode.varying)
        for j in range(len(mode.signs))
    ]
