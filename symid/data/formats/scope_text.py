"""Text of scopes that write lines of properties above their columns: TwinCAT Scope and ControlDesk of dSPACE.

TwinCAT writes a column of times, in ms or as stamps of 100 ns, before each channel, or before all channels of one
sample time. The name of a property stands above each column of times, and its values above the channels. ControlDesk
writes the names of its properties in the first column, and the values beside it, below ``trace_values``.
"""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Final, TypeAlias

import numpy as np

from symid.arrays import FloatArray
from symid.data.formats.channels import Channel, table_of_channels
from symid.data.table import Table
from symid.data.text_files.csv_table import open_laid_out
from symid.data.text_files.layout import Layout, encoding_of, has_decimal_comma, lines_of
from symid.data.text_files.text_table import fields, is_number_text
from symid.errors import LogError

_Channels: TypeAlias = "Callable[[Path, Sequence[Sequence[str]], Table], Table]"

_SEPARATORS: Final = ("\t", ";", ",")
_OF_CHANNELS: Final = ("SymbolComment", "Data-Type", "SampleTime[ms]", "SymbolName", "NetID")
"""Properties of channels that no other program writes."""
_TWINCAT: Final = ("Name", *_OF_CHANNELS, "Unit")
_OF_EXPORT: Final = ("Starttime of export", "StartRecord")
"""Properties of a file; with ``Name``, one of them or of the channels begins a line of such a file."""
_STAMP, _ROUNDED = 1e-7, 32.0
"""Unit of a full time stamp, s, and rounding error of one in 64 bits, in such units."""
_VALUES: Final = "trace_values"
_END: Final = "EOF"
_NAMES, _UNITS = ("name", "path", "variable"), ("unit",)


def scope_text_in(path: Path, begin: bytes) -> Callable[[], Table] | None:
    """Reader of a text file that begins as that of a scope; None of others."""
    letters = begin.replace(b"\x00", b"")  # of UTF-16
    if b"Name" not in letters and _VALUES.encode() not in letters:
        return None
    encoding = encoding_of(begin)
    try:
        lines = lines_of(path, begin, encoding)
    except LogError:
        return None
    for separator in _SEPARATORS:
        keys = [fields(line, separator)[:1] for line in lines]
        first = [key[0].strip() for key in keys if key]
        if _VALUES in first:
            return partial(_open_scope, path, lines, encoding, separator, _dspace)
        known = any(name in first for name in (*_OF_CHANNELS, *_OF_EXPORT))
        if "Name" in first and known:
            return partial(_open_scope, path, lines, encoding, separator, _twincat)
    return None


def _open_scope(
    path: Path, lines: Sequence[str], encoding: str, separator: str, channels: _Channels
) -> Table:
    """Table in the text of a scope that begins with `lines`; LogError if it holds no values below its properties."""
    rows = [[text.strip() for text in fields(line, separator)] for line in lines]
    begin = _begin(path, rows, separator)
    comma = separator != "," and has_decimal_comma(lines[begin:], separator)
    layout = Layout(encoding, separator, "," if comma else ".", begin, named=False)
    return channels(path, rows[:begin], open_laid_out(path, layout))


def _begin(path: Path, rows: Sequence[Sequence[str]], separator: str) -> int:
    """The first row of values: each of its fields is a number or empty, and so are those of all rows below."""

    def is_value(text: str) -> bool:
        return is_number_text(text, comma=separator != ",")

    while rows and rows[-1] in ([_END], []):
        rows = rows[:-1]
    begin = len(rows)
    for row in reversed(rows):
        first, others = row[:1], [text for text in row[1:] if text]
        if (
            not others
            or not all(map(is_value, others))
            or not (first[0] in (_VALUES, "") or is_value(first[0]))
        ):
            break
        begin -= 1
    if begin == len(rows):
        raise LogError(f"{path}: there are no values below the properties: export the scope again")
    return begin


def _twincat(path: Path, above: Sequence[Sequence[str]], values: Table) -> Table:
    """Channels with their clocks; the stated sample time determines the unit of the times, ms without one."""
    properties = {row[0]: row for row in above if row and row[0] in _TWINCAT}
    names = properties["Name"][: len(values.headers)]

    def stated(name: str, position: int) -> str:
        row = properties.get(name, [])
        return row[position] if position < len(row) else ""

    columns = values.read(range(len(names)))
    channels = []
    clock: FloatArray | str = ""
    for k, (name, samples) in enumerate(zip(names, columns, strict=True)):
        if name == "Name":  # above a column of times, which those to its right share
            clock = samples
            continue
        if isinstance(clock, str) or isinstance(samples, str):
            continue
        there = np.isfinite(clock) & np.isfinite(samples)
        time = _seconds(clock[there], stated("SampleTime[ms]", k))
        unit = stated("Unit", k).partition("(")[0].strip()  # "mm (Length)", "(None)"
        channels.append(Channel(name, unit, time, samples[there]))
    if not channels:
        raise LogError(
            f"{path}: no channel has times and values: export the scope again, with a timeline for each sample time"
        )
    return table_of_channels(channels)


def _seconds(time: FloatArray, stated: str) -> FloatArray:
    """Times in seconds, by the decimal unit that makes their steps the stated sample time; ms without one.

    Full stamps count from the first: 64 bit hold those of today to some us, which the sample time makes exact.
    """
    if time.size < 2 or not stated or not is_number_text(stated, comma=True):
        return 1e-3 * time
    step = 1e-3 * float(stated.replace(",", "."))
    ratio = step / float(np.median(np.diff(time)))
    if not (np.isfinite(ratio) and ratio > 0):
        return 1e-3 * time
    nearest = 10.0 ** round(np.log10(ratio))
    if not np.isclose(nearest, _STAMP):
        factor: float = nearest if nearest in (1.0, 1e-3, 1e-6, 1e-9) else 1e-3
        return factor * time
    since = _STAMP * (time - time[0])
    even = step * np.round(since / step)
    return np.asarray(even if np.abs(even - since).max() < _ROUNDED * _STAMP else since)


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
    by_key = {row[0].lower(): list(row) for row in rows if row}
    return next((by_key[key] for key in keys if key in by_key), None)
