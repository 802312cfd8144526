"""`read_log` and `open_log`: logs from files and frames, as a whole or in blocks."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final, TypedDict, Unpack, cast

import numpy as np

from symid.arrays import FloatArray
from symid.data.columns import TIME, Assignment, references_of, sources_of, split_unit
from symid.data.formats import open_table
from symid.data.frames import FRAME_SOURCE, Frame, table_of
from symid.data.log import Log
from symid.data.long_log import BLOCK, AnyLog, scanned
from symid.data.quality.coarse_clock import is_coarse
from symid.data.reading import BYTES_OF_A_SAMPLE, read_table
from symid.data.resampling import Rate
from symid.data.table import Table, naming_file
from symid.data.text_files.layout import Layout
from symid.errors import LogError
from symid.units import Unit

MEMORY: Final = 1_000_000_000
"""Default memory for a log and its rows, bytes."""
_BYTES_OF_A_ROW: Final = 4
"""Fewest bytes of a row in a file."""


class ForeignColumns(TypedDict, total=False):
    """Options for a file whose columns are not named after signals, or not in SI units.

    Attributes
    ----------
    columns, units, gains : mapping of str to str, str, float
        For signals, ``t``, ``reference`` and alternative columns: the column of the file, its unit, and a factor that
        is applied after the conversion to SI.
    layout : Layout
        Of a CSV file that is not one line of names and then values.
    sampling_period : float
        Time between two samples, s, of a file without a column of the time.
    resample : float or "own"
        Rate in Hz to which signals are resampled, "own" for the rate that they have in the middle: for clocks that
        jitter, have missing samples, or differ between channels, see `resampled`. The notes report it.
    """

    columns: Mapping[str, str] | None
    units: Mapping[str, str] | None
    gains: Mapping[str, float] | None
    layout: Layout | None
    sampling_period: float | None
    resample: Rate | None


def read_log(
    path: str | os.PathLike[str] | Frame,
    *,
    expected: Mapping[str, Unit],
    alternatives: Mapping[str, tuple[str, float]] | None = None,
    **foreign: Unpack[ForeignColumns],
) -> Log:
    """Read and check the signals of an axis from a file of any supported kind.

    A column is named after its signal, with or without a unit (SI): ``q2`` or ``q2 [mm]``.

    Parameters
    ----------
    path : path-like or data frame
        File, its kind given by the suffix; or a frame of pandas, polars or pyarrow, or columns by name.
    expected : Mapping of str to Unit
        Signals that the axis knows. Those in the file are read, and must be usable; others may be missing.
    alternatives : Mapping of str to (str, float)
        Another column from which a signal that the file does not have is made, and the factor to it (SI).
    **foreign
        ``columns``, ``units``, ``gains``, ``layout``, ``sampling_period`` and ``resample`` of a foreign file, as
        described in `ForeignColumns`.

    Returns
    -------
    Log
        The signals found, with ``reference`` if the file has it. Its notes list irregularities.

    Raises
    ------
    LogError
        In one line: the file is unreadable, a named column is missing, no signal is there, a unit does not
        fit, a value is not a number, the clock is not uniform, a signal is constant.
    """
    log = open_log(path, expected=expected, alternatives=alternatives, memory=None, **foreign)
    return cast("Log", log)


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
    memory: int | None = MEMORY,
    block: int = BLOCK,
    whole: bool = False,
) -> AnyLog:
    """A log, read like `read_log` if it fits in memory; a longer one is checked without keeping it.

    Parameters
    ----------
    path, expected, alternatives, columns, units, gains, layout, sampling_period, resample
        As in `read_log`. MATLAB files, those of a layout or without a clock, and logs that are resampled are always
        read as a whole.
    memory : int, optional
        Bytes that the log and the rows made of it may take; without it the log is read as a whole if they fit in the
        memory that is free.
    block : int
        Samples of a long log that are worked on at a time.
    whole : bool
        Whether a log that does not fit is refused instead of being read in blocks.

    Raises
    ------
    LogError
        As `read_log` does; of a long log, for the first block that has a fault.
    """
    is_file = isinstance(path, (str, os.PathLike))
    file, named = Path(path) if isinstance(path, (str, os.PathLike)) else FRAME_SOURCE, dict(columns or {})
    with naming_file(file):
        table = open_table(file, layout, memory) if is_file else table_of(cast("Frame", path))
        if sampling_period is not None:
            table = _with_clock(table, sampling_period)
        assignment = Assignment(
            table.headers, expected, alternatives or {}, {TIME: TIME, **named}, units or {}, gains or {}
        )
        sources = sources_of(assignment, named=named.keys())
        if memory is not None and table.slices is not None and not whole and resample is None:
            size = file.stat().st_size / _BYTES_OF_A_ROW if table.n_rows is None else table.n_rows
            if size * BYTES_OF_A_SAMPLE > memory:
                used = [source for source in sources if source.signal not in references_of(expected)]
                slices = table.slices([source.position for source in used])
                if slices.n_rows * BYTES_OF_A_SAMPLE > memory:
                    headers = [table.headers[source.position] for source in used]
                    return scanned(file, slices, used, headers, expected, block)
        return read_table(file, table, expected, sources, named.keys(), memory, resample)


def columns_in(path: str | os.PathLike[str], layout: Layout | None = None) -> frozenset[str]:
    """Names of the columns of a file, with and without their units; LogError if it is not a log.

    Parameters
    ----------
    path, layout
        As in `read_log`.
    """
    headers = open_table(Path(path), layout).headers
    return frozenset(headers) | {split_unit(header)[0] for header in headers}


def _with_clock(table: Table, sampling_period: float) -> Table:
    """The table with a last column `t` of the time; LogError if it has one already, unless it is coarse."""
    if TIME in table.headers:
        place = table.headers.index(TIME)
        (time,) = table.read([place])
        if not isinstance(time, str) and is_coarse(time):
            headers = tuple(f"{h} (rounded)" if i == place else h for i, h in enumerate(table.headers))
            table = replace(table, headers=headers)
    if TIME in table.headers:
        raise LogError(f"has a column {TIME!r} already: omit the sampling period")
    if not 1e-12 < sampling_period < 1e9:
        raise LogError(f"sampling period {sampling_period:g} s is not possible: give a positive number")
    last = len(table.headers)

    def read(positions: Sequence[int]) -> list[FloatArray | str]:
        others = [position for position in positions if position != last]
        values = dict(zip(others, table.read(others), strict=True))
        size = max((c.size for c in values.values() if not isinstance(c, str)), default=0)
        values[last] = sampling_period * np.arange(size, dtype=np.float64)
        return [values[position] for position in positions]

    return Table((*table.headers, TIME), read, n_rows=table.n_rows)
