"""Checked signals of a log, in SI units, from the columns of a table."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np

from symid.arrays import FloatArray
from symid.data.columns import TIME, Source, references_of
from symid.data.log import Log
from symid.data.quality.checks import inspect_finite, inspect_steps, inspect_values
from symid.data.quality.clock import inspect_clock, require_seconds
from symid.data.quality.lost_samples import restored
from symid.data.quality.overflow import unwrapped, unwrapped_times
from symid.data.quality.stuck import inspect_spans
from symid.data.resampling import Rate, known_samples, resampled
from symid.data.table import Table, require_memory
from symid.errors import LogError
from symid.units import Unit

BYTES_OF_A_SAMPLE: Final = 160
"""Bytes per sample of identification in memory: columns as read and filtered, about ten columns of W."""


def read_table(
    file: Path,
    table: Table,
    expected: Mapping[str, Unit],
    sources: Sequence[Source],
    named: Collection[str],
    memory: int | None,
    resample: Rate | None,
) -> Log:
    """Log of the whole of a file, which was opened as a table.

    Columns of the signals that the user has named must be usable. They may take `memory` bytes; by default, they and
    their rows must fit into the free memory.
    """
    values_of_a_row = len(sources) if memory else max(len(sources), BYTES_OF_A_SAMPLE // 8)
    require_memory(values_of_a_row * (table.n_rows or 0), memory)
    values, notes = _read(
        table,
        sources,
        references=set(references_of(expected)) - expected.keys(),
        named=named,
        whole=not resample,
    )
    of_time = next(source for source in sources if source.signal == TIME)
    if not (of_time.stated or of_time.position in table.stamps or of_time.position in table.clocks.values()):
        require_seconds(values[TIME])
    clocks = _clocks(table, sources, values)
    if resample is None:
        if differing := [name for name in clocks if clocks[name] is not values[TIME]]:
            like = next((name for name in clocks if name not in differing), TIME)
            raise LogError(
                f"{differing[0]!r} has other times than {like!r}: give `resample=own`, "
                "or save them with one clock"
            )
        return _checked(str(file), values, notes, expected)
    if resample != "own" and not 1e-9 < resample < 1e12:
        raise LogError(f"rate {resample:g} Hz is not possible: give a positive number, or own")
    values, again = _unwrapped(values, expected)
    notes = [*notes, *again]
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
        (times,) = table.read([place])
        if isinstance(times, str):
            raise LogError(f"column {table.headers[place]!r} {times}")
        clocks[source.signal] = times
    return clocks


def _require_sound(
    signals: Mapping[str, FloatArray], clocks: Mapping[str, FloatArray], expected: Mapping[str, Unit]
) -> None:
    """LogError for positions that jump, before resampling hides it; resampled counts of an encoder jump no longer."""
    faults: list[str] = []
    for name in positions_of(expected, signals):
        time, x, _ = known_samples(clocks[name], signals[name])
        if wrong := inspect_finite(time, {name: x}):
            faults += wrong
            continue
        steps = np.diff(time)
        gaps = (np.flatnonzero(steps > 1.5 * np.median(steps)) + 1).tolist() if steps.size else []
        for t, part in zip(np.split(time, gaps), np.split(x, gaps), strict=True):
            faults += inspect_steps(t, {name: part})
    if faults:
        raise LogError("; ".join(faults))


def _unwrapped(
    values: Mapping[str, FloatArray], expected: Mapping[str, Unit]
) -> tuple[dict[str, FloatArray], list[str]]:
    """Values with unwrapped positions, and notes."""
    signals, notes = dict(values), []
    for name in positions_of(expected, values):
        signals[name], note = unwrapped(name, values[name], is_angle=expected[name] == Unit.of("rad"))
        notes += [note] * bool(note)
    return signals, notes


def positions_of(expected: Mapping[str, Unit], signals: Collection[str]) -> list[str]:
    """Signals that are positions or angles."""
    return [name for name in signals if expected.get(name) in (Unit.of("m"), Unit.of("rad"))]


def converted(column: FloatArray, factor: float) -> FloatArray:
    """A column in SI: itself if the factor is 1, else a copy. An overflow is infinite, and a later check reports it."""
    with np.errstate(over="ignore"):
        return column if factor == 1.0 else factor * column


def _read(
    table: Table,
    sources: Sequence[Source],
    *,
    references: Collection[str],
    named: Collection[str],
    whole: bool,
) -> tuple[dict[str, FloatArray], list[str]]:
    """Values of each source in SI; references that lack values are dropped, with a note."""
    columns = table.read([source.position for source in sources])
    values: dict[str, FloatArray] = {}
    faults, notes = [], []
    for source, column in zip(sources, columns, strict=True):
        if not isinstance(column, str):
            written, note = unwrapped_times(column) if source.signal == TIME else (column, "")
            values[source.signal] = converted(written, source.factor)
            notes += [note] * bool(note)
        elif source.signal in references and source.signal not in named:
            notes.append(f"column {table.headers[source.position]!r} {column}; left out")
        else:
            faults.append(f"column {table.headers[source.position]!r} {column}")
    if faults:
        raise LogError("; ".join(faults))
    time = values[TIME]
    if not table.clocks and time.size > 1 and np.isfinite(time).all() and np.all(time[1:] < time[:-1]):
        values = {signal: x[::-1] for signal, x in values.items()}
        notes.append("the times fall: the order of the rows was reversed")
    for signal in set(references) & values.keys():
        x = values[signal]
        there = np.isfinite(x)
        if not there.any() or (whole and (x.size != values[TIME].size or not there.all())):
            notes.append(f"{signal!r} has missing values or another length; left out")
            del values[signal]
    return values, notes


def _ends_within_a_row(values: Mapping[str, FloatArray]) -> bool:
    """Whether only the last row lacks values, as in the file of a program that was stopped."""
    missing = [~np.isfinite(x) for x in values.values()]
    return any(absent.size > 1 and absent[-1] for absent in missing) and not any(
        absent[:-1].any() for absent in missing
    )


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
    if _ends_within_a_row(values):
        values = {name: x[:-1] for name, x in values.items()}
        notes = [*notes, "the last row is not complete: left out"]
    time = values.pop(TIME)
    if not time.size:
        raise LogError("has no rows: give a log with samples")
    clock = inspect_clock(time)
    needed = {name: x for name, x in values.items() if name in expected}
    faults = (*clock.faults, *inspect_values(time, needed))
    if not faults and not sound:
        positions = positions_of(expected, needed)
        needed, again = _unwrapped(needed, expected)
        restored_signals, lost = restored(needed, positions)
        values, notes = values | restored_signals, [*notes, *again, *lost]
        faults = inspect_steps(time, {name: restored_signals[name] for name in positions})
    if faults:
        raise LogError("; ".join(faults))
    positions = positions_of(expected, values)
    return Log(
        source=source,
        start=clock.start,
        sampling_period=clock.period,
        signals=values,
        notes=(*notes, *clock.notes, *inspect_spans(time, values, positions)),
    )
