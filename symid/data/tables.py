"""Files as tables of named columns: CSV, Parquet and MATLAB.

Of CSV and Parquet files only the headers and the columns asked for are read. What is wrong with a file as a
whole raises; what is wrong with one column is returned in its place, as a sentence, so that a caller can
report the faults of all columns together.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np
import polars as pl
import scipy

from symid.arrays import FloatArray
from symid.data.csv_table import open_csv, open_laid_out
from symid.data.layout import Layout
from symid.data.memory import require_room
from symid.data.table import (
    POLARS_FAILURES,
    Slices,
    Table,
    damaged,
    first_line,
    said_of,
    source_of,
    values_of,
)
from symid.errors import LogError
from symid.files import require_regular

SUFFIXES: Final = (".csv", ".parquet", ".mat")
"""Kinds of files that can be read."""

_NUMERIC_KINDS: Final = "biufc"


def open_table(path: Path, layout: Layout | None = None, memory: int | None = None) -> Table:
    """Table in a file, by its suffix; a CSV file by its layout if one is given, whatever its suffix.

    Parameters
    ----------
    path : Path
        The file.
    layout : Layout, optional
        Of a CSV file.
    memory : int, optional
        Bytes that the arrays of a MATLAB file may take, which is read at once; those that are free by default.

    Raises
    ------
    LogError
        If the file does not exist, is of another kind, empty, or damaged.
    """
    if path.is_dir():
        raise LogError(f"{path}: is a directory: give a {_suffixes()} file")
    require_regular(path, LogError)
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES and layout is None:
        raise LogError(f"{path}: suffix {path.suffix!r} is not known: give a {_suffixes()} file")
    try:
        if path.stat().st_size == 0:
            raise LogError(f"{path}: is empty: give a file with a header and samples")
        if layout is not None and suffix not in (".parquet", ".mat"):
            return open_laid_out(path, layout)
        if suffix == ".csv":
            with said_of(path):
                return open_csv(path)
        return _open_parquet(path) if suffix == ".parquet" else _open_mat(path, memory)
    except OSError as error:
        raise LogError(f"{path}: cannot be read ({first_line(error)}): check the file") from error


def _suffixes() -> str:
    return ", ".join(SUFFIXES[:-1]) + " or " + SUFFIXES[-1]


# Parquet


def _open_parquet(path: Path) -> Table:
    try:
        scanned = pl.scan_parquet(source_of(path), glob=False)
        headers = tuple(scanned.collect_schema().names())
        n_rows = int(scanned.select(pl.len()).collect().item())
    except POLARS_FAILURES as error:
        raise damaged(path, "Parquet", error) from error

    def names(positions: Sequence[int]) -> list[str]:
        return [headers[position] for position in positions]

    return Table(
        headers,
        lambda positions: _read_parquet(path, names(positions)),
        lambda positions: Slices(n_rows, partial(_read_parquet, path, names(positions))),
        n_rows,
    )


def _read_parquet(
    path: Path, names: Sequence[str], first: int = 0, stop: int | None = None
) -> list[FloatArray | str]:
    wanted = pl.scan_parquet(source_of(path), glob=False).select(sorted(set(names)))
    try:
        frame = wanted.slice(first, None if stop is None else stop - first).collect()
    except POLARS_FAILURES as error:
        raise damaged(path, "Parquet", error) from error
    return [
        values_of(frame[name].cast(pl.Float64))
        if frame[name].dtype.is_numeric()
        else f"holds {frame[name].dtype} where numbers are required: convert the column"
        for name in names
    ]


# MATLAB


def _open_mat(path: Path, memory: int | None) -> Table:
    with path.open("rb") as file:
        begin = file.read(520)
    if b"MATLAB 7.3" in begin[:128] or b"\x89HDF\r\n\x1a\n" in begin:
        raise LogError(f"{path}: is a MATLAB file of version 7.3: save it with save(..., '-v7')")
    try:
        # Listing the variables without loading them (whosmat) fails on objects such as tf models.
        _require_room_for(path, memory)
        variables = scipy.io.loadmat(path)
    except LogError:
        raise
    except Exception as error:  # scipy lets through whatever its parser meets in a damaged file
        raise damaged(path, "MATLAB", error) from error
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


def _require_room_for(path: Path, memory: int | None) -> None:
    """Raise LogError if the arrays of a MATLAB file, which may be compressed, would not fit."""
    try:
        listed = scipy.io.whosmat(path)
    except Exception:  # noqa: BLE001  what cannot be listed may still be loaded
        return
    require_room(sum(math.prod(map(int, shape)) for _, shape, _ in listed), memory)


def _vector(array: np.ndarray) -> FloatArray | str:
    if array.size == 0:
        return "is empty: save it with samples"
    if np.iscomplexobj(array):
        return "is complex where real numbers are required: save its real part"
    if array.size != max(array.shape):
        shape = " x ".join(str(size) for size in array.shape)
        return f"is an array of {shape} where a vector is required: save each signal on its own"
    return array.ravel().astype(np.float64)
