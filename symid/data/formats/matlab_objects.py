"""Objects in MATLAB files: time series, the datasets of Simulink that hold them, tables and timetables."""

import warnings
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from symid.arrays import FloatArray
from symid.data.formats.channels import Channel
from symid.data.formats.extra import required

_SECONDS: Final[Mapping[str, float]] = {
    "nanoseconds": 1e-9,
    "microseconds": 1e-6,
    "milliseconds": 1e-3,
    "seconds": 1.0,
    "minutes": 60.0,
    "hours": 3600.0,
    "days": 86400.0,
    "weeks": 604800.0,
}
"""Seconds in each unit that the time of a time series may have."""
_UNNAMED: Final = "unnamed"
_DEEPEST: Final = 12  # levels of nested structs


def may_hold_objects(begin: bytes) -> bool:
    r"""Whether the header of a MATLAB file before version 7.3 points to the data of objects.

    >>> may_hold_objects(b"MATLAB 5.0 MAT-file".ljust(128, b"\0"))
    False
    """
    return begin[:10] == b"MATLAB 5.0" and begin[116:124].strip(b" \0") != b""


def with_objects(path: Path) -> dict[str, object]:
    """Variables of a MATLAB file of any version: structs and objects as mappings, cells as lists.

    A time series, or a column of a timetable, is a `Channel`. LogError if mat-io is not installed.
    """
    library = required("matio", path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        variables = library.load_from_mat(str(path))
    return {name: _plain(value) for name, value in variables.items() if not name.startswith("__")}


def _plain(value: Any, depth: int = 0) -> object:
    if depth > _DEEPEST:
        return None
    if hasattr(value, "properties") and isinstance(value.properties, Mapping):
        return _object({str(name): _plain(inner, depth + 1) for name, inner in value.properties.items()})
    if hasattr(value, "columns") and hasattr(value, "index"):
        return _frame(value)
    if not isinstance(value, np.ndarray):
        return value
    if value.dtype.names:
        structs = [
            _named({name: _plain(item[name], depth + 1) for name in value.dtype.names})
            for item in value.ravel()
        ]
        return structs[0] if len(structs) == 1 else structs
    if value.dtype == object:
        cells = [_plain(item, depth + 1) for item in value.ravel()]
        return cells[0] if len(cells) == 1 else cells
    if value.dtype.kind == "U":
        return str(value.ravel()[0]) if value.size == 1 else ""
    return np.asarray(value)


def _object(properties: dict[str, object]) -> object:
    """A time series as a channel; any other object as its properties."""
    # what is stored of a property has its name, with an underscore behind it
    fields = {name.rstrip("_").lower(): value for name, value in properties.items()}
    data = fields.get("data")
    if not isinstance(data, np.ndarray) or "timeinfo" not in fields:
        return _named(properties)
    time = _times(fields)
    name = fields.get("name")
    name = name if isinstance(name, str) and name != _UNNAMED else ""
    return Channel(name, _unit(fields.get("datainfo")), time, _rows(data, time.size))


def _times(series: Mapping[str, object]) -> FloatArray:
    """Times of a time series, s: stored, or uniform by start, increment and length."""
    info = series["timeinfo"]
    about = {name.rstrip("_").lower(): v for name, v in info.items()} if isinstance(info, Mapping) else {}
    factor = _SECONDS.get(str(about.get("units", "seconds")), 1.0)
    for stored in (series.get("time"), about.get("time")):
        if isinstance(stored, np.ndarray) and stored.size and stored.dtype.kind in "biuf":
            return factor * np.asarray(stored, np.float64).ravel()
    start, step, length = (_number(about.get(name)) for name in ("start", "increment", "length"))
    if step is None or length is None or not np.isfinite([step, length]).all():
        return np.zeros(0)
    data = series["data"]
    samples = data.size if isinstance(data, np.ndarray) else 0
    places = np.arange(min(max(int(length), 0), samples), dtype=np.float64)
    return factor * ((start or 0.0) + step * places)


def _rows(data: np.ndarray[Any, Any], samples: int) -> np.ndarray[Any, Any]:
    """Samples of a time series in rows; Simulink stores those of a vector along the last axis."""
    whole = np.squeeze(data)
    return whole.T if whole.ndim == 2 and whole.shape[0] != samples == whole.shape[1] else whole


def _unit(info: object) -> str:
    """Unit of the data of a time series, a text or an object with a name."""
    unit = info.get("Units", info.get("Units_")) if isinstance(info, Mapping) else None
    unit = unit.get("Name", "") if isinstance(unit, Mapping) else unit
    return unit if isinstance(unit, str) else ""


def _number(value: object) -> float | None:
    if isinstance(value, np.ndarray) and value.size == 1 and value.dtype.kind in "biuf":
        return float(value.ravel()[0])
    return None


def _named(fields: dict[str, object]) -> dict[str, object]:
    """Fields; a time series without a name gets the name of its owner, such as a logged signal."""
    own_name = fields.get("Name", fields.get("Name_"))
    if not isinstance(own_name, str) or not own_name:
        return fields
    return {
        key: replace(value, name=own_name) if isinstance(value, Channel) and not value.name else value
        for key, value in fields.items()
    }


def _frame(frame: Any) -> dict[str, object]:
    """Columns of a table; those of a timetable with its times."""
    columns = {str(name): np.asarray(frame[name]) for name in frame.columns}
    index = np.asarray(frame.index)
    if index.dtype.kind not in "mM" or not index.size:
        return dict(columns)
    time = np.asarray((index - index[0]) / np.timedelta64(1, "s"), np.float64)
    return {name: Channel(name, "", time, values) for name, values in columns.items()}
