"""Text of scopes that write lines of properties above their columns: TwinCAT Scope and ControlDesk of dSPACE.

TwinCAT writes a column of times, in ms, before the values of each channel. ControlDesk writes the names of its
properties in the first column, and the values beside it, below ``trace_values``.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final, Literal

import numpy as np

from symid.arrays import FloatArray
from symid.data.csv_table import open_laid_out
from symid.data.formats.channels import Channel, table_of_channels
from symid.data.layout import Layout, encoding_of, fields, has_decimal_comma, is_number, lines_of
from symid.data.table import Table
from symid.errors import LogError

Writer = Literal["twincat", "dspace"]

_BEGINNING: Final = 800_000
_SEPARATORS: Final = ("\t", ";", ",")
_TWINCAT: Final = ("Name", "SymbolComment", "Data-Type", "SampleTime[ms]", "SymbolName", "NetID")
"""Properties of which at least two begin lines of such a file, ``Name`` the first of them."""
_VALUES: Final = "trace_values"
_NAMES, _UNITS = ("name", "path", "variable"), ("unit",)


def writer_of(path: Path) -> tuple[Writer, str] | None:
    """Which scope wrote a text file, and the separator; None for any other file."""
    with path.open("rb") as file:
        begin = file.read(_BEGINNING)
    letters = begin.replace(b"\x00", b"")  # of UTF-16
    if b"Name" not in letters and _VALUES.encode() not in letters:
        return None
    try:
        lines = lines_of(path, begin, encoding_of(begin))
    except LogError:
        return None
    for separator in _SEPARATORS:
        keys = [fields(line, separator)[:1] for line in lines]
        first = [key[0].strip() for key in keys if key]
        if _VALUES in first:
            return "dspace", separator
        if "Name" in first and sum(property in first for property in _TWINCAT) > 1:
            return "twincat", separator
    return None


def open_scope_text(path: Path, writer: Writer, separator: str) -> Table:
    """Table in the text of a scope; LogError if it holds no values below its properties."""
    with path.open("rb") as file:
        content = file.read(_BEGINNING)
    encoding = encoding_of(content)
    lines = lines_of(path, content, encoding)
    rows = [[text.strip() for text in fields(line, separator)] for line in lines]
    begin = _begin(path, rows, separator)
    comma = separator != "," and has_decimal_comma(lines[begin:], separator)
    layout = Layout(encoding, separator, "," if comma else ".", begin, named=False)
    values = open_laid_out(path, layout)
    return (_twincat if writer == "twincat" else _dspace)(path, rows[:begin], values)


def _begin(path: Path, rows: Sequence[Sequence[str]], separator: str) -> int:
    """The first row of values: its second field is a number, and so are those of all rows below."""

    def is_value(text: str) -> bool:
        return is_number(text, comma=separator != ",")

    begin = len(rows)
    for row in reversed(rows):
        numbers = [text for text in row[1:] if text]
        if not numbers or not all(map(is_value, numbers)) or not (row[0] == _VALUES or is_value(row[0])):
            break
        begin -= 1
    if begin == len(rows):
        raise LogError(f"{path}: there are no values below the properties: export the scope again")
    return begin


def _twincat(path: Path, above: Sequence[Sequence[str]], values: Table) -> Table:
    """Channels with their clocks; the stated sample time determines the unit of the times, ms without one."""
    properties = {row[0]: row for row in above if row and row[0] in _TWINCAT}
    names, stated = properties["Name"], properties.get("SampleTime[ms]", [])
    count = min(len(names), len(values.headers)) // 2
    columns = values.read(range(2 * count))
    channels = []
    for k in range(count):
        time, samples = columns[2 * k], columns[2 * k + 1]
        if isinstance(time, str) or isinstance(samples, str):
            continue
        there = np.isfinite(time) & np.isfinite(samples)
        step = stated[2 * k + 1] if len(stated) > 2 * k + 1 else ""
        factor = _seconds(time[there], step)
        channels.append(Channel(names[2 * k + 1], "", factor * time[there], samples[there]))
    if not channels:
        raise LogError(f"{path}: no channel has values: export the scope again")
    return table_of_channels(channels)


def _seconds(time: FloatArray, stated: str) -> float:
    """Seconds in the unit of the times: the decimal unit that makes their steps the stated sample time."""
    if time.size < 2 or not stated or not is_number(stated, comma=True):
        return 1e-3
    ratio = 1e-3 * float(stated.replace(",", ".")) / float(np.median(np.diff(time)))
    if not (np.isfinite(ratio) and ratio > 0):
        return 1e-3
    nearest = 10.0 ** round(np.log10(ratio))
    return float(nearest) if nearest in (1.0, 1e-3, 1e-6, 1e-7, 1e-9) else 1e-3


def _dspace(path: Path, above: Sequence[Sequence[str]], values: Table) -> Table:
    """Columns behind the first, named by the properties."""
    named = _property(above, _NAMES)
    if named is None:
        raise LogError(f"{path}: no line above {_VALUES} names the columns: export the recording again")
    units = _property(above, _UNITS) or []
    count = min(len(named), len(values.headers))
    headers = tuple(
        f"{named[k]} [{units[k]}]" if k < len(units) and units[k] else named[k] for k in range(1, count)
    )
    return Table(headers, lambda positions: values.read([position + 1 for position in positions]))


def _property(rows: Sequence[Sequence[str]], keys: Sequence[str]) -> list[str] | None:
    found = {row[0].lower(): list(row) for row in rows if row}
    return next((found[key] for key in keys if key in found), None)
