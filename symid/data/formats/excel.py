"""Sheets of Excel and OpenDocument: the first one of a file that holds columns of numbers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import polars as pl

from symid.data.formats.extra import required
from symid.data.formats.parquet import numbers_of
from symid.data.layout import layout_of_text, lines_of
from symid.data.table import Table, damaged
from symid.errors import LogError

_MOST_ROWS = 300
"""Rows in which headers are looked for."""


def open_excel(path: Path, memory: int | None = None) -> Table:
    """Table in a sheet, with lines above the header and a line of units as in text files.

    LogError if it is damaged, no sheet holds columns of numbers, or fastexcel is not installed.
    """
    fastexcel = required("fastexcel", path)
    try:
        book = fastexcel.read_excel(path)
        for name in book.sheet_names:
            headers, skipped = _headers(
                path, book.load_sheet(name, header_row=None, skip_rows=0, dtypes="string")
            )
            if headers:
                return _table(headers, book.load_sheet(name, header_row=None, skip_rows=skipped).to_polars())
    except Exception as error:  # on a damaged file its parser raises any exception
        raise damaged(path, "Excel", error) from error
    raise LogError(f"{path}: no sheet holds columns of numbers below a line of names: export it as CSV")


def _headers(path: Path, sheet: Any) -> tuple[tuple[str, ...], int]:
    """Headers and the number of rows above the values, found in the cells as text; empty without values."""
    text = "\n".join(map(_line, sheet.to_polars().head(_MOST_ROWS).iter_rows())).encode("utf-8")
    try:
        layout = layout_of_text(path, text)
    except LogError:
        return (), 0
    return layout.headers(lines_of(path, text, layout.encoding)), layout.skipped


def _table(headers: tuple[str, ...], values: pl.DataFrame) -> Table:
    columns = values.get_columns()[: len(headers)]
    return Table(
        headers[: len(columns)], lambda positions: [numbers_of(columns[place]) for place in positions]
    )


def _line(cells: tuple[Any, ...]) -> str:
    texts = ["" if cell is None else str(cell) for cell in cells]
    return "\t".join(text.replace("\t", " ").replace("\n", " ").replace('"', "'") for text in texts)
