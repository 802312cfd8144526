"""Feather files (Arrow IPC)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import polars as pl

from symid.arrays import FloatArray
from symid.data.formats.parquet import numbers_of
from symid.data.table import POLARS_FAILURES, Table, damaged, source_of


def open_feather(path: Path, memory: int | None = None) -> Table:
    """Table in a Feather file; LogError if it is damaged."""
    try:
        scanned = pl.scan_ipc(source_of(path))
        headers = tuple(scanned.collect_schema().names())
        n_rows = int(scanned.select(pl.len()).collect().item())
    except POLARS_FAILURES as error:
        raise damaged(path, "Feather", error) from error

    def read(positions: Sequence[int]) -> list[FloatArray | str]:
        names = [headers[position] for position in positions]
        try:
            frame = pl.scan_ipc(source_of(path)).select(sorted(set(names))).collect()
        except POLARS_FAILURES as error:
            raise damaged(path, "Feather", error) from error
        return [numbers_of(frame[name]) for name in names]

    return Table(headers, read, n_rows=n_rows)
