"""Reading of logs: from the columns of a file to checked signals in SI units."""

from __future__ import annotations

import os
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import TypedDict

import numpy as np

from symid.arrays import FloatArray
from symid.data.checks import inspect_steps, inspect_values
from symid.data.clock import Clock, inspect_clock
from symid.data.columns import TIME, Assignment, Source, names_of, references_of, sources_of
from symid.data.frames import SOURCE, Frame, table_of
from symid.data.layout import Layout
from symid.data.log import Log
from symid.data.lost_samples import restored
from symid.data.memory import require_room
from symid.data.resampling import Rate, resampled
from symid.data.stuck import inspect_spans
from symid.data.table import Table, said_of
from symid.data.tables import open_table
from symid.errors import LogError
from symid.units import Unit


class ForeignColumns(TypedDict, total=False):
    """Options for a file whose columns are not named after signals, or not in SI units; see `read_log`."""

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
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    gains: Mapping[str, float] | None = None,
    layout: Layout | None = None,
    sampling_period: float | None = None,
    resample: Rate | None = None,
) -> Log:
    """Read and check the signals of an axis from a file of any kind that is read.

    A column is named after its signal, with or without a unit (SI): ``q2`` or ``q2 [mm]``.

    Parameters
    ----------
    path : path-like or data frame
        File, its kind given by the suffix; or a frame of pandas, polars or pyarrow, or columns by name.
    expected : Mapping of str to Unit
        Signals that the axis knows. Those in the file are read, and must be usable; others may be missing.
    alternatives : Mapping of str to (str, float)
        Another column from which a signal that the file does not have is made, and the factor to it (SI).
    columns, units, gains : Mapping of str to str, str, float
        For signals, ``t``, ``reference`` and alternative columns: the column of the file, its unit, and a
        factor that is applied after the conversion to SI.
    layout : Layout, optional
        Of a CSV file that is not one line of names and then values.
    sampling_period : float, optional
        Time between two samples, s, of a file without a column of the time.
    resample : float or "own", optional
        Rate in Hz to which signals are resampled, "own" for the rate that they have in the middle: for clocks that
        jitter, lack some samples, or differ between channels, see `resampled`. The notes report it.

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
    file, table = opened(path, layout, sampling_period)
    named = dict(columns or {})
    given = Assignment(
        table.headers, expected, alternatives or {}, {TIME: TIME, **named}, units or {}, gains or {}
    )
    with said_of(file):
        sources = sources_of(given, named=named.keys())
        return read_table(file, table, expected, sources, named.keys(), resample=resample)


def columns_in(path: str | os.PathLike[str], layout: Layout | None = None) -> frozenset[str]:
    """Names of the columns of a file, with and without their units; LogError if it is not a log.

    Parameters
    ----------
    path, layout
        As in `read_log`.
    """
    return names_of(open_table(Path(path), layout).headers)


def opened(
    path: str | os.PathLike[str] | Frame,
    layout: Layout | None,
    sampling_period: float | None,
    memory: int | None = None,
) -> tuple[Path, Table]:
    """Name and table of a log in a file or a frame; parameters and errors as those of `open_log`."""
    if isinstance(path, (str, os.PathLike)):
        return Path(path), opened_table(Path(path), layout, sampling_period, memory)
    table = table_of(path)
    with said_of(SOURCE):
        return SOURCE, table if sampling_period is None else with_clock(table, sampling_period)


def opened_table(
    file: Path, layout: Layout | None, sampling_period: float | None, memory: int | None = None
) -> Table:
    """Table in a file, with a column of the time if it has none; parameters and errors as those of `open_log`."""
    with said_of(file):
        table = open_table(file, layout, memory)
    if sampling_period is None:
        return table
    with said_of(file):
        return with_clock(table, sampling_period)


def with_clock(table: Table, sampling_period: float) -> Table:
    """The table with a last column `t` of the time, for a file that has none.

    LogError if there is such a column, or the period is not positive.
    """
    if TIME in table.headers:
        raise LogError(f"there is a column {TIME!r}: give no sampling period beside it")
    if not 1e-12 < sampling_period < 1e9:
        raise LogError(f"sampling period {sampling_period:g} s is not possible: give a positive number")
    last = len(table.headers)

    def read(positions: Sequence[int]) -> list[FloatArray | str]:
        others = [position for position in positions if position != last]
        columns = iter(table.read(others))
        found = dict(zip(others, columns, strict=True))
        size = max((c.size for c in found.values() if not isinstance(c, str)), default=0)
        found[last] = sampling_period * np.arange(size, dtype=np.float64)
        return [found[position] for position in positions]

    return Table((*table.headers, TIME), read, n_rows=table.n_rows)


def read_table(
    file: Path,
    table: Table,
    expected: Mapping[str, Unit],
    sources: Sequence[Source],
    named: Collection[str],
    memory: int | None = None,
    resample: Rate | None = None,
) -> Log:
    """Log of the whole of a file, which was opened as a table.

    Columns of the signals that the user has named must be usable. They may take `memory` bytes, by default those that
    are free.
    """
    require_room(len(sources) * (table.n_rows or 0), memory)
    values, notes = _read(
        table,
        sources,
        optional=set(references_of(expected)) - set(named) - expected.keys(),
        whole=not resample,
    )
    clocks = _clocks(table, sources, values)
    if resample is None:
        if other := [name for name in clocks if clocks[name] is not values[TIME]]:
            raise LogError(
                f"{other[0]!r} has other times than {next(iter(clocks))!r}: give --resample own, "
                "or save them with one clock"
            )
        return _checked(str(file), values, notes, expected)
    if resample != "own" and not 1e-9 < resample < 1e12:
        raise LogError(f"rate {resample:g} Hz is not possible: give a positive number, or own")
    signals = {name: x for name, x in values.items() if name != TIME}
    _require_sound(signals, clocks, expected)
    values, done = resampled(signals, clocks, resample)
    return _checked(str(file), values, [*notes, *done], expected, sound=True)


def _clocks(
    table: Table, sources: Sequence[Source], values: Mapping[str, FloatArray]
) -> dict[str, FloatArray]:
    """Times of each signal, s: its own column of them, or that of the log."""
    of_log = next(source for source in sources if source.signal == TIME)
    clocks = {}
    for source in sources:
        if source.signal == TIME or source.signal not in values:
            continue
        place = table.clocks.get(source.position, of_log.position)
        if place == of_log.position:
            clocks[source.signal] = values[TIME]
            continue
        (own,) = table.read([place])
        if isinstance(own, str):
            raise LogError(f"column {table.headers[place]!r} {own}")
        clocks[source.signal] = own
    return clocks


def _require_sound(
    signals: Mapping[str, FloatArray], clocks: Mapping[str, FloatArray], expected: Mapping[str, Unit]
) -> None:
    """LogError for positions that jump, before resampling hides it; resampled counts of an encoder jump no longer."""
    faults: list[str] = []
    for name in positions_of(expected, signals):
        size = min(signals[name].size, clocks[name].size)
        there = np.isfinite(signals[name][:size]) & np.isfinite(clocks[name][:size])
        time, x = clocks[name][:size][there], signals[name][:size][there]
        steps = np.diff(time)
        gaps = (np.flatnonzero(steps > 1.5 * np.median(steps)) + 1).tolist() if steps.size else []
        for t, part in zip(np.split(time, gaps), np.split(x, gaps), strict=True):
            faults += inspect_steps(t, {name: part})
    if faults:
        raise LogError("; ".join(faults))


def positions_of(expected: Mapping[str, Unit], signals: Collection[str]) -> list[str]:
    """Those signals that are positions or angles."""
    return [name for name in signals if expected.get(name) in (Unit.of("m"), Unit.of("rad"))]


def in_si(column: FloatArray, factor: float) -> FloatArray:
    """A column as it is or, if its unit is another, a copy in SI; what leaves the range is reported as not finite."""
    with np.errstate(over="ignore"):
        return column if factor == 1.0 else factor * column


def _read(
    table: Table, sources: Sequence[Source], optional: Collection[str], *, whole: bool = True
) -> tuple[dict[str, FloatArray], list[str]]:
    """Values of each source in SI; what is wrong with an optional one becomes a note and drops it."""
    columns = table.read([source.position for source in sources])
    values: dict[str, FloatArray] = {}
    faults, notes = [], []
    for source, column in zip(sources, columns, strict=True):
        if not isinstance(column, str):
            values[source.signal] = in_si(column, source.factor)
        elif source.signal in optional:
            notes.append(f"column {table.headers[source.position]!r} {column}; left out")
        else:
            faults.append(f"column {table.headers[source.position]!r} {column}")
    if faults:
        raise LogError("; ".join(faults))
    for signal in optional & values.keys() if whole else ():
        x = values[signal]
        if x.size != values[TIME].size or not np.isfinite(x).all():
            notes.append(f"{signal!r} has missing values or another length; left out")
            del values[signal]
    return values, notes


def _checked(
    source: str,
    values: dict[str, FloatArray],
    notes: list[str],
    expected: Mapping[str, Unit],
    *,
    sound: bool = False,
) -> Log:
    lengths = {name: x.size for name, x in values.items()}
    if len(set(lengths.values())) > 1:
        listed = ", ".join(f"{name} {size}" for name, size in lengths.items())
        raise LogError(f"the columns differ in length ({listed}): save as many samples of each")
    time = values.pop(TIME)
    if not time.size:
        raise LogError("has no rows: give a log with samples")
    clock = inspect_clock(time)
    needed = {name: x for name, x in values.items() if name in expected}
    faults = (*clock.faults, *inspect_values(time, needed))
    if not faults and not sound:
        positions = positions_of(expected, needed)
        whole, lost = restored(needed, positions)
        values, notes = values | whole, [*notes, *lost]
        faults = inspect_steps(time, {name: whole[name] for name in positions})
    if faults:
        raise LogError("; ".join(faults))
    return _log(source, clock, time, values, notes, expected)


def _log(
    source: str,
    clock: Clock,
    time: FloatArray,
    values: dict[str, FloatArray],
    notes: list[str],
    expected: Mapping[str, Unit],
) -> Log:
    positions = positions_of(expected, values)
    return Log(
        source=source,
        start=clock.start,
        sampling_period=clock.period,
        signals=values,
        notes=(*notes, *clock.notes, *inspect_spans(time, values, positions)),
    )
