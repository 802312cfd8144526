"""Parquet files: only the columns and rows asked for are read."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import polars as pl

from symid.arrays import FloatArray
from symid.data.table import POLARS_FAILURES, Slices, Table, damaged, source_of, values_of

_SMALL = 2**21
"""Bytes of a file up to which it is read at once: to look for the number of rows first takes half as long again."""


def open_parquet(path: Path) -> Table:
    """Table in a Parquet file; LogError if it is damaged."""
    try:
        scanned = pl.scan_parquet(source_of(path), glob=False)
        whole = scanned.collect() if path.stat().st_size <= _SMALL else None
        headers = tuple(scanned.collect_schema().names() if whole is None else whole.columns)
        n_rows = int(scanned.select(pl.len()).collect().item()) if whole is None else whole.height
    except POLARS_FAILURES as error:
        raise damaged(path, "Parquet", error) from error

    def names(positions: Sequence[int]) -> list[str]:
        return [headers[position] for position in positions]

    def read(positions: Sequence[int]) -> list[FloatArray | str]:
        if whole is None:
            return _read_parquet(path, names(positions))
        return [numbers_of(whole[name]) for name in names(positions)]

    return Table(
        headers,
        read,
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
    return [numbers_of(frame[name], first) for name in names]


def numbers_of(column: pl.Series, first: int = 0) -> FloatArray | str:
    """Numbers of a column, or a sentence on what it holds; moments and durations are seconds.

    Moments count from the first: only of a column that is read from its first row on.
    """
    if column.dtype.is_numeric():
        return values_of(column.cast(pl.Float64))
    if not first and isinstance(column.dtype, (pl.Datetime, pl.Duration)) and len(column):
        spans = column - column[0] if isinstance(column.dtype, pl.Datetime) else column
        return values_of(spans.dt.total_nanoseconds().cast(pl.Float64) * 1e-9)
    return f"holds {column.dtype} where numbers are required: convert the column"
