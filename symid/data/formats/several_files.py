"""Logs in several files, such as one of the drive and one of a scope, given as ``drive.csv+scope.csv``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from symid.data.columns import TIME, split_unit
from symid.data.foreign import foreign_columns
from symid.data.formats.channels import Channel, short_names, table_of_channels
from symid.data.table import Table
from symid.errors import LogError
from symid.units import to_si


def parts_of(path: Path) -> tuple[Path, ...]:
    """Files of a log; those behind the first may be named without its folder.

    >>> parts_of(Path("a.csv"))
    (PosixPath('a.csv'),)
    """
    first, *others = map(Path, str(path).split("+"))
    if not others or path.exists() or not first.is_file():
        return (path,)
    return (first, *(other if other.exists() else first.parent / other for other in others))


def open_joined(parts: Sequence[Path], read: Callable[[Path], Table]) -> Table:
    """Columns of several files in one table, each with the times of its file, which count from one moment.

    Parameters
    ----------
    parts : sequence of Path
        The files.
    read : callable
        Opens one of them.

    Raises
    ------
    LogError
        If a file has no column of the time, or its times are moments, which lose their begin.
    """
    channels: list[tuple[tuple[str, ...], Channel]] = []
    for part in parts:
        table = read(part)
        clock, factor = _clock(part, table)
        columns = table.read(range(len(table.headers)))
        for place, values in enumerate(columns):
            own = table.clocks.get(place, clock)
            time = columns[own]
            if isinstance(time, str):
                raise LogError(f"{part}: column {table.headers[own]!r} {time}")
            if place != clock and place not in table.clocks.values() and not isinstance(values, str):
                name, unit = split_unit(table.headers[place])
                channels.append(((part.stem, name), Channel(name, unit or "", factor * time, values)))
    names = short_names([path for path, _ in channels])
    return table_of_channels(
        [replace(channel, name=name) for name, (_, channel) in zip(names, channels, strict=True)]
    )


def _clock(part: Path, table: Table) -> tuple[int, float]:
    """Position of the column of the times, and what one of its units is in seconds."""
    if table.stamps:
        raise LogError(
            f"{part}: its times are moments, whose common start is not known: save seconds in both files"
        )
    if table.clocks:
        return next(iter(table.clocks.values())), 1.0
    guesses = {column.header: column for column in foreign_columns(table) if column.quantity == "time"}
    for place, header in enumerate(table.headers):
        if header == TIME:
            return place, 1.0
        column = guesses.get(header)
        if column is not None and column.unit and (column.stated or column.unit == "s"):
            return place, to_si(column.unit)
    raise LogError(f"{part}: has no column of times in a known unit: call one 't [s]' or 't [ms]'")
