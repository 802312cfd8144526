"""Arrays by name: MATLAB files with structs of Simulink and dSPACE, version 7.3 as the HDF5 file that it is; NPZ."""

from __future__ import annotations

import math
import zipfile
import zlib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy

from symid.data.formats.channels import short_names, table_of_arrays
from symid.data.formats.hdf5 import MAGIC, open_hdf5
from symid.data.memory import require_room
from symid.data.table import Table, parsing
from symid.errors import LogError

_VALUES, _NAMES = ("values", "Data", "data", "signal"), ("label", "Name", "name")
"""Field names of Simulink and dSPACE for the samples of a signal and for its name."""
_DEEPEST = 12


def open_matlab(path: Path, memory: int | None = None) -> Table:
    """Table in a MATLAB file; LogError if it is damaged, or holds no numbers that can be read.

    Fields of structs are columns, named after the signal where the struct names one.
    """
    with path.open("rb") as file:
        begin = file.read(520)
    if b"MATLAB 7.3" in begin[:128] or MAGIC in begin:
        return open_hdf5(path, memory)
    with parsing(path, "MATLAB"):
        _require_room_for(path, memory)
        variables = scipy.io.loadmat(path, simplify_cells=True)
    public = {name: value for name, value in variables.items() if not name.startswith("__")}
    found = [(names, array) for names, array in _arrays(public) if array.size != 1]
    names = short_names([names for names, _ in found])
    table = table_of_arrays(dict(zip(names, [array for _, array in found], strict=True)))
    if not table.headers and any(type(value).__name__ == "MatlabOpaque" for value in public.values()):
        raise LogError(
            f"{path}: holds objects such as timeseries only, which MATLAB alone reads: "
            "save their Time and Data as vectors"
        )
    return table


def _arrays(value: object, names: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], npt.NDArray[Any]]]:
    """Arrays of numbers in nested structs, with the names that lead to them."""
    if len(names) > _DEEPEST:
        return
    if isinstance(value, Mapping):
        labels = (value[key] for key in _NAMES if isinstance(value.get(key), str) and value[key])
        own = next(labels, None)
        for key, inner in value.items():
            labelled = own is not None and key in _VALUES
            yield from _arrays(inner, (*names, str(own)) if labelled else (*names, str(key)))
    elif isinstance(value, np.ndarray) and value.dtype.kind in "biufc" and value.dtype.names is None:
        yield names, value
    elif isinstance(value, (list, np.ndarray)) and (isinstance(value, list) or value.dtype == object):
        items: Sequence[object] = list(np.ravel(np.array(value, dtype=object))) if len(value) else []
        for i, inner in enumerate(items):
            yield from _arrays(inner, (*names[:-1], f"{names[-1]}({i + 1})") if names else (str(i + 1),))


def _require_room_for(path: Path, memory: int | None) -> None:
    """Raise LogError if the arrays of a MATLAB file, which may be compressed, would not fit."""
    try:
        listed = scipy.io.whosmat(path)
    except Exception:  # noqa: BLE001  what cannot be listed, such as a tf model, may still be loaded
        return
    require_room(sum(math.prod(map(int, shape)) for _, shape, _ in listed), memory)


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
