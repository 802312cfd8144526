"""Sheets of Excel and OpenDocument: the first one of a file that holds columns of numbers."""

from pathlib import Path

import polars as pl

from symid.data.formats.columnar import numbers_of
from symid.data.formats.extra import required
from symid.data.table import Table, parsing
from symid.data.text_files.layout import layout_of_text, lines_of
from symid.errors import LogError

_MOST_ROWS = 300
"""Rows in which headers are looked for."""


def open_excel(path: Path, memory: int | None = None) -> Table:
    """Table in a sheet, with lines above the header and a line of units as in text files.

    LogError if it is damaged, no sheet holds columns of numbers, or fastexcel is not installed.
    """
    fastexcel = required("fastexcel", path)
    with parsing(path, "Excel"):
        book = fastexcel.read_excel(path)
        for name in book.sheet_names:
            texts = book.load_sheet(name, header_row=None, skip_rows=0, dtypes="string").to_polars()
            headers, skipped = _headers(path, texts.head(_MOST_ROWS))
            if headers:
                return _table(headers, book.load_sheet(name, header_row=None, skip_rows=skipped).to_polars())
    raise LogError(f"{path}: no sheet holds columns of numbers below a line of names: export it as CSV")


def _table(headers: tuple[str, ...], values: pl.DataFrame) -> Table:
    columns = values.get_columns()[: len(headers)]
    return Table(headers[: len(columns)], lambda places: [numbers_of(columns[place]) for place in places])


def _headers(path: Path, cells: pl.DataFrame) -> tuple[tuple[str, ...], int]:
    """Headers and the number of rows above the values, found in the cells as text; empty without values."""
    separable = str.maketrans({"\t": " ", "\n": " ", '"': "'"})
    rows = ["\t".join(str(cell or "").translate(separable) for cell in row) for row in cells.iter_rows()]
    text = "\n".join(rows).encode("utf-8")
    try:
        layout = layout_of_text(path, text)
    except LogError:
        return (), 0
    return layout.headers(lines_of(path, text, layout.encoding)), layout.skipped


READERS = dict.fromkeys((".xlsx", ".xls", ".ods"), open_excel)
