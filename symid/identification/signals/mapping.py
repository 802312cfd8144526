"""Mapping of the columns of a foreign file to the signals of an axis, stored in a file after it was guessed once."""

import re
from collections.abc import Collection, Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import Any

from symid.axis import Axis
from symid.data import Layout, references_of
from symid.errors import LogError, SettingError
from symid.files import is_finite_number, read_json, shortened


@dataclass(frozen=True)
class LogMapping:
    """Columns, units and layout of a foreign file, for `read_axis_log`."""

    columns: Mapping[str, str] = field(default_factory=dict)
    """Column by signal."""
    units: Mapping[str, str] = field(default_factory=dict)
    """Unit by signal."""
    gains: Mapping[str, float] = field(default_factory=dict)
    """Factor by signal."""
    late: Mapping[str, float] = field(default_factory=dict)
    """Time by which signals were recorded late, s."""
    layout: Layout | None = None
    """Layout of a CSV file; None for other files, and for CSV files that are one line of names and then values."""
    sampling_period: float | None = None
    """Sampling period of a file without a column of the time, s."""
    guesses: tuple[str, ...] = ()
    """Guesses with their reasons; printed whenever the mapping is used, until these lines are deleted."""
    missing: tuple[str, ...] = ()
    """Facts that neither the file nor an answer provided; a mapping with such lines cannot be used."""

    @property
    def as_record(self) -> dict[str, Any]:
        """Content of the mapping as JSON values."""
        return asdict(self)


def read_mapping(
    file: str | Path, columns: Collection[str] = (), gains: Collection[str] = (), units: Collection[str] = ()
) -> LogMapping:
    """A mapping from its JSON file.

    Parameters
    ----------
    file : path-like
        Written by ``symid import``.
    columns, gains, units : collection of str
        Signals whose column, factor or unit is given separately. Missing entries for them are not faults, and guesses
        about them are not used.

    Raises
    ------
    SettingError
        If the file holds no mapping, or one in which something is still missing.
    """
    record = read_json(file)
    try:
        mapping = _mapping_of(record)
    except (ValueError, TypeError, LogError) as error:
        raise SettingError(
            f"{file} holds no mapping of columns: write one with symid import ({error})"
        ) from error
    missing = [
        line
        for line in mapping.missing
        if not any(_is_about(line, name) for name in (units if "has no unit" in line else (*columns, *gains)))
    ]
    if missing:
        raise SettingError(
            f"mapping {file} is not complete: {'; '.join(missing)}; fill it in and delete its line in missing, "
            "or give it as an option"
        )
    guesses = tuple(line for line in mapping.guesses if not _is_replaced(line, columns, gains))
    return replace(mapping, guesses=guesses, missing=())


def _is_replaced(line: str, columns: Collection[str], gains: Collection[str]) -> bool:
    """Whether a guess is about a column or a factor that is given instead."""
    about = re.match(r"(\S+) (is column|may as well|is )", line)
    return about is not None and about[1] in (gains if about[2] == "is " else columns)


def _is_about(line: str, signal: str) -> bool:
    """Whether a line on a missing entry names a signal."""
    return re.search(rf"(?<![\w]){re.escape(signal)}(?![\w])", line) is not None


def _mapping_of(record: object) -> LogMapping:
    """Mapping from the content of a JSON file; ValueError that names an entry of another shape."""
    known = [one.name for one in fields(LogMapping)]
    if not isinstance(record, dict):
        raise TypeError(f"{shortened(record)} where names and values are required")
    if unknown := [name for name in record if name not in known]:
        raise ValueError(f"{shortened(unknown[0])} is not known, it has {', '.join(known)}")
    given: dict[str, Any] = {}
    for name in ("columns", "units", "gains", "late"):
        given[name] = _entries(name, record.get(name) or {})
    for name in ("guesses", "missing"):
        given[name] = tuple(map(str, _listed(name, record.get(name) or [])))
    period, layout = record.get("sampling_period"), record.get("layout")
    if period is not None and not is_finite_number(period):
        raise ValueError(f"sampling_period is {shortened(period)}, a number of seconds is required")
    return LogMapping(**given, layout=_layout_of(layout) if layout else None, sampling_period=period)


def _entries(name: str, value: object) -> dict[str, Any]:
    """Texts, or numbers for gains and times, by signal."""
    if not isinstance(value, dict):
        raise TypeError(f"{name} is {shortened(value)}, signals with values are required")
    for signal, entry in value.items():
        if name in ("gains", "late"):
            if not is_finite_number(entry):
                raise ValueError(f"{name} of {signal} is {shortened(entry)}, a finite number is required")
        elif not isinstance(entry, str):
            raise ValueError(f"{name} of {signal} is {shortened(entry)}, a text is required")
    return {signal: float(v) if name in ("gains", "late") else v for signal, v in value.items()}


def _listed(name: str, value: object) -> list[Any]:
    if not isinstance(value, list):
        raise TypeError(f"{name} is {shortened(value)}, a list of texts is required")
    return value


def _layout_of(value: object) -> Layout:
    known: dict[str, Any] = {one.name: one.type for one in fields(Layout)}
    if not isinstance(value, dict) or not value.keys() <= known.keys():
        raise ValueError(f"layout is {shortened(value)}, it has {', '.join(known)}")
    for name, entry in value.items():
        kind = known[name]
        if not isinstance(entry, kind) or (isinstance(entry, bool) and kind is not bool):
            raise TypeError(f"{name} of the layout is {shortened(entry)}, {kind.__name__} is required")
    return Layout(**value)


def require_known(mapping: LogMapping, axis: Axis) -> None:
    """Raise LogError if the mapping is that of another axis."""
    commands = {drive.command for drive in axis.drives if drive.command}
    known = {"t", *references_of(axis.signal_units), *axis.signal_units, *commands}
    if strange := [name for name in mapping.columns if name not in known]:
        raise LogError(
            f"the mapping names {strange[0]!r}, which axis {axis.name!r} does not have: choose its own mapping"
        )
