"""The stick-slip modes that a simulation has met, as one record of arrays for the compiled `sample_loop`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from symid.arrays import FloatArray
from symid.simulation.loop import Loop
from symid.simulation.loop_numbers import IntArray, ModeNumbers
from symid.simulation.mode import StickSlipMode, StickSlipModes

SLIDING, STUCK, VARYING = 1, 2, 4
"""Kinds of laws in a mode: of a joint that slides but could stick, of one that sticks, and a law that is not affine."""


class EventNumbers(NamedTuple):
    """Numbers of each mode that the location of events needs: m counts modes, j laws."""

    signs: FloatArray  # shape (m, j): directions of sliding joints
    kinds: IntArray  # shape (m, j): sums of the kinds above
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
    law_numbers: IntArray
    # places, law_places: shape (m,): where those of each mode begin
    places: IntArray
    law_places: IntArray
    counts: IntArray  # shape (m, 3): numbers of stuck, sliding and varying laws
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
    varying = [law for law, _ in mode.varying]
    return [
        SLIDING * (j in mode.sliding) + STUCK * (j in mode.flow.stuck) + VARYING * (law in varying)
        for j, law in enumerate(mode.plant.laws)
    ]
