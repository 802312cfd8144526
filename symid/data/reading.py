"""Reading of logs: from the columns of a file to checked signals in SI units."""

from __future__ import annotations

import difflib
import os
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Final

import numpy as np

from symid.arrays import FloatArray
from symid.data.checks import inspect_spans, inspect_values
from symid.data.clock import Clock, inspect_clock
from symid.data.log import Log
from symid.data.tables import Table, open_table
from symid.errors import LogError
from symid.units import Unit, to_si

REFERENCE: Final = "reference"
"""Column of the commanded position, kept where there is one."""

_TIME: Final = "t"
_HEADER: Final = re.compile(r"(?P<name>.*?)\s*\[(?P<unit>[^\]]*)\]\s*")
_NOTHING: Final[Mapping[str, str]] = MappingProxyType({})
_NO_GAINS: Final[Mapping[str, float]] = MappingProxyType({})
_NO_ALTERNATIVES: Final[Mapping[str, tuple[str, float]]] = MappingProxyType({})


@dataclass(frozen=True)
class _Source:
    """Where a signal comes from: position of its column and the factor that makes it SI."""

    signal: str
    position: int
    factor: float


@dataclass(frozen=True)
class _Mapping:
    """What the user says about the columns of a file, and what the axis declares."""

    headers: tuple[str, ...]
    expected: Mapping[str, Unit]
    alternatives: Mapping[str, tuple[str, float]]
    columns: Mapping[str, str]
    units: Mapping[str, str]
    gains: Mapping[str, float]


def read_log(
    path: str | os.PathLike[str],
    *,
    expected: Mapping[str, Unit],
    alternatives: Mapping[str, tuple[str, float]] = _NO_ALTERNATIVES,
    columns: Mapping[str, str] = _NOTHING,
    units: Mapping[str, str] = _NOTHING,
    gains: Mapping[str, float] = _NO_GAINS,
    time_column: str = _TIME,
) -> Log:
    """Read and check the signals of an axis from a CSV, Parquet or MATLAB (v5 to v7) file.

    A column is named after its signal, with or without a unit (SI): ``q2`` or ``q2 [mm]``.

    Parameters
    ----------
    path : path-like
        File; its suffix says its kind.
    expected : Mapping of str to Unit
        Signals that the axis knows. Those in the file are read, and must be usable; others may be missing.
    alternatives : Mapping of str to (str, float)
        Another column from which a signal that the file does not have is made, and the factor to it (SI).
    columns, units, gains : Mapping of str to str, str, float
        For signals, ``t``, ``reference`` and alternative columns: the column of the file, its unit, and a
        factor that is applied after the conversion to SI.
    time_column : str
        Column of the time, unless `columns` names one.

    Returns
    -------
    Log
        The signals found, with ``reference`` if the file has it. Its notes tell what looks odd.

    Raises
    ------
    LogError
        In one line: the file is unreadable, a named column is missing, no signal is there, a unit does not
        fit, a value is no number, the clock is not uniform, a signal is constant.
    """
    file = Path(path)
    table = open_table(file)
    given = _Mapping(table.headers, expected, alternatives, {_TIME: time_column, **columns}, units, gains)
    try:
        sources = _sources(given, named=columns.keys())
        values, notes = _read(table, sources, optional={REFERENCE} - columns.keys() - expected.keys())
        return _checked(str(file), values, notes, expected)
    except LogError as error:
        message = str(error)
        raise (
            error if message.startswith(f"{file}: ") else LogError(f"{file}: {message}")
        ) from error.__cause__


def columns_in(path: str | os.PathLike[str]) -> frozenset[str]:
    """Names of the columns of a file, with and without their units; LogError if it is no log.

    Parameters
    ----------
    path : path-like
        A file that `read_log` reads.
    """
    headers = open_table(Path(path)).headers
    return frozenset(headers) | {_split(header)[0] for header in headers}


def _sources(given: _Mapping, named: Collection[str]) -> tuple[_Source, ...]:
    """Column and factor of each signal that the file has; raises all faults of the assignment together."""
    faults = list(_unknown_keys(given))
    sources: list[_Source] = []
    for signal in dict.fromkeys((_TIME, *given.expected, REFERENCE)):
        try:
            source = _source(given, signal, must=signal == _TIME or signal in named)
        except LogError as error:
            faults.append(str(error))
            continue
        if source is not None:
            sources.append(source)
    if not faults and not any(source.signal in given.expected for source in sources):
        faults.append(
            f"has none of the signals {', '.join(given.expected)}: {_there(given.headers)}, "
            f"name one with --column {next(iter(given.expected), 'q')}=NAME"
        )
    if faults:
        raise LogError("; ".join(faults))
    return tuple(sources)


def _unknown_keys(given: _Mapping) -> list[str]:
    known = {_TIME, REFERENCE, *given.expected, *(name for name, _ in given.alternatives.values())}
    keys = dict.fromkeys([*given.columns, *given.units, *given.gains])
    return [
        f"signal {key!r} is not known{_similar(key, known)}: the axis has {', '.join(given.expected)}"
        for key in keys
        if key not in known
    ]


