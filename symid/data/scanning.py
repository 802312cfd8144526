"""Logs that are longer than memory: one pass checks them, windows of them are read when they are needed.

The pass reads all columns block by block and finds what `read_log` finds: values that are not finite numbers, a clock
that is not uniform (in each block, and between them), channels that never change. It ends at the first block with a
fault. Stuck and clipped spans, which are notes only, are looked for in evenly spread windows.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from symid.arrays import FloatArray
from symid.data.checks import inspect_finite, inspect_steps, said_range
from symid.data.clock import MINIMUM_SAMPLES, Clock, ClockOfBlocks
from symid.data.columns import TIME, Assignment, Source, references_of, sources_of
from symid.data.frames import Frame
from symid.data.layout import Layout
from symid.data.long_log import BLOCK, AnyLog, LongLog, spans
from symid.data.reading import in_si, opened, positions_of, read_table
from symid.data.resampling import Rate
from symid.data.stuck import inspect_spans
from symid.data.table import Slices, Table, said_of
from symid.errors import LogError
from symid.units import Unit

MEMORY: Final = 1_000_000_000
"""Default memory for a log and its rows, bytes."""

_BYTES_OF_A_SAMPLE: Final = 160
"""Bytes per sample of identification in memory: columns as read and filtered, about ten columns of W."""
_BYTES_OF_A_ROW: Final = 4
"""Least bytes of a row in a file."""
_WINDOWS: Final = 8
_WINDOW: Final = 131_072


def open_log(
    path: str | os.PathLike[str] | Frame,
    *,
    expected: Mapping[str, Unit],
    alternatives: Mapping[str, tuple[str, float]] | None = None,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    gains: Mapping[str, float] | None = None,
    layout: Layout | None = None,
    sampling_period: float | None = None,
    resample: Rate | None = None,
    memory: int = MEMORY,
    block: int = BLOCK,
    whole: bool = False,
) -> AnyLog:
    """A log, read like `read_log` if it fits in memory; a longer one is checked without keeping it.

    Parameters
    ----------
    path, expected, alternatives, columns, units, gains, layout, sampling_period, resample
        As in `read_log`. MATLAB files, those of a layout or without a clock, and logs that are resampled are always
        read as a whole.
    memory : int
        Bytes that the log and the rows made of it may take.
    block : int
        Samples of a long log that are worked on at a time.
    whole : bool
        Whether a log that does not fit is refused instead of being read in blocks.

    Raises
    ------
    LogError
        As `read_log` does; of a long log, for the first block that has a fault.
    """
    named = dict(columns or {})
    file, table = opened(path, layout, sampling_period, memory)
    given = Assignment(
        table.headers, expected, alternatives or {}, {TIME: TIME, **named}, units or {}, gains or {}
    )
    with said_of(file):
        sources = sources_of(given, named=named.keys())
        whole = whole or resample is not None
        if table.slices is not None and not whole and _most_rows(file, table) * _BYTES_OF_A_SAMPLE > memory:
            used = [source for source in sources if source.signal not in references_of(expected)]
            slices = table.slices([source.position for source in used])
            if slices.n_rows * _BYTES_OF_A_SAMPLE > memory:
                headers = [table.headers[source.position] for source in used]
                return _Scan(file, slices, used, headers, expected, block).log()
        return read_table(file, table, expected, sources, named.keys(), memory, resample)


def _most_rows(file: Path, table: Table) -> float:
    return file.stat().st_size / _BYTES_OF_A_ROW if table.n_rows is None else table.n_rows


@dataclass(frozen=True, eq=False)
class _Scan:
    """The rows of a long log, and what is known of its columns."""

    file: Path
    slices: Slices
    sources: Sequence[Source]
    headers: Sequence[str]
    expected: Mapping[str, Unit]
    block: int

    def log(self) -> LongLog:
        """The log, after its check in one pass."""
        clock = self._clock()
        if clock.faults:
            raise LogError("; ".join(clock.faults))
        names = tuple(source.signal for source in self.sources if source.signal != TIME)
        log = LongLog(
            source=str(self.file),
            start=clock.start,
            sampling_period=clock.period,
            n_samples=self.slices.n_rows,
            signals=names,
            read=self._signals,
            notes=(*clock.notes, f"read in blocks of {self.block} samples at most"),
            block=self.block,
        )
        return replace(log, notes=(*log.notes, *self._stuck_or_clipped(log)))

    def _clock(self) -> Clock:
        """Clock of the times, after a pass over all blocks that ends at the first fault."""
        clock = ClockOfBlocks()
        lowest: dict[str, float] = {}
        highest: dict[str, float] = {}
        for first, stop in spans(self.slices.n_rows, max(self.block, MINIMUM_SAMPLES)):
            values = self._values(first, stop)
            time = values.pop(TIME)
            faults = (*clock.add(time), *inspect_finite(time, values, first))
            if not faults:
                positions = {name: values[name] for name in positions_of(self.expected, values)}
                faults = inspect_steps(time, positions, first)
            if faults:
                raise LogError("; ".join(faults))
            for name, x in values.items():
                lowest[name] = min(lowest.get(name, np.inf), float(x.min()))
                highest[name] = max(highest.get(name, -np.inf), float(x.max()))
        flat = [fault for name, x in lowest.items() if (fault := said_range(name, x, highest[name]))]
        if flat:
            raise LogError("; ".join(flat))
        return clock.found

    def _values(self, first: int, stop: int) -> dict[str, FloatArray]:
        values: dict[str, FloatArray] = {}
        faults = []
        for source, header, column in zip(
            self.sources, self.headers, self.slices.read(first, stop), strict=True
        ):
            if isinstance(column, str):
                faults.append(f"column {header!r} {column}")
            else:
                values[source.signal] = in_si(column, source.factor)
        if faults:
            raise LogError("; ".join(faults))
        return values

    def _signals(self, first: int, stop: int) -> dict[str, FloatArray]:
        with said_of(self.file):
            values = self._values(first, stop)
        return {name: x for name, x in values.items() if name != TIME}

    def _stuck_or_clipped(self, log: LongLog) -> list[str]:
        """The first note on each channel from evenly spread windows."""
        size = min(_WINDOW, log.n_samples)
        positions = positions_of(self.expected, log.signals)
        told: dict[str, str] = {}
        for start in np.linspace(0, log.n_samples - size, _WINDOWS).astype(int).tolist():
            window = log.window(start, start + size)
            for note in inspect_spans(window.time, window.signals, positions):
                told.setdefault(note.split("'")[1], note)
        return list(told.values())
