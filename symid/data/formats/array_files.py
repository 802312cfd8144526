"""Arrays by name: MATLAB files with structs of Simulink and dSPACE, version 7.3 as HDF5; files of NumPy."""

import math
import struct
import warnings
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Final, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt
import scipy

from symid.data.formats.channels import (
    Channel,
    columns_of,
    described,
    short_names,
    table_of_arrays,
    table_of_channels,
)
from symid.data.formats.hdf5 import MAGIC, open_hdf5, values_behind_references
from symid.data.formats.matlab_objects import may_hold_objects, with_objects
from symid.data.formats.separate import answer, channels_apart
from symid.data.table import Table, first_line, fits_memory, parsing, require_memory
from symid.errors import LogError

_SIMULINK, _DSPACE = ("time", "signals"), ("X", "Y")
"""Fields of a recording of Simulink and of dSPACE: times, and signals."""
_DEEPEST = 12
_ADVICE = "save the Time and Data of a timeseries as vectors"
_NOTHING = f"holds no vectors of numbers: {_ADVICE}"
_Leaf: TypeAlias = "npt.NDArray[Any] | Channel"
_HEADER: Final = 128
_ORDERS: Final = {b"IM": "<", b"MI": ">"}
"""Mark of the byte order at the end of the header, as written by a machine of the other order."""
_COMPRESSED: Final = 15
"""Type of an element that is compressed."""
_READ_AT_ONCE: Final = 1 << 20
_DEFLATED: Final = 1032
"""Largest ratio of zlib's compression (https://zlib.net/zlib_tech.html)."""


def open_matlab(path: Path, memory: int | None = None) -> Table:
    """Table in a MATLAB file; LogError if it is damaged, or holds no numbers that can be read.

    Fields of structs are columns, named after the signal where the struct names one; time series keep their times.
    """
    with path.open("rb") as file:
        begin = file.read(520)
    if _is_hdf5(begin):
        # the plain vectors of such a file are read one by one; what stands in cells only with the whole file
        values = values_behind_references(path)
        if not values:
            return open_hdf5(path, memory)
        try:
            require_memory(values, memory)
            return table_of_channels(_channels_apart(path, memory))
        except LogError as error:
            return _vectors_alone(open_hdf5(path, memory), path, error)
    # only compressed elements have a checksum, and a wrong element can end the process of its parser
    if may_hold_objects(begin) or _COMPRESSED not in begin[128:132]:
        return table_of_channels(_channels_apart(path, memory))
    return table_of_channels(_channels(path, memory))


def _is_hdf5(begin: bytes) -> bool:
    return b"MATLAB 7.3" in begin[:128] or MAGIC in begin


def _channels_apart(path: Path, memory: int | None) -> list[Channel]:
    return channels_apart("symid.data.formats.array_files", path, memory, "MATLAB")


def _parsed(path: Path, memory: int | None) -> list[Channel]:
    """Channels of a file of any version, with those of its objects if they can be read."""
    with path.open("rb") as file:
        begin = file.read(520)
    is_hdf5 = _is_hdf5(begin)
    if not is_hdf5 and not may_hold_objects(begin):
        return _channels(path, memory)
    try:
        _require_memory_for(path, memory)
        channels = _as_channels(with_objects(path))
        if not channels:
            raise LogError(_NOTHING)
        return channels
    except Exception as error:  # noqa: BLE001  objects of an unknown kind; the vectors beside them are read
        return _vectors_alone([] if is_hdf5 else _channels(path, memory), path, error)


_Found = TypeVar("_Found", Table, list[Channel])


def _vectors_alone(vectors: _Found, path: Path, error: Exception) -> _Found:
    """Vectors of a file whose objects cannot be read; LogError if it has none."""
    if vectors if isinstance(vectors, list) else vectors.headers:
        return vectors
    if isinstance(error, LogError):
        raise LogError(f"{path}: {str(error).removeprefix(f'{path}: ')}") from error
    raise LogError(
        f"{path}: holds only objects that cannot be read ({first_line(error)}): {_ADVICE}"
    ) from error


def _channels(path: Path, memory: int | None) -> list[Channel]:
    """Variables of a file before version 7.3, without its objects."""
    with parsing(path, "MATLAB"), warnings.catch_warnings():
        warnings.simplefilter("ignore", scipy.io.matlab.MatReadWarning)  # two objects have one name to scipy
        _require_memory_for(path, memory)
        variables = scipy.io.loadmat(path, simplify_cells=True)
    return _as_channels({name: value for name, value in variables.items() if not name.startswith("__")})


def _as_channels(variables: Mapping[str, object]) -> list[Channel]:
    """Columns of all arrays of numbers, with times where a time series gives them."""
    paths, channels = [], []
    for names, leaf in _leaves(variables):
        channel = _channel(leaf)
        if channel.values.size == 1:
            continue
        paths.append((*names[:-1], channel.name) if channel.name else names)
        channels.append(channel)
    return [
        replace(channel, name=column, values=values)
        for name, channel in zip(short_names(paths), channels, strict=True)
        for column, values in columns_of(name, channel.values)
    ]


def _channel(leaf: _Leaf) -> Channel:
    return leaf if isinstance(leaf, Channel) else Channel("", "", np.zeros(0), leaf)


