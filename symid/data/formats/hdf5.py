"""HDF5 files, those of MATLAB 7.3 among them: each vector is a column, read when it is asked for."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from symid.arrays import FloatArray
from symid.data.formats.channels import UNIT_FIELDS, are_columns, short_names, vector
from symid.data.formats.extra import required
from symid.data.table import Table, parsing, require_memory

MAGIC: Final = b"\x89HDF\r\n\x1a\n"
"""Signature of HDF5 files, after an optional user block."""
_TITLES: Final = ("columns", "names", "labels", "channels", "column_names")
"""Attributes that name the columns of an array."""


def open_hdf5(path: Path, memory: int | None = None) -> Table:
    """Table in an HDF5 file: its vectors of numbers in all groups, and the columns of its long, narrow arrays.

    An attribute ``unit`` or ``units`` of a vector is its unit. LogError if it is damaged, or h5py is not installed.
    """
    h5py = required("h5py", path)
    with parsing(path, "HDF5"), h5py.File(path, "r") as file:
        vectors = _vectors(file, h5py)
    names = short_names([each.names for each in vectors])
    units = (f" [{each.unit}]" if each.unit else "" for each in vectors)
    headers = tuple(name + unit for name, unit in zip(names, units, strict=True))

    def read(positions: Sequence[int]) -> list[FloatArray | str]:
        with parsing(path, "HDF5"), h5py.File(path, "r") as file:
            return [vectors[position].read(file) for position in positions]

    return Table(headers, read, n_rows=max((each.size for each in vectors), default=0))


def values_behind_references(path: Path) -> int:
    """Number of all values in a MATLAB 7.3 file with cells, arrays of structs or objects; 0 if it has none."""
    h5py, sizes = required("h5py", path), [0]

    def visit(_: str, item: Any) -> None:
        sizes.append(int(item.size or 0) if isinstance(item, h5py.Dataset) else 0)

    with parsing(path, "HDF5"), h5py.File(path, "r") as file:
        if "#refs#" in file or "#subsystem#" in file:
            file.visititems(visit)
    return sum(sizes)


@dataclass(frozen=True)
class _Vector:
    """A vector of a file, or a column of an array (by its number) or of a compound (by its name)."""

    path: tuple[str, ...]
    unit: str
    size: int
    place: int | str | None = None
    rows_first: bool = True
    title: str = ""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of groups, array and column; a column of an array without names is ``data(:,1)``."""
        if isinstance(self.place, int) and not self.title:
            return (*self.path[:-1], f"{self.path[-1]}(:,{self.place + 1})")
        return (*self.path, self.title) if self.title else self.path

    def read(self, file: Any) -> FloatArray | str:
        """Values of the vector or column."""
        require_memory(self.size)
        dataset = file["/".join(self.path)]
        if self.place is None or isinstance(self.place, str):
            return vector(np.asarray(dataset[()] if self.place is None else dataset[self.place]))
        return vector(np.asarray(dataset[:, self.place] if self.rows_first else dataset[self.place, :]))


def _vectors(file: Any, h5py: Any) -> list[_Vector]:
    vectors: list[_Vector] = []

    def visit(name: str, item: Any) -> None:
        if not isinstance(item, h5py.Dataset) or name.startswith("#") or item.size is None or item.size <= 1:
            return
        if "MATLAB_object_decode" in item.attrs:  # refers to an object
            return
        path, units = tuple(name.split("/")), _texts(item, UNIT_FIELDS)
        unit = units[0] if len(units) == 1 else ""
        if item.dtype.names:
            numbers = [field for field in item.dtype.names if item.dtype[field].kind in "biuf"]
            vectors.extend(
                _Vector(path, "", item.size, field, title=field) for field in numbers if item.ndim == 1
            )
        elif item.dtype.kind in "biuf" and item.attrs.get("MATLAB_class", b"") not in (b"char", b"cell"):
            long, narrow = max(item.shape), min(item.shape)
            if are_columns(item.shape):
                titles = _texts(item, _TITLES) or _items_of_pandas(file, name)
                for j in range(narrow):
                    column_unit = units[j] if len(units) == narrow else unit
                    title = titles[j] if len(titles) == narrow else ""
                    vectors.append(_Vector(path, column_unit, long, j, item.shape[0] == long, title))
            else:
                vectors.append(_Vector(path, unit, item.size))

    file.visititems(visit)
    return vectors


def _texts(item: Any, attributes: Sequence[str]) -> list[str]:
    """Texts of the first of these attributes that a dataset has."""
    try:
        given = next((item.attrs[name] for name in attributes if name in item.attrs), ())
    except (OSError, TypeError):  # an attribute of a kind that h5py does not read
        return []
    return _as_texts(given)


def _items_of_pandas(file: Any, name: str) -> list[str]:
    """Names of the columns of an array that pandas wrote, which stand in an array beside it."""
    beside = f"{name.removesuffix('_values')}_items"
    items = file[beside] if name.endswith("_values") and beside in file else None
    return _as_texts(items[()]) if items is not None and getattr(items, "ndim", 0) == 1 else []


def _as_texts(given: Any) -> list[str]:
    values = np.ravel(np.asarray(given, dtype=object)).tolist()
    texts = [value.decode("utf-8", "replace") if isinstance(value, bytes) else value for value in values]
    return texts if all(isinstance(text, str) for text in texts) else []


READERS = {".h5": open_hdf5, ".hdf5": open_hdf5}
