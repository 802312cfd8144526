"""Tables as CSV and Parquet files, written as a whole or not at all."""

import errno
import os
from collections.abc import Mapping
from pathlib import Path

import polars as pl

from symid.data.log import Log
from symid.data.table import first_line
from symid.files import replacing, written_path

WRITTEN_SUFFIXES = (".csv", ".parquet")
"""Kinds of tables that are written."""


def write_frame(frame: pl.DataFrame, file: Path, metadata: Mapping[str, str] | None = None) -> None:
    """Write a table as a .parquet file, else as CSV.

    Parameters
    ----------
    frame : polars.DataFrame
        The table.
    file : Path
        Its suffix chooses the format.
    metadata : mapping of str to str, optional
        Key-value metadata of a Parquet file.

    Raises
    ------
    OSError
        If it cannot be written, as on a full disk; an earlier file then stays unchanged.
    """
    with replacing(file) as unfinished:
        try:
            if file.suffix.lower() == ".parquet":
                frame.write_parquet(unfinished, metadata=dict(metadata) if metadata else None)
            else:
                frame.write_csv(unfinished)
        except (pl.exceptions.PolarsError, OSError) as error:  # polars names no file
            known = (errno.ENOSPC, errno.EDQUOT, errno.EACCES)
            number = next((n for n in known if os.strerror(n) in str(error)), errno.EIO)
            raise OSError(number, first_line(error), str(file)) from error


def write_log(log: Log, file: str | os.PathLike[str]) -> None:
    """Write a log, SI, with its time as the first column.

    Parameters
    ----------
    log : Log
        The log.
    file : path-like
        Ends with .csv or .parquet.

    Raises
    ------
    SettingError
        If the suffix is neither of these.
    OSError
        If it cannot be written.
    """
    write_frame(log.to_frame(), written_path("log", file, *WRITTEN_SUFFIXES))
