"""HDF5 files, those of MATLAB 7.3 among them: each vector is a column, read when it is asked for."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from symid.arrays import FloatArray
from symid.data.formats.channels import short_names, vector
from symid.data.formats.extra import required
from symid.data.memory import require_room
from symid.data.table import Table, damaged
from symid.errors import LogError

MAGIC: Final = b"\x89HDF\r\n\x1a\n"
"""Signature of HDF5 files, after an optional user block."""
_UNITS: Final = ("unit", "units", "Unit", "Units")
_MOST_COLUMNS: Final = 32


def open_hdf5(path: Path, memory: int | None = None) -> Table:
    """Table in an HDF5 file: its vectors of numbers in all groups, and the columns of its long, narrow arrays.

    An attribute ``unit`` or ``units`` of a vector is its unit. LogError if it is damaged, or h5py is not installed.
    """
    h5py = required("h5py", path)
    try:
        with h5py.File(path, "r") as file:
            found = _vectors(file, h5py)
    except Exception as error:  # a damaged file raises various exceptions
        raise damaged(path, "HDF5", error) from error
    names = short_names([(*one.path, *one.column_name) for one in found])
    headers = tuple(
        f"{name} [{one.unit}]" if one.unit else name for name, one in zip(names, found, strict=True)
    )

    def read(positions: Sequence[int]) -> list[FloatArray | str]:
        try:
            with h5py.File(path, "r") as file:
                return [found[position].read(file) for position in positions]
        except LogError:
            raise
        except Exception as error:
            raise damaged(path, "HDF5", error) from error

    return Table(headers, read, n_rows=max((one.size for one in found), default=0))


class _Column:
    """A vector of a file, or a column of an array or of a compound."""

    def __init__(
        self, path: tuple[str, ...], unit: str, size: int, place: int | str | None, rows_first: bool
    ) -> None:
        self.path, self.unit, self.size, self.place, self.rows_first = path, unit, size, place, rows_first

    @property
    def column_name(self) -> tuple[str, ...]:
        """Name within its array."""
        if self.place is None:
            return ()
        return (str(self.place + 1),) if isinstance(self.place, int) else (self.place,)

    def read(self, file: Any) -> FloatArray | str:
        """Values of the vector or column."""
        require_room(self.size)
        dataset = file["/".join(self.path)]
        if self.place is None or isinstance(self.place, str):
            return vector(np.asarray(dataset[()] if self.place is None else dataset[self.place]))
        return vector(np.asarray(dataset[:, self.place] if self.rows_first else dataset[self.place, :]))


def _vectors(file: Any, h5py: Any) -> list[_Column]:
    found: list[_Column] = []

    def visit(name: str, item: Any) -> None:
        if not isinstance(item, h5py.Dataset) or name.startswith("#") or item.size is None or item.size <= 1:
            return
        path, unit = tuple(name.split("/")), _unit(item)
        if item.dtype.names:
            numbers = [field for field in item.dtype.names if item.dtype[field].kind in "biuf"]
            found.extend(_Column(path, "", item.size, field, True) for field in numbers if item.ndim == 1)
        elif item.dtype.kind in "biuf" and item.attrs.get("MATLAB_class", b"") not in (b"char", b"cell"):
            found.extend(_columns(path, unit, item))

    file.visititems(visit)
    return found


def _columns(path: tuple[str, ...], unit: str, item: Any) -> list[_Column]:
    """A vector, or the columns of a long and narrow array."""
    shape = item.shape
    if len(shape) != 2 or min(shape) == 1:
        return [_Column(path, unit, item.size, None, True)]
    long, narrow = max(shape), min(shape)
    if narrow > _MOST_COLUMNS or long < 2 * narrow:
        return [_Column(path, unit, item.size, None, True)]
    return [_Column(path, unit, long, j, shape[0] == long) for j in range(narrow)]


def _unit(item: Any) -> str:
    try:
        given = next((item.attrs[name] for name in _UNITS if name in item.attrs), "")
    except (OSError, TypeError):  # an attribute of a kind that h5py does not read
        return ""
    return (
        given.decode("utf-8", "replace")
        if isinstance(given, bytes)
        else str(given)
        if isinstance(given, str)
        else ""
    )
