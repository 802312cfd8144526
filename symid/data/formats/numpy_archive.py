"""NPZ archives of NumPy as tables."""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path

import numpy as np

from symid.data.formats.channels import table_of_arrays
from symid.data.memory import require_room
from symid.data.table import Table, parsing


def open_npz(path: Path, memory: int | None = None) -> Table:
    """Table in an NPZ file; objects in it are not loaded, they could run code.

    LogError if it is damaged, or holds objects.
    """
    failures = (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error, NotImplementedError)
    with parsing(path, "NPZ", *failures):
        with zipfile.ZipFile(path) as archive:
            require_room(sum(entry.file_size for entry in archive.infolist()) // 8, memory)
        with np.load(path, allow_pickle=False) as arrays:
            return table_of_arrays({name: arrays[name] for name in arrays.files})
