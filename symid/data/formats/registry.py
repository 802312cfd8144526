"""Readers of files by suffix."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Final, TypeAlias

from symid.data.csv_table import open_csv
from symid.data.formats.excel import open_excel
from symid.data.formats.feather import open_feather
from symid.data.formats.gzipped import open_gzipped
from symid.data.formats.hdf5 import open_hdf5
from symid.data.formats.json_log import open_json, open_json_lines
from symid.data.formats.matlab import open_matlab
from symid.data.formats.mcap import open_mcap
from symid.data.formats.mdf import open_mdf
from symid.data.formats.numpy_archive import open_npz
from symid.data.formats.parquet import open_parquet
from symid.data.formats.rosbag import open_rosbag
from symid.data.formats.scope_text import open_scope_text, writer_of
from symid.data.formats.tdms import open_tdms
from symid.data.table import Table

Reader: TypeAlias = "Callable[[Path, int | None], Table]"
"""Function of the file and the memory in bytes that it may use (free memory if None)."""


def open_text_file(path: Path) -> Table:
    """Table in a CSV file, or in the text of a scope."""
    scope = writer_of(path)
    return open_scope_text(path, *scope) if scope else open_csv(path)


READERS: Final[Mapping[str, Reader]] = MappingProxyType(
    {
        ".csv": lambda path, _: open_text_file(path),
        ".parquet": lambda path, _: open_parquet(path),
        ".mat": open_matlab,
        ".csv.gz": open_gzipped,
        ".feather": open_feather,
        ".arrow": open_feather,
        ".h5": open_hdf5,
        ".hdf5": open_hdf5,
        ".tdms": open_tdms,
        ".mf4": open_mdf,
        ".mdf": open_mdf,
        ".mcap": open_mcap,
        ".db3": open_rosbag,
        ".bag": open_rosbag,
        ".xlsx": open_excel,
        ".xls": open_excel,
        ".ods": open_excel,
        ".npz": open_npz,
        ".json": open_json,
        ".jsonl": open_json_lines,
        ".ndjson": open_json_lines,
    }
)
"""Readers by suffix; a new format is a module and a line here."""

SUFFIXES: Final = tuple(READERS)
"""Suffixes of files that can be read."""
FOLDER_SUFFIXES: Final = tuple(
    suffix for suffix in SUFFIXES if suffix not in (".json", ".npz", ".xls", ".ods")
)
"""Suffixes that count as logs in a folder; other files often hold results and settings."""


def suffix_of(path: Path) -> str:
    """Suffix of a file by which its reader is found, in small letters.

    Examples
    --------
    >>> suffix_of(Path("a.b/Run.CSV.GZ")), suffix_of(Path("run.2.mat"))
    ('.csv.gz', '.mat')
    """
    name = path.name.lower()
    return ".csv.gz" if name.endswith(".csv.gz") else Path(name).suffix


def open_format(path: Path, suffix: str, memory: int | None = None) -> Table:
    """Table in a file of a kind that is read.

    Parameters
    ----------
    path : Path
        The file.
    suffix : str
        One of `SUFFIXES`, by which its reader is found.
    memory : int, optional
        Memory that reading may use, bytes; free memory by default.

    Raises
    ------
    LogError
        If the file is damaged, holds no columns, or needs a library that is not installed.
    """
    return READERS[suffix](path, memory)
