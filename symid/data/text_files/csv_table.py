"""CSV files: the first line names the columns, which commas, semicolons or tabs separate."""

from __future__ import annotations

import bisect
import csv
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
import polars as pl

from symid.arrays import FloatArray
from symid.data.polars_tables import POLARS_FAILURES, source_of, values_of
from symid.data.table import Slices, Table, damaged, parsing
from symid.data.text_files.comma_pairs import are_pairs, with_points
from symid.data.text_files.grouped_numbers import without_groups
from symid.data.text_files.layout import Layout, first_lines, without_footer
from symid.data.text_files.text_table import (
    FORTRAN,
    fields,
    is_number_text,
    split_cell,
    uncommented,
    with_units,
)
from symid.data.text_files.time_stamps import has_time_of_day, seconds_of_stamps
from symid.errors import LogError

_CHUNK: Final = 4_194_304
"""Bytes of the chunks of lines in which a long file is read."""
_COMMENTS: Final = ("#", "%", "//")
"""Beginnings of lines between values that hold none."""
_NO_VALUE: Final = r"(?i)^(-?nan\(.*\)|-?1\.#\w+|#?n/?a|null|none|nil|over(flow)?|ovl|invalid|[-?*]+)$"
"""Words that programs write where they have no value."""


def open_csv(path: Path) -> Table:
    """Table in a CSV file; LogError if its first line holds no names."""
    first, second = _first_lines(path)
    separator = next((mark for mark in ("\t", ";") if mark in first), ",")
    headers = tuple(text.strip() for text in _fields(uncommented(first), separator))
    if not any(headers):
        raise LogError(f"{path}: the first line is empty: it must hold the names of the columns")
    if all(is_number_text(text, comma=True) for text in headers):
        raise LogError(
            f"{path}: the first line holds numbers: it must hold the names of the columns, or use symid import"
        )
    row = _fields(second, separator)
    if separator == "," and are_pairs([second.strip()], len(headers)):
        raise LogError(
            f"{path}: has {len(row)} fields below {len(headers)} names, as numbers with decimal commas have: let "
            "symid import look, or give its mapping"
        )
    file = _Csv(path, separator, max(len(headers), len(row)), headers)
    return Table(with_units(headers, row), file.read, file.slices)


def open_laid_out(path: Path, layout: Layout) -> Table:
    """Table in a CSV file whose layout is known: any encoding, lines above the header, lines of units."""
    return laid_out(path, layout, first_lines(path, layout.encoding), path.read_bytes)


def laid_out(path: Path, layout: Layout, lines: Sequence[str], content: Callable[[], bytes]) -> Table:
    """Table in the text of a file, by its layout and first lines."""
    skipped = layout.skipped
    if len(lines) <= skipped:
        raise LogError(
            f"{path}: ends before the values, which the layout places after line {skipped}: correct the layout"
        )
    of_pairs = layout.separator == layout.decimal
    row = fields(with_points(lines[skipped]) if of_pairs else lines[skipped], layout.separator)
    headers = with_units(layout.headers(lines), row)
    # a day alone, in a column beside the time of day, does not distinguish samples
    stamps = frozenset(i for i, text in enumerate(row) if has_time_of_day(text.strip(" \t\"'")))
    file = _Csv(path, layout.separator, max(len(headers), len(row)))

    decimal = "." if of_pairs else layout.decimal

    def read(positions: Sequence[int]) -> list[FloatArray | str]:
        try:
            text = content().decode(layout.encoding).replace("\r\n", "\n").replace("\r", "\n")
        except UnicodeError as error:
            raise LogError(f"{path}: is not text in {layout.encoding}: correct the encoding") from error
        *above, text = text.split("\n", skipped)
        text = without_footer(_without_lines(text, above), layout.separator)
        if of_pairs:
            text = _of_pairs(path, text, 2 * len(headers))
        if layout.separator == " ":
            text = "\n".join(" ".join(line.split()) for line in text.split("\n"))
        values = text.encode("utf-8", errors="replace")
        with parsing(path, "CSV", *POLARS_FAILURES):
            frame = file.scan(values, positions, pl.String(), header_rows=0)
        columns = _without_blank_end(frame)
        return [values_of_texts(series, layout.separator, decimal=decimal) for series in columns]

    return Table(headers, read, stamps=stamps)


