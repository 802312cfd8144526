"""CSV files as tables: the first line names the columns, which commas, semicolons or tabs separate."""

from __future__ import annotations

import bisect
import csv
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
import polars as pl

from symid.arrays import FloatArray
from symid.data.layout import Layout, fields, first_lines, layout_of_text, lines_of, uncommented
from symid.data.table import POLARS_FAILURES, Slices, Table, damaged, source_of, values_of
from symid.data.time_stamps import seconds_of_stamps
from symid.errors import LogError

_CHUNK: Final = 4_194_304
"""Bytes of the chunks of lines in which a long file is read."""


def open_csv(path: Path) -> Table:
    """Table in a CSV file; LogError if its first line holds no names."""
    first, second = _first_lines(path)
    separator = next((mark for mark in ("\t", ";") if mark in first), ",")
    headers = tuple(text.strip() for text in _fields(uncommented(first), separator))
    if not any(headers):
        raise LogError(f"{path}: the first line is empty: it must hold the names of the columns")
    if all(_is_number(text) for text in headers):
        raise LogError(
            f"{path}: the first line holds numbers: it must hold the names of the columns, or let symid import look"
        )
    width = max(len(headers), len(_fields(second, separator)))
    return Table(
        headers,
        lambda positions: _read_csv(path, separator, width, positions),
        lambda positions: _slices(path, separator, width, positions),
    )


def open_laid_out(path: Path, layout: Layout) -> Table:
    """Table in a CSV file whose layout is known: any encoding, lines above the header, lines of units."""
    return _laid_out(path, layout, first_lines(path, layout.encoding), path.read_bytes)


def open_text(path: Path, text: bytes, layout: Layout | None = None) -> Table:
    """Table in text from another file, of a layout that is given or guessed; LogError if it holds no numbers."""
    given = layout or layout_of_text(path, text)
    return _laid_out(path, given, lines_of(path, text, given.encoding), lambda: text)


def _laid_out(path: Path, layout: Layout, lines: Sequence[str], content: Callable[[], bytes]) -> Table:
    skipped = layout.skipped
    if len(lines) <= skipped:
        raise LogError(
            f"{path}: ends above the values, which the layout expects below line {skipped}: correct it"
        )
    headers = layout.headers(lines)
    width = max(len(headers), len(fields(lines[skipped], layout.separator)))

    def read(positions: Sequence[int]) -> list[FloatArray | str]:
        try:
            text = content().decode(layout.encoding).replace("\r\n", "\n").replace("\r", "\n")
        except UnicodeError as error:
            raise LogError(f"{path}: is not text in {layout.encoding}: correct the encoding") from error
        text = text.split("\n", skipped)[-1]
        if layout.separator == " ":
            text = "\n".join(" ".join(line.split()) for line in text.split("\n"))
        values = text.encode("utf-8", errors="replace")
        try:
            frame = _scan_csv(values, layout.separator, width, positions, pl.String(), header_rows=0)
        except POLARS_FAILURES as error:
            raise damaged(path, "CSV", error) from error
        return [_values_of_text(series, layout.separator) for series in _without_blank_end(frame)]

    return Table(headers, read)


def _first_lines(path: Path) -> tuple[str, str]:
    with path.open("rb") as file:
        lines = [file.readline(1_000_000) for _ in range(2)]
    if lines[0].startswith((b"\xff\xfe", b"\xfe\xff")) or b"\x00" in lines[0]:
        raise LogError(f"{path}: is not text in UTF-8: save it as CSV in UTF-8")
    try:
        first = lines[0].decode("utf-8-sig")
    except UnicodeDecodeError:
        first = lines[0].decode("latin-1")
    return first.rstrip("\r\n"), lines[1].decode("latin-1").rstrip("\r\n")


def _fields(line: str, separator: str) -> list[str]:
    try:
        return next(csv.reader([line], delimiter=separator), [])
    except csv.Error as error:
        raise LogError(
            f"a line is not text with separators ({error}): save the log as CSV in UTF-8"
        ) from error


def _is_number(text: str) -> bool:
    try:
        float(text.replace(",", "."))
    except ValueError:
        return False
    return True


def _read_csv(path: Path, separator: str, width: int, positions: Sequence[int]) -> list[FloatArray | str]:
    try:
        frame = _scan_csv(path, separator, width, positions, pl.Float64())
    except POLARS_FAILURES:
        return _read_csv_as_text(path, separator, width, positions)
    return [values_of(series) for series in _without_blank_end(frame)]


def _scan_csv(
    source: Path | bytes,
    separator: str,
    width: int,
    positions: Sequence[int],
    dtype: pl.DataType,
    header_rows: int = 1,
) -> pl.DataFrame:
    names = [f"column_{position}" for position in range(width)]
    wanted = [names[position] for position in positions]
    return pl.read_csv(
        source_of(source) if isinstance(source, Path) else source,
        has_header=False,
        skip_rows=header_rows,
        separator=separator,
        decimal_comma=separator != ",",  # points are understood as well
        schema={name: dtype if name in wanted else pl.String() for name in names},
        columns=sorted(set(positions)),
        encoding="utf8-lossy",
        glob=False,
    ).select(wanted)


