"""Columns of formats that hold arrays by name, or channels that each have a clock."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from symid.arrays import FloatArray
from symid.data.columns import TIME
from symid.data.table import Table

_NUMBERS, _MOST_COLUMNS = "biufc", 32  # kinds of NumPy; signals in the columns of one array
_VALUES, _NAMES = ("values", "Data", "data", "signal"), ("label", "Name", "name")
UNIT_FIELDS = ("unit", "units", "Unit", "Units")
"""Names of the fields that programs write for the samples of a signal, for its name and for its unit."""


@dataclass(frozen=True, eq=False)
class Channel:
    """A signal of a file that keeps the times of each signal, s; empty times where the file does not give them.

    Name and unit are as written in the file; the unit may be empty.
    """

    name: str
    unit: str
    time: FloatArray
    values: npt.NDArray[Any]

    @property
    def header(self) -> str:
        """Header of the column: name and unit."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name


def described(record: Mapping[str, Any], names: tuple[str, ...]) -> tuple[str, tuple[str, ...], str] | None:
    """Field of the samples in a record of one signal, the names of the signal, and its unit; None of other records.

    `names` are those that lead to the record.

    >>> described({"unit": "mm", "values": [0, 1]}, ("run", "position"))
    ('values', ('run', 'position'), 'mm')
    >>> described({"position": [0, 1]}, ("run",))
    """
    name, unit = (field_text(record, fields) for fields in (_NAMES, UNIT_FIELDS))
    field = next((field for field in _VALUES if field in record), None)
    path = (*names, name) if name else names
    return (field, path, unit) if field and path and (name or unit) else None


def field_text(record: Mapping[str, Any], fields: Sequence[str]) -> str:
    """Text of the first of these fields that a record has; empty without one."""
    return next((str(record[f]) for f in fields if isinstance(record.get(f), str) and record[f]), "")


def vector(array: npt.NDArray[Any]) -> FloatArray | str:
    """An array as a column of numbers, moments as seconds from the first, or a sentence on what it holds.

    >>> vector(np.array([[1, 2, 3]])).tolist(), vector(np.eye(2))[:24]
    ([1.0, 2.0, 3.0], 'is an array of 2 x 2 whe')
    """
    if array.size == 0:
        return "is empty: save it with samples"
    if np.iscomplexobj(array):
        return "is complex where real numbers are required: save its real part"
    if array.size != max(array.shape):
        shape = " x ".join(str(size) for size in array.shape)
        return f"is an array of {shape} where a vector is required: save each signal on its own"
    flat = array.ravel()
    if flat.dtype.kind in "mM":
        return np.asarray((flat - flat[0]) / np.timedelta64(1, "s"), dtype=np.float64)
    return flat.astype(np.float64)


def table_of_arrays(arrays: Mapping[str, npt.NDArray[Any]]) -> Table:
    """Arrays of numbers by name as a table; single values and texts are left out, a matrix is its columns.

    >>> table_of_arrays({"t": np.arange(9), "data": np.zeros((9, 2)), "gain": np.array(2.0)}).headers
    ('t', 'data(:,1)', 'data(:,2)')
    """
    columns: dict[str, npt.NDArray[Any]] = {}
    fields = {
        (name, *((field,) if field else ())): array[field] if field else array
        for name, array in arrays.items()
        for field in array.dtype.names or ("",)
    }
    for name, array in zip(short_names(list(fields)), fields.values(), strict=True):
        columns.update(columns_of(name, array))
    headers = tuple(columns)
    return Table(headers, lambda positions: [vector(columns[headers[position]]) for position in positions])


def columns_of(name: str, array: npt.NDArray[Any]) -> Iterator[tuple[str, npt.NDArray[Any]]]:
    """Columns of an array of numbers by name; none of texts and single values."""
    if array.dtype.kind not in _NUMBERS + "mM" or array.size == 1:
        return
    if not are_columns(array.shape):
        yield name, array
        return
    rows = array if array.shape[0] > array.shape[1] else array.T
    for j in range(rows.shape[1]):
        yield f"{name}(:,{j + 1})", rows[:, j]


def table_of_channels(channels: Sequence[Channel]) -> Table:
    """Channels as a table; those that share their times share a column of them.

    The first column of times is called ``t`` if no channel is, others are named after the first channel that they
    belong to.
    """
    taken = any(channel.name == TIME for channel in channels)
    times: list[tuple[str, FloatArray]] = []
    headers: list[str] = []
    columns: list[npt.NDArray[Any]] = []
    clock_of: dict[int, str] = {}
    for channel in channels:
        clock_of[len(columns)] = _clock_of(channel, times, taken)
        headers.append(channel.header)
        columns.append(channel.values)
    places = {name: len(columns) + i for i, (name, _) in enumerate(times)}
    clocks = {position: places[name] for position, name in clock_of.items() if name}
    columns += [time for _, time in times]
    return Table(
        (*headers, *places),
        lambda positions: [vector(columns[position]) for position in positions],
        n_rows=max((column.size for column in columns), default=0),
        clocks=clocks,
    )


def short_names(paths: Sequence[tuple[str, ...]]) -> list[str]:
    """The last parts of paths where they differ, and whole paths with points where they do not.

    >>> short_names([("run", "t"), ("a", "q"), ("b", "q")])
    ['t', 'a.q', 'b.q']
    """
    count = Counter(path[-1] for path in paths)
    return [path[-1] if count[path[-1]] == 1 else ".".join(path) for path in paths]


def are_columns(shape: Sequence[int]) -> bool:
    """Whether an array of this shape, long and narrow, holds a signal in each column."""
    return len(shape) == 2 and 1 < min(shape) <= _MOST_COLUMNS and max(shape) >= 2 * min(shape)


def _clock_of(channel: Channel, times: list[tuple[str, FloatArray]], taken: bool) -> str:
    """Name of the column of a channel's times, which is added if there is none like it."""
    if not channel.time.size:
        return ""
    for name, time in times:
        if time is channel.time or np.array_equal(time, channel.time):
            return name
    times.append((f"t of {channel.name}" if times or taken else TIME, channel.time))
    return times[-1][0]