def _of_pairs(path: Path, text: str, width: int) -> str:
    """Lines of numbers of two fields each, with decimal points; LogError if a line has another number of fields."""
    for place, line in enumerate(text.split("\n"), start=1):
        if line.strip() and line.count(",") + 1 != width:
            raise LogError(
                f"{path}: row {place} has {line.count(',') + 1} fields where {width // 2} numbers with decimal commas "
                f"have {width}: export it with semicolons between columns, or with decimal points"
            )
    return with_points(text)


def _without_lines(text: str, above: Sequence[str]) -> str:
    """Lines of values without comments and repeated headers, which joined files have."""
    repeated = {line for line in above if line.strip()}
    if not any(f"\n{line}\n" in text for line in repeated) and not any(
        f"\n{mark}" in text for mark in _COMMENTS
    ):
        return text
    lines = (line for line in text.split("\n") if not line.startswith(_COMMENTS))
    return "\n".join(line for line in lines if line and line not in repeated)


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


@dataclass(frozen=True)
class _Csv:
    """A CSV file with its separator and the number of its columns."""

    path: Path
    separator: str
    width: int
    headers: tuple[str, ...] = ()

    def read(self, positions: Sequence[int]) -> list[FloatArray | str]:
        """Values of columns, as those of a `Table`."""
        frame, numeric = self._frame(self.path, positions, header_rows=1)
        texts = _without_blank_end(frame if numeric else self._without_names(frame, positions))
        return [values_of(x) if numeric else values_of_texts(x, self.separator) for x in texts]

    def _without_names(self, frame: pl.DataFrame, positions: Sequence[int]) -> pl.DataFrame:
        """Rows of texts without those that repeat the line of names, as files that were joined do."""
        names = [self.headers[position] for position in positions]
        columns = zip(frame.columns, names, strict=True)
        return frame.filter(~pl.all_horizontal(pl.col(c).str.strip_chars().eq_missing(n) for c, n in columns))

    def slices(self, positions: Sequence[int]) -> Slices:
        """Slices of rows. Lines are counted once: numbers contain no quoted line ends, so that a line is a row."""
        lines = _Lines.of(self.path)

        def chunks(first: int, last: int) -> tuple[pl.DataFrame, bool]:
            with self.path.open("rb") as file:
                file.seek(lines.offsets[first])
                text = file.read(lines.offsets[last] - lines.offsets[first])
            return self._frame(text, positions, header_rows=0)

        def read(first: int, stop: int) -> list[FloatArray | str]:
            begin, end = bisect.bisect_right(lines.rows, first) - 1, bisect.bisect_left(lines.rows, stop)
            rows, numeric = chunks(begin, end)
            if rows.height < stop - lines.rows[begin]:
                raise LogError(
                    f"{self.path}: rows {first + 1} to {stop} have fewer lines than rows: write it again"
                )
            part = rows.slice(first - lines.rows[begin], stop - first)
            return [values_of(x) if numeric else values_of_texts(x, self.separator, first) for x in part]

        n_rows = 0
        for chunk in range(len(lines.rows) - 2, -1, -1):  # there may be blank lines at the end of the file
            if kept := _without_blank_end(chunks(chunk, chunk + 1)[0]).height:
                n_rows = lines.rows[chunk] + kept
                break
        return Slices(n_rows, read)

    def _frame(
        self, source: Path | bytes, positions: Sequence[int], header_rows: int
    ) -> tuple[pl.DataFrame, bool]:
        """Columns, and whether all of them are numbers; otherwise all are texts."""
        try:
            try:
                return self.scan(source, positions, pl.Float64(), header_rows), True
            except POLARS_FAILURES:
                return self.scan(source, positions, pl.String(), header_rows), False
        except POLARS_FAILURES as error:
            raise self._uneven() or damaged(self.path, "CSV", error) from error

    def scan(
        self, source: Path | bytes, positions: Sequence[int], dtype: pl.DataType, header_rows: int
    ) -> pl.DataFrame:
        """Columns of a type from the file, or from text of it; the exceptions are those of polars."""
        names = [f"column_{position}" for position in range(self.width)]
        wanted = [names[position] for position in positions]
        return pl.read_csv(
            source_of(source) if isinstance(source, Path) else source,
            has_header=False,
            skip_rows=header_rows,
            separator=self.separator,
            decimal_comma=self.separator != ",",  # points are understood as well
            schema={name: dtype if name in wanted else pl.String() for name in names},
            columns=sorted(set(positions)),
            missing_columns="insert",  # names above which no values stand
            encoding="utf8-lossy",
            glob=False,
        ).select(wanted)

    def _uneven(self) -> LogError | None:
        """Error that names the first row with more fields than there are columns, if there is one."""
        with self.path.open(encoding="utf-8", errors="replace", newline="") as file:
            for row, line in enumerate(file):
                n_fields = line.count(self.separator) + 1
                if n_fields > self.width:
                    return LogError(
                        f"{self.path}: row {row} has {n_fields} fields where there are {self.width} columns: correct it"
                    )
        return None


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


