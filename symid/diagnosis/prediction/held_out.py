"""Parts of a log for the identification, and others on which the gap is measured."""

from __future__ import annotations

from typing import Final

import numpy as np

from symid.arrays import BoolArray
from symid.diagnosis.prediction.record import Record

_PARTS: Final = 12
_FEWER_PARTS: Final = 6
"""Parts of a motion of few rows; the window removes some rows of each part."""
_EVERY: Final = 3
_FEW_ROWS: Final = 100
_MOSTLY_MOVES: Final = 0.5
"""Share of moving time above which the parts divide the time of the log, not the time of motion."""


def training_and_held_out(record: Record) -> tuple[BoolArray, BoolArray]:
    """Points of the fine grid for identification and for validation: every third of twelve parts is held out.

    The parts divide the time of motion if the axis mostly rests or moves only briefly.
    """
    moving = np.any([record.moves(speed) for speed in record.speeds], axis=0)
    seconds = float(np.sum(moving) * record.fine_time[1])
    few = 2 * record.band_hz * seconds < _FEW_ROWS
    rests = few or seconds < _MOSTLY_MOVES * record.duration
    gone = np.cumsum(moving) / np.sum(moving) if rests else record.fine_time / record.duration
    part = np.floor(gone * (_FEWER_PARTS if few else _PARTS))
    held_out = np.asarray(part % _EVERY == 1)
    return ~held_out, held_out
