"""CSV files that are compressed by gzip."""

from __future__ import annotations

import gzip
import zlib
from pathlib import Path

from symid.data.csv_table import open_text
from symid.data.layout import Layout
from symid.data.memory import free_memory
from symid.data.table import Table, damaged
from symid.errors import LogError

_TIMES_TEXT = 4
"""Memory of columns and text of a file together, in multiples of its text."""


def open_gzipped(path: Path, memory: int | None = None, layout: Layout | None = None) -> Table:
    """Table in a compressed CSV file, of a layout that is given or guessed.

    LogError if it is damaged, or longer than the memory.
    """
    most = (free_memory() if memory is None else memory) / _TIMES_TEXT
    try:
        with gzip.open(path) as file:
            text = file.read(int(min(most, 2**62)) + 1)
    except (OSError, EOFError, zlib.error) as error:
        raise damaged(path, "gzip", error) from error
    if len(text) > most:
        raise LogError(f"{path}: holds more than {most / 1e6:.3g} MB of text: uncompress it")
    return open_text(path, text, layout)