def _recording(value: Mapping[str, object], names: tuple[str, ...]) -> list[tuple[tuple[str, ...], Channel]]:
    """Signals of a recording with their times: Simulink's ``time``, or that of dSPACE's ``X`` which one refers to."""
    if all(field in value for field in _SIMULINK):
        times, signals = [value["time"]], _listed(value["signals"])
    elif all(field in value for field in _DSPACE):
        times = [
            source.get("Data") if isinstance(source, Mapping) else None for source in _listed(value["X"])
        ]
        signals = _listed(value["Y"])
    else:
        return []
    channels = []
    for i, signal in enumerate(signals):
        place = signal.get("XIndex", 1) if isinstance(signal, Mapping) else 1
        time = times[int(place) - 1] if np.size(place) == 1 and 0 < int(place) <= len(times) else None
        for path, leaf in _leaves(signal, (*names, f"signal {i + 1}")):
            channel = _channel(leaf)
            if not isinstance(time, np.ndarray) or time.size not in channel.values.shape:
                return []
            channels.append((path, replace(channel, time=np.ravel(time).astype(np.float64))))
    return channels


def _listed(value: object) -> list[object]:
    """Items of a list or of an array of structs; a struct alone is one."""
    if isinstance(value, Mapping):
        return [value]
    return list(np.ravel(np.array(value, dtype=object))) if isinstance(value, (list, np.ndarray)) else []


def _leaves(value: object, names: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], _Leaf]]:
    """Arrays of numbers and time series in nested structs, with the names that lead to them."""
    if len(names) > _DEEPEST or isinstance(value, scipy.io.matlab.MatlabFunction):
        return
    if isinstance(value, Channel):
        yield names, value
    elif isinstance(value, Mapping):
        description, clocked = described(value, names), _recording(value, names)
        yield from clocked
        for key, inner in value.items():
            if clocked and key in (*_SIMULINK, *_DSPACE):
                continue
            if description is None or key != description[0]:
                yield from _leaves(inner, (*names, str(key)))
            else:
                yield from (
                    (path, replace(_channel(leaf), unit=description[2]))
                    for path, leaf in _leaves(inner, description[1])
                )
    elif isinstance(value, np.ndarray) and value.dtype.kind in "biufc" and value.dtype.names is None:
        yield names, value
    elif isinstance(value, list) or (isinstance(value, np.ndarray) and value.dtype == object):
        for i, inner in enumerate(_listed(value)):
            yield from _leaves(inner, (*names[:-1], f"{names[-1]}({i + 1})") if names else (str(i + 1),))


def _require_memory_for(path: Path, memory: int | None) -> None:
    """Raise LogError if the variables of a MATLAB file, which may be compressed, would not fit."""
    try:
        listed = scipy.io.whosmat(path)
    except Exception:  # noqa: BLE001  what cannot be listed, such as a tf model, may still be loaded
        listed = []
    require_memory(sum(math.prod(map(int, shape)) for _, shape, _ in listed), memory)
    if not fits_memory(_DEFLATED * path.stat().st_size // 8, memory):
        for n_bytes in unpacked_sizes(path):  # fields of structs and cells are not listed
            require_memory(n_bytes // 8, memory)


def open_numpy(path: Path, memory: int | None = None) -> Table:
    """Table in an NPZ or NPY file; objects in it are not loaded, they could run code.

    LogError if it is damaged, or holds objects.
    """
    failures = (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error, NotImplementedError)
    with parsing(path, path.suffix[1:].upper(), *failures):
        if path.suffix.lower() == ".npy":
            require_memory(path.stat().st_size // 8, memory)
            return table_of_arrays({"data": np.load(path, allow_pickle=False)})
        with zipfile.ZipFile(path) as archive:
            require_memory(sum(entry.file_size for entry in archive.infolist()) // 8, memory)
        with np.load(path, allow_pickle=False) as arrays:
            return table_of_arrays(_without_objects(arrays))


def _without_objects(arrays: Mapping[str, npt.NDArray[Any]]) -> dict[str, npt.NDArray[Any]]:
    """Arrays of an NPZ file that hold no objects; ValueError if all do, or one is damaged."""
    variables, refused = {}, None
    for name in arrays:
        try:
            variables[name] = arrays[name]
        except ValueError as error:
            if "pickle" not in str(error):
                raise
            refused = error
    if refused and not variables:
        raise refused
    return variables


def unpacked_sizes(path: Path) -> Iterator[int]:
    """Bytes that the compressed variables of a MATLAB file take: a growing sum, first as stated, then as counted.

    A file of version 5 to 7 is a header of 128 bytes and elements: type and size in 4 bytes each, then the data. A
    compressed element holds one other element (MathWorks, MAT-File Format, "Level 5 MAT-File Format"). Little of a file
    can become much memory, and the size that the inner element states need not be true.
    """
    with path.open("rb") as file:
        order = _ORDERS.get(file.read(_HEADER)[-2:])
        if order is None:
            return  # version 4, which has no compression, or 7.3, which is HDF5
        whole = 0
        while len(tag := file.read(8)) == 8:
            kind, size = struct.unpack(f"{order}II", tag)
            if kind != _COMPRESSED:
                file.seek(size, 1)
                continue
            packed, counted, stream = file.read(size), 0, zlib.decompressobj()
            while packed and not stream.eof:
                piece = stream.decompress(packed, _READ_AT_ONCE if counted else 8)
                stated = struct.unpack(f"{order}II", piece)[1] if not counted and len(piece) == 8 else 0
                counted, packed = counted + len(piece), stream.unconsumed_tail
                yield whole + max(counted, stated)
            whole += counted


READERS = {".mat": open_matlab, ".npz": open_numpy, ".npy": open_numpy}


if __name__ == "__main__":
    answer(_parsed)
