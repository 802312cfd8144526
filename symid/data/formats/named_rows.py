"""Rows that each hold a time, the name of a signal and its value, as databases, brokers and historians export them."""

import re
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Final

import polars as pl

from symid.arrays import FloatArray
from symid.data.formats.channels import Channel, table_of_channels
from symid.data.table import Table
from symid.data.text_files.column_names import match, split_header, words_of
from symid.data.text_files.csv_table import values_of_texts
from symid.data.text_files.foreign import described_column, quantity_named
from symid.data.text_files.layout import Layout, layout_of_text, lines_of
from symid.data.text_files.text_table import LEAST_ROWS, fields, is_number_text
from symid.errors import LogError
from symid.units import to_si

_VALUE: Final = r"values?|val|wert|valeur|valore?|messwert|reading"
_NAME: Final = r"tag\w*|names?|signal|variable|topic|field|channel|kanal|metric|item"
_MOST, _HEAD = 64, 20_000  # signals; bytes that hold the names of columns
_HAS_VALUE: Final = re.compile(rb"(?i)(?<![a-z])(?:" + _VALUE.encode() + rb")(?![a-z])")


def named_rows_in(path: Path, begin: bytes) -> Callable[[], Table] | None:
    """Reader of a text file whose rows hold one value of a named signal each; None of others."""
    if not _HAS_VALUE.search(begin[:_HEAD].replace(b"\x00", b"")):
        return None
    try:
        layout = layout_of_text(path, begin)
        lines = lines_of(path, begin, layout.encoding)
    except LogError:
        return None
    headers = layout.headers(lines) if layout.named else ()
    places = _places(headers, fields(lines[layout.skipped], layout.separator))
    return partial(_open_text, path, layout, headers, places) if places else None


def table_of_records(path: Path, records: object) -> Table | None:
    """Table of records such as ``{"ts": 0.1, "topic": "axis/position", "value": 3.5}``; None of others."""
    if (
        not isinstance(records, list)
        or not records
        or not all(isinstance(record, Mapping) for record in records)
    ):
        return None
    headers = tuple(map(str, records[0]))
    places = _places(headers, [_text(value) for value in records[0].values()])
    if places is None:
        return None
    texts = [[_text(record.get(headers[place])) for place in places] for record in records]
    return _table(path, headers[places[0]], texts, decimal=".")


def _places(headers: Sequence[str], row: Sequence[str]) -> tuple[int, int, int] | None:
    """Columns of the time, the name and the value, where one column holds all values; None of other tables.

    >>> _places(("time", "tag", "value"), ("0", "pos", "1")), _places(("time", "channel 2", "value"), ("0", "1", "1"))
    ((0, 1, 2), None)
    """
    words = [words_of(split_header(header)[0]) for header in headers]
    times = [place for place, header in enumerate(headers) if quantity_named(header) == "time"]
    times.sort(key=lambda place: match(words[place], "start|stop") is not None)
    named, valued = (
        [place for place, word in enumerate(words) if match(word, pattern) and place not in times]
        for pattern in (_NAME, _VALUE)
    )
    named = [place for place in named if place < len(row) and not is_number_text(row[place], comma=True)]
    return (times[0], named[0], valued[0]) if times and named and len(valued) == 1 else None


def _open_text(path: Path, layout: Layout, headers: Sequence[str], places: tuple[int, int, int]) -> Table:
    text = path.read_bytes().decode(layout.encoding, errors="replace")
    lines = text.splitlines()
    first = lines.index(lines[layout.above])  # names may be repeated above the rows of each signal
    rows = [fields(line, layout.separator) for line in lines[first + 1 :]]
    texts = [[row[place].strip() for place in places] for row in rows if len(row) > max(places)]
    return _table(path, headers[places[0]], texts, decimal=layout.decimal)


def _table(path: Path, header: str, rows: Sequence[Sequence[str]], *, decimal: str) -> Table:
    """A column for each name, with the times of its rows; rows without a number are skipped."""
    kept = [row for row in rows if row[1] and row[2] and is_number_text(row[2], comma=decimal == ",")]
    if len(kept) < LEAST_ROWS:
        raise LogError(f"{path}: names signals in its rows, but has no values of them: export them as well")
    times, values = (
        values_of_texts(pl.Series([row[place] for row in kept]), ";", decimal=decimal) for place in (0, 2)
    )
    if isinstance(times, str) or isinstance(values, str):
        raise LogError(f"{path}: a column of its rows {times if isinstance(times, str) else values}")
    of_name: dict[str, list[int]] = {}
    for place, row in enumerate(kept):
        of_name.setdefault(row[1], []).append(place)
    if len(of_name) > _MOST:
        raise LogError(f"{path}: has rows of {len(of_name)} signals: give a file of at most {_MOST}")
    most = times[max(of_name.values(), key=len)]
    unit = described_column(header, most).unit
    if unit is None:
        raise LogError(f"{path}: its times {header!r} have no known unit: add it to the name, as in 't [ms]'")
    seconds: FloatArray = to_si(unit) * (times - times[0])
    return table_of_channels(
        [Channel(name, "", seconds[places], values[places]) for name, places in of_name.items()]
    )


def _text(value: Any) -> str:
    """Text of a JSON value; empty for one that is not the value of a signal."""
    return str(value) if isinstance(value, (str, int, float)) and not isinstance(value, bool) else ""