def _read_csv_as_text(
    path: Path, separator: str, width: int, positions: Sequence[int]
) -> list[FloatArray | str]:
    """Read a file value by value to find the first value that is not a number."""
    try:
        frame = _scan_csv(path, separator, width, positions, pl.String())
    except POLARS_FAILURES as error:
        raise _uneven(path, separator, width) or damaged(path, "CSV", error) from error
    return [_values_of_text(series, separator) for series in _without_blank_end(frame)]


def _uneven(path: Path, separator: str, width: int) -> LogError | None:
    """Error that names the first row with more fields than there are columns, if there is one."""
    with path.open(encoding="utf-8", errors="replace", newline="") as file:
        for row, line in enumerate(file):
            n_fields = line.count(separator) + 1
            if n_fields > width:
                return LogError(
                    f"{path}: row {row} has {n_fields} fields where there are {width} columns: correct it"
                )
    return None


def _without_blank_end(frame: pl.DataFrame) -> pl.DataFrame:
    """The frame without the blank lines at its end."""
    filled = np.flatnonzero(~frame.select(pl.all_horizontal(pl.all().is_null())).to_series().to_numpy())
    return frame.head(int(filled[-1]) + 1 if filled.size else 0)


def _values_of_text(texts: pl.Series, separator: str, before: int = 0) -> FloatArray | str:
    cleaned = texts.str.strip_chars(" \t\"'")
    if separator != ",":
        cleaned = cleaned.str.replace(",", ".", literal=True)
    numbers = cleaned.cast(pl.Float64, strict=False)
    wrong = np.flatnonzero((numbers.is_null() & cleaned.is_not_null() & (cleaned != "")).to_numpy())
    if not wrong.size:
        return values_of(numbers)
    if not before and (seconds := seconds_of_stamps(cleaned)) is not None:
        return seconds
    first = int(wrong[0])
    more = f" and in {wrong.size - 1} more" if wrong.size > 1 else ""
    return (
        f"has {texts[first]!r} in row {before + first + 1}{more} where a number is required: correct the file"
    )


# Slices


@dataclass(frozen=True)
class _Lines:
    """Bytes and rows before each chunk of a CSV file; the last ones are those of the file."""

    offsets: list[int]
    rows: list[int]

    @classmethod
    def of(cls, path: Path) -> _Lines:
        with path.open("rb") as file:
            file.readline()
            offsets, rows = [file.tell()], [0]
            while chunk := file.read(_CHUNK) + file.readline():
                offsets.append(file.tell())
                rows.append(rows[-1] + chunk.count(b"\n") + (not chunk.endswith(b"\n")))
        return cls(offsets, rows)

    def chunks(self, first: int, stop: int) -> tuple[int, int]:
        """Chunks that hold the rows from `first` to before `stop`."""
        return bisect.bisect_right(self.rows, first) - 1, bisect.bisect_left(self.rows, stop)


def _slices(path: Path, separator: str, width: int, positions: Sequence[int]) -> Slices:
    """Rows by the place of their lines, which are counted once: numbers have no line ends in quotes."""
    lines = _Lines.of(path)

    def frame(first: int, last: int) -> tuple[pl.DataFrame, bool]:
        with path.open("rb") as file:
            file.seek(lines.offsets[first])
            text = file.read(lines.offsets[last] - lines.offsets[first])
        try:
            try:
                return _scan_csv(text, separator, width, positions, pl.Float64(), 0), True
            except POLARS_FAILURES:
                return _scan_csv(text, separator, width, positions, pl.String(), 0), False
        except POLARS_FAILURES as error:
            raise _uneven(path, separator, width) or damaged(path, "CSV", error) from error

    def read(first: int, stop: int) -> list[FloatArray | str]:
        begin, end = lines.chunks(first, stop)
        rows, numeric = frame(begin, end)
        if rows.height < stop - lines.rows[begin]:
            raise LogError(f"{path}: rows {first + 1} to {stop} have fewer lines than rows: write it again")
        part = rows.slice(first - lines.rows[begin], stop - first)
        return [values_of(x) if numeric else _values_of_text(x, separator, first) for x in part]

    return Slices(_filled(lines, frame), read)


def _filled(lines: _Lines, frame: Callable[[int, int], tuple[pl.DataFrame, bool]]) -> int:
    """Rows without the blank lines at the end of the file."""
    for chunk in range(len(lines.rows) - 2, -1, -1):
        if kept := _without_blank_end(frame(chunk, chunk + 1)[0]).height:
            return lines.rows[chunk] + kept
    return 0
