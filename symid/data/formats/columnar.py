"""Parquet and Feather files: only the columns and rows asked for are read."""

import contextlib
import io
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path

import polars as pl

from symid.arrays import FloatArray
from symid.data.polars_tables import POLARS_FAILURES, source_of, values_of
from symid.data.table import Slices, Table, parsing
from symid.data.text_files.csv_table import values_of_texts

_SMALL = 2**21
"""Bytes up to which a file is read at once: polars takes 1.5 times as long if it opens the file itself, or counts its
rows first."""


def open_parquet(path: Path, memory: int | None = None) -> Table:
    """Table in a Parquet file; LogError if it is damaged."""
    return _opened(path, "Parquet", partial(pl.scan_parquet, glob=False))


def open_feather(path: Path, memory: int | None = None) -> Table:
    """Table in a Feather file (Arrow IPC), always read as a whole; LogError if it is damaged."""
    with _native_silence():
        table = _opened(path, "Feather", _scan_arrow)
    if path.stat().st_size <= _SMALL:
        return replace(table, slices=None)

    def read(positions: Sequence[int]) -> list[FloatArray | str]:
        with _native_silence():
            return table.read(positions)

    return replace(table, read=read, slices=None)


def _scan_arrow(source: Path | io.BytesIO) -> pl.LazyFrame:
    """Rows of a file, or of a stream, of Arrow."""
    with contextlib.ExitStack() as opened:
        file = source if isinstance(source, io.BytesIO) else opened.enter_context(source.open("rb"))
        is_stream = file.read(4) == b"\xff" * 4
        file.seek(0)
    return pl.read_ipc_stream(source).lazy() if is_stream else pl.scan_ipc(source)


@contextmanager
def _native_silence() -> Iterator[None]:
    """Drop what threads of polars print on standard error: 50 lines for a damaged file, beside the exception."""
    if sys.stderr is not None:
        sys.stderr.flush()
    try:
        kept = os.dup(2)
    except OSError:  # it is closed
        yield
        return
    try:
        with open(os.devnull, "w", encoding="utf-8") as nothing:
            os.dup2(nothing.fileno(), 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)


def _opened(path: Path, kind: str, scan: Callable[..., pl.LazyFrame]) -> Table:
    with parsing(path, kind, *POLARS_FAILURES):
        is_small = path.stat().st_size <= _SMALL
        scanned = _flat(scan(io.BytesIO(path.read_bytes()) if is_small else source_of(path)))
        whole = scanned.collect() if is_small else None
        schema = scanned.collect_schema() if whole is None else whole.schema
        headers = tuple(schema)
        n_rows = int(scanned.select(pl.len()).collect().item()) if whole is None else whole.height

    def read(positions: Sequence[int], first: int = 0, stop: int | None = None) -> list[FloatArray | str]:
        names = [headers[position] for position in positions]
        count, before = (None, None) if stop is None else (stop - first, first)
        if whole is not None:
            return [numbers_of(whole[name].slice(first, count), before) for name in names]
        with parsing(path, kind, *POLARS_FAILURES):
            frame = _flat(scan(source_of(path))).select(sorted(set(names))).slice(first, count).collect()
        return [numbers_of(frame[name], before) for name in names]

    moments = frozenset(place for place, kind in enumerate(schema.values()) if kind.is_temporal())
    return Table(
        headers, read, lambda positions: Slices(n_rows, partial(read, positions)), n_rows, stamps=moments
    )


def _flat(frame: pl.LazyFrame) -> pl.LazyFrame:
    """A frame with the fields of its structs as columns."""
    schema = frame.collect_schema()
    if not any(isinstance(kind, pl.Struct) for kind in schema.values()):
        return frame
    return _flat(
        frame.select(
            pl.col(name).struct.field(field.name).alias(f"{name}.{field.name}") if field else pl.col(name)
            for name, kind in schema.items()
            for field in (kind.fields if isinstance(kind, pl.Struct) else (None,))
        )
    )


def numbers_of(column: pl.Series, first: int | None = None) -> FloatArray | str:
    """Numbers of a column, or a sentence on what it holds instead; moments and durations become seconds.

    Moments count from the first one, so they are read only from a whole column, or from row 0 on (`first`).
    """
    if column.dtype.is_numeric():
        return values_of(column.cast(pl.Float64))
    if column.dtype == pl.Time:
        return numbers_of(column.cast(pl.Duration("ns")), first)
    if column.dtype == pl.String:
        return values_of_texts(column, ";", first)
    if not first and isinstance(column.dtype, (pl.Datetime, pl.Duration)) and len(column):
        spans = column - column[0] if isinstance(column.dtype, pl.Datetime) else column
        return values_of(spans.dt.total_nanoseconds().cast(pl.Float64) * 1e-9)
    return f"holds {column.dtype} where numbers are required: convert the column"


READERS = {".parquet": open_parquet, ".feather": open_feather, ".arrow": open_feather}
