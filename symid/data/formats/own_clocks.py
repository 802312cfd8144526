"""Text in which each channel, or each group of channels, follows its own column of times."""

from dataclasses import dataclass

import numpy as np

from symid.arrays import FloatArray
from symid.data.columns import split_unit
from symid.data.formats.channels import Channel, table_of_channels
from symid.data.table import Table
from symid.data.text_files.column_names import match, words_of
from symid.data.text_files.column_words import NUMBERS
from symid.data.text_files.foreign import described_column, quantity_named
from symid.units import to_si


@dataclass(frozen=True, eq=False)
class _Group:
    """A column of times, s, and the positions of the columns that follow it."""

    time: FloatArray
    members: list[int]


def with_own_clocks(table: Table) -> Table:
    """The table with the clock of each channel, if its columns of times differ; else the table as it is."""
    places = [place for place, header in enumerate(table.headers) if quantity_named(header) == "time"]
    if len(places) < 2 or table.stamps:
        return table
    columns = table.read(range(len(table.headers)))
    groups = _groups(table, columns, places)
    # a column that only numbers the samples holds no signal: its times are those at which messages came
    words = [words_of(header) for header in table.headers]
    measured = [one for one in groups if any(match(words[i], NUMBERS) is None for i in one.members)]
    first = next(iter(measured), None)
    if first is None or all(np.array_equal(one.time, first.time, equal_nan=True) for one in groups):
        return table
    channels = []
    for group in measured:
        for place in group.members:
            values = columns[place]
            if not isinstance(values, str):
                there = np.isfinite(group.time) & np.isfinite(values)
                name, unit = split_unit(table.headers[place])
                channels.append(Channel(name, unit or "", group.time[there], values[there]))
    return table_of_channels(channels)


def _groups(table: Table, columns: list[FloatArray | str], places: list[int]) -> list[_Group]:
    """Columns of rising times, each with the columns up to the next one."""
    groups = []
    for place, after in zip(places, [*places[1:], len(columns)], strict=True):
        time = columns[place]
        if isinstance(time, str) or after == place + 1:
            continue
        known = time[np.isfinite(time)]
        unit = described_column(table.headers[place], known).unit
        if known.size > 1 and unit and (np.diff(known) > 0).all():
            before = range(place) if place == places[0] else ()
            groups.append(_Group(to_si(unit) * time, [*before, *range(place + 1, after)]))
    return groups
