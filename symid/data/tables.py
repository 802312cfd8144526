"""Files as tables of named columns, whatever their format.

Of CSV, Parquet, Feather and HDF5 files only the headers and the columns asked for are read. What is wrong with
a file as a whole raises; what is wrong with one column is returned in its place, as a sentence, so that a caller can
report the faults of all columns together.
"""

from __future__ import annotations

from pathlib import Path

from symid.data.csv_table import open_laid_out
from symid.data.formats import SUFFIXES, open_format, suffix_of
from symid.data.formats.gzipped import open_gzipped
from symid.data.formats.scope_text import writer_of
from symid.data.layout import Layout
from symid.data.table import Table, first_line, said_of
from symid.errors import LogError
from symid.files import require_regular

_MOST_USED = 3


def open_table(path: Path, layout: Layout | None = None, memory: int | None = None) -> Table:
    """Table in a file, by its suffix; a CSV file by its layout if one is given, whatever its suffix.

    Parameters
    ----------
    path : Path
        The file.
    layout : Layout, optional
        Of a CSV file, compressed or not.
    memory : int, optional
        Bytes that what is read at once may take, such as a MATLAB file; those that are free by default.

    Raises
    ------
    LogError
        If the file does not exist, is of another kind, empty, or damaged.
    """
    if path.is_dir():
        raise LogError(f"{path}: is a directory: give a {_suffixes()}")
    require_regular(path, LogError)
    suffix = suffix_of(path)
    if suffix in (".txt", ".tsv") and layout is None and writer_of(path) is not None:
        suffix = ".csv"
    if suffix == ".zip":
        raise LogError(f"{path}: is an archive: unpack it, and give the files in it")
    if suffix not in SUFFIXES and layout is None:
        raise LogError(f"{path}: suffix {path.suffix!r} is not known: give a {_suffixes()}")
    try:
        if path.stat().st_size == 0:
            raise LogError(f"{path}: is empty: give a file with a header and samples")
        if layout is not None and suffix == ".csv.gz":
            return open_gzipped(path, memory, layout)
        if layout is not None and (suffix == ".csv" or suffix not in SUFFIXES):
            return open_laid_out(path, layout)
        with said_of(path):
            return open_format(path, suffix, memory)
    except OSError as error:
        raise LogError(f"{path}: cannot be read ({first_line(error)}): check the file") from error


def _suffixes() -> str:
    most, others = SUFFIXES[:_MOST_USED], ", ".join(SUFFIXES[_MOST_USED:])
    return f"{', '.join(most[:-1])} or {most[-1]} file, or {others}"