def _without_blank_end(frame: pl.DataFrame) -> pl.DataFrame:
    filled = np.flatnonzero(~frame.select(pl.all_horizontal(pl.all().is_null())).to_series().to_numpy())
    return frame.head(int(filled[-1]) + 1 if filled.size else 0)


def _without_unit(texts: pl.Series) -> pl.Series:
    """Texts without the unit that follows the number in the first of them."""
    unit = split_cell(next((text for text in texts if text), ""))[1]
    return texts.str.replace(rf"\s*{re.escape(unit)}$", "") if unit else texts


def values_of_texts(
    texts: pl.Series, separator: str, before: int | None = None, decimal: str = ""
) -> FloatArray | str:
    """Values of a column of texts, or of its rows after the first `before`; a sentence if they are not numbers."""
    cleaned = _without_unit(texts.str.strip_chars(" \t\"'").str.replace(_NO_VALUE, ""))
    cleaned = cleaned.str.replace(FORTRAN.pattern, "${1}e${2}")
    whole = before is None  # only a whole column distinguishes separators of thousands from decimal marks
    points, commas = (bool(cleaned.str.contains(mark, literal=True).any()) for mark in ".,")
    marked = points and (commas or decimal == ",")
    if whole and marked and (plain := without_groups(cleaned.fill_null("").to_list(), decimal)):
        cleaned = pl.Series(plain)
    elif separator != ",":
        cleaned = cleaned.str.replace(",", ".", literal=True)
    numbers = cleaned.cast(pl.Float64, strict=False)
    wrong = np.flatnonzero((numbers.is_null() & cleaned.is_not_null() & (cleaned != "")).to_numpy())
    if not wrong.size:
        return values_of(numbers)
    if not before and (seconds := seconds_of_stamps(cleaned)) is not None:
        return seconds
    plain = without_groups(cleaned.fill_null("").to_list()) if whole else None
    if plain is not None:
        return values_of(pl.Series(plain).cast(pl.Float64, strict=False))
    if wrong.size > 1 and wrong.size == np.count_nonzero((cleaned != "").fill_null(value=False).to_numpy()):
        return f"holds texts such as {texts[int(wrong[0])]!r} where numbers are required"
    first = int(wrong[0])
    more = f" and in {wrong.size - 1} more" if wrong.size > 1 else ""
    row = (before or 0) + first + 1
    return f"has {texts[first]!r} in row {row}{more} where a number is required: correct the file"