def _source(given: _Mapping, signal: str, *, must: bool) -> _Source | None:
    column = given.columns.get(signal, signal)
    position = _position(given.headers, column)
    unit = Unit.of("s") if signal == _TIME else given.expected.get(signal)
    if position is not None:
        return _Source(signal, position, _factor(given, signal, position, unit))
    if must:
        what = "time" if signal == _TIME else f"signal {signal!r}"
        hint = "map it with" if signal == _TIME else "correct"
        raise LogError(
            f"there is no column {column!r} for the {what}{_similar(column, given.headers)}: "
            f"{_there(given.headers)}, {hint} --column {signal}=NAME"
        )
    if signal not in given.alternatives:
        return None
    other, gain = given.alternatives[signal]
    position = _position(given.headers, given.columns.get(other, other))
    if position is None:
        return None
    if signal in given.units or signal in given.gains:
        raise LogError(
            f"unit or gain of {signal!r} is given, but it is made from column {given.headers[position]!r}: "
            f"add --column {signal}={_split(given.headers[position])[0]} or drop them"
        )
    return _Source(signal, position, gain * _factor(given, other, position, None))


def _factor(given: _Mapping, signal: str, position: int, unit: Unit | None) -> float:
    header = given.headers[position]
    text = given.units.get(signal, _split(header)[1])
    gain = float(given.gains.get(signal, 1.0))
    if not np.isfinite(gain) or gain == 0.0:
        raise LogError(f"gain {gain:g} of {signal!r} is not possible: give a finite number other than zero")
    if text is None:
        return gain
    try:
        return gain * to_si(text, unit)
    except LogError as error:
        raise LogError(f"column {header!r}: {error}") from error


def _split(header: str) -> tuple[str, str | None]:
    """Name and unit of a header."""
    match = _HEADER.fullmatch(header)
    return (match["name"], match["unit"].strip()) if match else (header, None)


def _position(headers: Sequence[str], column: str) -> int | None:
    """Position of the column with this header or, failing that, with this name before its unit."""
    wanted = column.strip()
    for names in (headers, [_split(header)[0] for header in headers]):
        found = [position for position, name in enumerate(names) if name == wanted]
        if len(found) > 1:
            same = ", ".join(repr(headers[position]) for position in found)
            raise LogError(f"column {column!r} is there {len(found)} times ({same}): rename all but one")
        if found:
            return found[0]
    return None


def _there(headers: Sequence[str]) -> str:
    shown = ", ".join(headers[:20]) + (", ..." if len(headers) > 20 else "")
    return f"the file has {shown}" if headers else "the file has no columns of numbers"


def _similar(name: str, names: Collection[str]) -> str:
    close = difflib.get_close_matches(name, names, n=1, cutoff=0.5)
    return f" (did you mean {close[0]!r}?)" if close else ""


def _read(
    table: Table, sources: Sequence[_Source], optional: Collection[str]
) -> tuple[dict[str, FloatArray], list[str]]:
    """Values of each source in SI; what is wrong with an optional one becomes a note and drops it."""
    columns = table.read([source.position for source in sources])
    values: dict[str, FloatArray] = {}
    faults, notes = [], []
    for source, column in zip(sources, columns, strict=True):
        if not isinstance(column, str):
            with np.errstate(over="ignore"):  # what leaves the range is reported as not finite
                values[source.signal] = column if source.factor == 1.0 else source.factor * column
        elif source.signal in optional:
            notes.append(f"column {table.headers[source.position]!r} {column}; left out")
        else:
            faults.append(f"column {table.headers[source.position]!r} {column}")
    if faults:
        raise LogError("; ".join(faults))
    for signal in optional & values.keys():
        x = values[signal]
        if x.size != values[_TIME].size or not np.isfinite(x).all():
            notes.append(f"{signal!r} has missing values or another length; left out")
            del values[signal]
    return values, notes


def _checked(
    source: str, values: dict[str, FloatArray], notes: list[str], expected: Mapping[str, Unit]
) -> Log:
    lengths = {name: x.size for name, x in values.items()}
    if len(set(lengths.values())) > 1:
        listed = ", ".join(f"{name} {size}" for name, size in lengths.items())
        raise LogError(f"the columns differ in length ({listed}): save as many samples of each")
    time = values.pop(_TIME)
    if not time.size:
        raise LogError("has no rows: give a log with samples")
    clock = inspect_clock(time)
    needed = {name: x for name, x in values.items() if name in expected}
    faults = (*clock.faults, *inspect_values(time, needed))
    if faults:
        raise LogError("; ".join(faults))
    return _log(source, clock, time, values, notes, expected)


def _log(
    source: str,
    clock: Clock,
    time: FloatArray,
    values: dict[str, FloatArray],
    notes: list[str],
    expected: Mapping[str, Unit],
) -> Log:
    lengths = (Unit.of("m"), Unit.of("rad"))
    positions = [name for name in values if expected.get(name) in lengths]
    return Log(
        source=source,
        start=clock.start,
        sampling_period=clock.period,
        signals=values,
        notes=(*notes, *clock.notes, *inspect_spans(time, values, positions)),
    )
