"""Files as tables of named columns: CSV, Parquet and MATLAB.

Of CSV and Parquet files only the headers and the columns asked for are read. What is wrong with a file as a
whole raises; what is wrong with one column is returned in its place, as a sentence, so that a caller can
report the faults of all columns together.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
import polars as pl
import scipy

from symid.arrays import FloatArray
from symid.data.layout import Layout, first_lines
from symid.errors import LogError

SUFFIXES: Final = (".csv", ".parquet", ".mat")
"""Kinds of files that can be read."""

_POLARS_FAILURES: Final = (pl.exceptions.PolarsError, pl.exceptions.PanicException, OSError, ValueError)
_NUMERIC_KINDS: Final = "biufc"


@dataclass(frozen=True)
class Table:
    """Named columns of a file.

    Parameters
    ----------
    headers : tuple of str
        Header of each column as written in the file.
    read : callable
        Takes positions of columns, gives for each its values, with NaN where the file has none, or a sentence
        that says why they cannot be used.
    """

    headers: tuple[str, ...]
    read: Callable[[Sequence[int]], list[FloatArray | str]]


def open_table(path: Path, layout: Layout | None = None) -> Table:
    """Table in a file, by its suffix; a CSV file by its layout if one is given, whatever its suffix.

    Raises
    ------
    LogError
        If the file does not exist, is of another kind, empty, or damaged.
    """
    if path.is_dir():
        raise LogError(f"{path}: is a directory: give a {_suffixes()} file")
    if not path.exists():
        raise LogError(f"{path}: there is no such file: check the path")
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES and layout is None:
        raise LogError(f"{path}: suffix {path.suffix!r} is not known: give a {_suffixes()} file")
    try:
        if path.stat().st_size == 0:
            raise LogError(f"{path}: is empty: give a file with a header and samples")
        if layout is not None and suffix not in (".parquet", ".mat"):
            return _open_laid_out(path, layout)
        if suffix == ".csv":
            return _open_csv(path)
        return _open_parquet(path) if suffix == ".parquet" else _open_mat(path)
    except OSError as error:
        raise LogError(f"{path}: cannot be read ({_first_line(error)}): check the file") from error


def _suffixes() -> str:
    return ", ".join(SUFFIXES[:-1]) + " or " + SUFFIXES[-1]


def _first_line(error: BaseException) -> str:
    lines = str(error).strip().splitlines()
    return lines[0].rstrip(".") if lines else type(error).__name__


def _damaged(path: Path, kind: str, error: BaseException) -> LogError:
    return LogError(f"{path}: is damaged or no {kind} file ({_first_line(error)}): write it again")


# CSV


def _open_csv(path: Path) -> Table:
    first, second = _first_lines(path)
    separator = next((mark for mark in ("\t", ";") if mark in first), ",")
    headers = tuple(text.strip() for text in _fields(first, separator))
    if not any(headers):
        raise LogError(f"{path}: the first line is empty: it must hold the names of the columns")
    if all(_is_number(text) for text in headers):
        raise LogError(f"{path}: the first line holds numbers: it must hold the names of the columns")
    width = max(len(headers), len(_fields(second, separator)))
    return Table(headers, lambda positions: _read_csv(path, separator, width, positions))


def _open_laid_out(path: Path, layout: Layout) -> Table:
    """A CSV file whose layout is known: any encoding, lines above the header, lines of units."""
    lines, skipped = first_lines(path, layout.encoding), layout.above + 1 + layout.below
    if len(lines) <= skipped:
        raise LogError(
            f"{path}: ends above the values, which the layout expects below line {skipped}: correct it"
        )
    headers = layout.headers(lines)
    width = max(len(headers), len(_fields(lines[skipped], layout.separator)))

    def read(positions: Sequence[int]) -> list[FloatArray | str]:
        try:
            text = path.read_text(encoding=layout.encoding)
        except UnicodeError as error:
            raise LogError(f"{path}: is not text in {layout.encoding}: correct the encoding") from error
        values = text.split("\n", skipped)[-1].encode("utf-8")
        frame = _scan_csv(values, layout.separator, width, positions, pl.String(), skip_rows=0)
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
    return next(csv.reader([line], delimiter=separator), [])


def _is_number(text: str) -> bool:
    try:
        float(text.replace(",", "."))
    except ValueError:
        return False
    return True


def _read_csv(path: Path, separator: str, width: int, positions: Sequence[int]) -> list[FloatArray | str]:
    try:
        frame = _scan_csv(path, separator, width, positions, pl.Float64())
    except _POLARS_FAILURES:
        return _read_csv_as_text(path, separator, width, positions)
    return [_values(series) for series in _without_blank_end(frame)]


def _scan_csv(
    path: Path | bytes,
    separator: str,
    width: int,
    positions: Sequence[int],
    dtype: pl.DataType,
    skip_rows: int = 1,
) -> pl.DataFrame:
    names = [f"column_{position}" for position in range(width)]
    wanted = [names[position] for position in positions]
    return pl.read_csv(
        path,
        has_header=False,
        skip_rows=skip_rows,
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
    """Slow way, for files in which something is no number: find out which value in which row."""
    try:
        frame = _scan_csv(path, separator, width, positions, pl.String())
    except _POLARS_FAILURES as error:
        raise _uneven(path, separator, width) or _damaged(path, "CSV", error) from error
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


def _values_of_text(texts: pl.Series, separator: str) -> FloatArray | str:
    cleaned = texts.str.strip_chars(" \t\"'")
    if separator != ",":
        cleaned = cleaned.str.replace(",", ".", literal=True)
    numbers = cleaned.cast(pl.Float64, strict=False)
    wrong = np.flatnonzero((numbers.is_null() & cleaned.is_not_null() & (cleaned != "")).to_numpy())
    if not wrong.size:
        return _values(numbers)
    first = int(wrong[0])
    more = f" and in {wrong.size - 1} more" if wrong.size > 1 else ""
    return f"has {texts[first]!r} in row {first + 1}{more} where a number is required: correct the file"


# Parquet


def _open_parquet(path: Path) -> Table:
    try:
        headers = tuple(pl.scan_parquet(path, glob=False).collect_schema().names())
    except _POLARS_FAILURES as error:
        raise _damaged(path, "Parquet", error) from error
    return Table(
        headers, lambda positions: _read_parquet(path, [headers[position] for position in positions])
    )


def _read_parquet(path: Path, names: Sequence[str]) -> list[FloatArray | str]:
    try:
        frame = pl.scan_parquet(path, glob=False).select(sorted(set(names))).collect()
    except _POLARS_FAILURES as error:
        raise _damaged(path, "Parquet", error) from error
    return [
        _values(frame[name].cast(pl.Float64))
        if frame[name].dtype.is_numeric()
        else f"holds {frame[name].dtype} where numbers are required: convert the column"
        for name in names
    ]


def _values(numbers: pl.Series) -> FloatArray:
    return np.asarray(numbers.fill_null(float("nan")).to_numpy(), dtype=np.float64)


# MATLAB


def _open_mat(path: Path) -> Table:
    with path.open("rb") as file:
        begin = file.read(520)
    if b"MATLAB 7.3" in begin[:128] or b"\x89HDF\r\n\x1a\n" in begin:
        raise LogError(f"{path}: is a MATLAB file of version 7.3: save it with save(..., '-v7')")
    try:
        # Listing the variables without loading them (whosmat) fails on objects such as tf models.
        variables = scipy.io.loadmat(path)
    except Exception as error:  # scipy lets through whatever its parser meets in a damaged file
        raise _damaged(path, "MATLAB", error) from error
    arrays = {
        name: array
        for name, array in variables.items()
        if isinstance(array, np.ndarray)
        and not name.startswith("__")
        and array.dtype.kind in _NUMERIC_KINDS
        and array.size != 1
    }
    headers = tuple(arrays)
    return Table(headers, lambda positions: [_vector(arrays[headers[position]]) for position in positions])


def _vector(array: np.ndarray) -> FloatArray | str:
    if array.size == 0:
        return "is empty: save it with samples"
    if np.iscomplexobj(array):
        return "is complex where real numbers are required: save its real part"
    if array.size != max(array.shape):
        shape = " x ".join(str(size) for size in array.shape)
        return f"is an array of {shape} where a vector is required: save each signal on its own"
    return array.ravel().astype(np.float64)
