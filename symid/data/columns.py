"""Mapping of the columns of a file to signals, with the factors that make them SI."""

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from symid.errors import LogError
from symid.text import similar
from symid.units import Unit, to_si

REFERENCE: Final = "reference"
"""Column of the commanded position, kept where there is one."""

TIME: Final = "t"


def references_of(signals: Collection[str]) -> tuple[str, ...]:
    """Columns of commanded positions: the common one, and that of the drive with each signal.

    Examples
    --------
    >>> references_of(["F1", "F2"])
    ('reference', 'reference_F1', 'reference_F2')
    """
    return REFERENCE, *(f"{REFERENCE}_{signal}" for signal in signals)


_POSITIONS: Final = Unit.of("m"), Unit.of("rad")
_HEADER: Final = re.compile(r"(?P<name>.*?)\s*\[(?P<unit>[^\]]*)\]\s*")


@dataclass(frozen=True)
class Source:
    """Source of a signal: position of its column, factor to SI, and whether its unit is known."""

    signal: str
    position: int
    factor: float
    stated: bool = True


@dataclass(frozen=True)
class Assignment:
    """Columns of a file, assigned to signals by the user and by the axis; the fields are as in `read_log`."""

    headers: tuple[str, ...]
    expected: Mapping[str, Unit]
    alternatives: Mapping[str, tuple[str, float]]
    columns: Mapping[str, str]
    units: Mapping[str, str]
    gains: Mapping[str, float]


def sources_of(assigned: Assignment, named: Collection[str]) -> tuple[Source, ...]:
    """Column and factor of each signal that the file has; raises all faults of the assignment together."""
    made = (name for name, _ in assigned.alternatives.values())
    known = {TIME, *assigned.expected, *made, *references_of(assigned.expected)}
    faults = [
        f"signal {key!r} is not known{similar(key, known)}: the axis has {', '.join(assigned.expected)}"
        for key in dict.fromkeys([*assigned.columns, *assigned.units, *assigned.gains])
        if key not in known
    ]
    sources: list[Source] = []
    for signal in dict.fromkeys((TIME, *assigned.expected, *references_of(assigned.expected))):
        try:
            source = _source(assigned, signal, must=signal == TIME or signal in named)
        except LogError as error:
            faults.append(str(error))
            continue
        if source is not None:
            sources.append(source)
    if not faults and not any(source.signal in assigned.expected for source in sources):
        faults.append(
            f"has none of the signals {', '.join(assigned.expected)}: {_columns_named(assigned.headers)}, "
            f"name one with `columns` {next(iter(assigned.expected), 'q')}=NAME"
        )
    if faults:
        raise LogError("; ".join(faults))
    return tuple(sources)


def _source(assigned: Assignment, signal: str, *, must: bool) -> Source | None:
    column = assigned.columns.get(signal, signal)
    position = _position(assigned.headers, column)
    unit = Unit.of("s") if signal == TIME else assigned.expected.get(signal)
    if position is not None:
        text = assigned.units.get(signal, split_unit(assigned.headers[position])[1])
        if unit is None and text is not None and "count" in text:  # a reference is in counts of the positions
            unit = next(
                (
                    position_unit
                    for position_unit in assigned.expected.values()
                    if position_unit in _POSITIONS
                ),
                None,
            )
        return Source(signal, position, _factor(assigned, signal, position, unit), text is not None)
    if must:
        what = "time" if signal == TIME else f"signal {signal!r}"
        hint = "map it with" if signal == TIME else "correct"
        raise LogError(
            f"there is no column {column!r} for the {what}{similar(column, assigned.headers)}: "
            f"{_columns_named(assigned.headers)}, {hint} `columns` {signal}=NAME, or use symid import"
        )
    if signal not in assigned.alternatives:
        return None
    alternative, gain = assigned.alternatives[signal]
    position = _position(assigned.headers, assigned.columns.get(alternative, alternative))
    if position is None:
        return None
    if signal in assigned.units or signal in assigned.gains:
        raise LogError(
            f"unit or gain of {signal!r} is given, but it is made from column {assigned.headers[position]!r}: "
            f"add `columns` {signal}={split_unit(assigned.headers[position])[0]} or drop them"
        )
    return Source(signal, position, gain * _factor(assigned, alternative, position, None))


def _factor(assigned: Assignment, signal: str, position: int, unit: Unit | None) -> float:
    header = assigned.headers[position]
    text = assigned.units.get(signal, split_unit(header)[1])
    gain = float(assigned.gains.get(signal, 1.0))
    if not np.isfinite(gain) or gain == 0.0:
        raise LogError(f"gain {gain:g} of {signal!r} is not possible: give a finite number other than zero")
    if text is None:
        return gain
    try:
        return gain * to_si(text, unit)
    except LogError as error:
        taken = (
            f", or `units` {signal}={unit} if gain {gain:g} is {unit} per {text}"
            if signal in assigned.gains
            else ""
        )
        raise LogError(f"column {header!r}: {error}{taken}") from error


def split_unit(header: str) -> tuple[str, str | None]:
    """Name and unit of a header.

    >>> split_unit("q2 [mm]"), split_unit("q2")
    (('q2', 'mm'), ('q2', None))
    """
    match = _HEADER.fullmatch(header)
    return (match["name"], match["unit"].strip()) if match else (header, None)


def _position(headers: Sequence[str], column: str) -> int | None:
    """Position of the column with this header or, failing that, with this name before the unit."""
    wanted = column.strip()
    for names in (headers, [split_unit(header)[0] for header in headers]):
        positions = [position for position, name in enumerate(names) if name == wanted]
        if len(positions) > 1:
            same = ", ".join(repr(headers[position]) for position in positions)
            raise LogError(f"column {column!r} occurs {len(positions)} times ({same}): rename all but one")
        if positions:
            return positions[0]
    return None


def _columns_named(headers: Sequence[str]) -> str:
    shown = ", ".join(headers[:20]) + (", ..." if len(headers) > 20 else "")
    return f"the file has {shown}" if headers else "the file has no columns of numbers"
