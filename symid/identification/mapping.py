"""How the columns of a foreign file become the signals of an axis: guessed once, written, edited, and used again."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

from symid.axis import Axis, Drive
from symid.data import REFERENCE, ForeignColumn, Layout, references_of
from symid.data.foreign import split_header, with_unit
from symid.data.layout import first_lines
from symid.errors import LogError, SettingError
from symid.files import is_finite_number, read_json, shortened
from symid.units import Unit, to_si

_PERIOD = re.compile(
    r"(?:cycle|sampl|period|interval|abtast|takt)[^\d]*(?P<value>\d+(?:[.,]\d+)?)\s*(?P<unit>s|ms|us|µs|Hz|kHz)\b",
    re.IGNORECASE,
)
_MOTION = "position", "velocity", "acceleration"
"""Quantities that a name without a unit suggests, and an answer refutes."""


@dataclass(frozen=True)
class LogMapping:
    """Columns, units and layout of a foreign file, for `read_axis_log`.

    Parameters
    ----------
    columns, units, gains : mapping
        Column, unit and factor by signal.
    late : mapping of str to float
        Time by which signals were recorded late, s.
    layout : Layout or None
        Of a CSV file; None for other files, and for CSV files that are one line of names and then values.
    sampling_period : float or None
        Of a file without a column of the time, s.
    guesses : tuple of str
        Guesses with their reasons; said whenever the mapping is used, until these lines are deleted.
    missing : tuple of str
        Facts that neither the file nor an answer provided; a mapping with such lines cannot be used.
    """

    columns: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    gains: Mapping[str, float] = field(default_factory=dict)
    late: Mapping[str, float] = field(default_factory=dict)
    layout: Layout | None = None
    sampling_period: float | None = None
    guesses: tuple[str, ...] = ()
    missing: tuple[str, ...] = ()

    @property
    def as_record(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self)


def read_mapping(file: str | Path, columns: Collection[str] = (), gains: Collection[str] = ()) -> LogMapping:
    """A mapping from its JSON file.

    Parameters
    ----------
    file : path-like
        Written by ``symid import``.
    columns, gains : collection of str
        Signals of which column or factor are given beside it: what it lacks of them is not a fault, and what it guesses
        of them is not used.

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
        line for line in mapping.missing if not any(_is_about(line, name) for name in (*columns, *gains))
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
    """Whether a line of what is missing names a signal."""
    return re.search(rf"(?<![\w]){re.escape(signal)}(?![\w])", line) is not None


def _mapping_of(record: object) -> LogMapping:
    """Mapping of what a JSON file holds; ValueError that names what has another shape."""
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
    known = {one.name: one.type for one in fields(Layout)}
    if not isinstance(value, dict) or not value.keys() <= known.keys():
        raise ValueError(f"layout is {shortened(value)}, it has {', '.join(known)}")
    for name, entry in value.items():
        kind = {"int": int, "bool": bool}.get(str(known[name]), str)
        if not isinstance(entry, kind) or (isinstance(entry, bool) and kind is not bool):
            raise TypeError(f"{name} of the layout is {shortened(entry)}, {kind.__name__} is required")
    return Layout(**value)


def guessed_mapping(
    axis: Axis,
    columns: Iterable[ForeignColumn],
    *,
    named: Mapping[str, str] = MappingProxyType({}),
    units: Mapping[str, str] = MappingProxyType({}),
    layout: Layout | None = None,
    sampling_period: float | None = None,
    gain: float | None = None,
    rated: float | None = None,
) -> LogMapping:
    """Guess which column is which signal of an axis.

    Sensors get the measured columns of their quantity in the order of the declaration; the drive gets a column of its
    own quantity, or of a current, or in percent of a rated value. A factor is never guessed: it is given, or missing.

    Parameters
    ----------
    axis : Axis
        Its signals.
    columns : iterable of ForeignColumn
        From `foreign_columns`.
    named, units : mapping of str to str
        Columns and units that are known by signal; these are not guesses.
    layout, sampling_period
        Of the file.
    gain : float, optional
        Force per unit of the drive's column.
    rated : float, optional
        Force that 100 % stands for.

    Raises
    ------
    SettingError
        If a signal or column that is named does not exist.
    LogError
        If a unit cannot be read.
    """
    require_known(LogMapping(columns={**named, **units}), axis)
    guess = _Guess(list(columns), named, units)
    guess.clock(sampling_period)
    for place, sensor in enumerate(axis.sensors):
        alike = sum(other.quantity == sensor.quantity for other in axis.sensors[place:])
        guess.sensor(sensor.signal, sensor.quantity, alike, needed=not place)
    for drive in axis.drives:
        guess.drive(drive, axis.signal_units[drive.signal], gain, rated)
    setpoint = [c for c in guess.free if c.setpoint and c.quantity == "position"]
    if (reference := guess.chosen(REFERENCE, setpoint)) is not None:
        guess.take(REFERENCE, reference)
    return LogMapping(
        guess.names,
        guess.units,
        guess.gains,
        {},
        layout,
        guess.period,
        tuple(guess.guesses),
        tuple(guess.missing),
    )


def stated_period(path: Path, layout: Layout) -> float | None:
    """Sampling period that a line above the header states, s.

    Examples
    --------
    >>> _period_in("Sampling interval: 2 ms"), _period_in("SampleRate;4 kHz"), _period_in("Axis X")
    (0.002, 0.00025, None)
    """
    found = (_period_in(line) for line in first_lines(path, layout.encoding)[: layout.above])
    return next((period for period in found if period), None)


def _period_in(line: str) -> float | None:
    match = _PERIOD.search(line)
    if match is None:
        return None
    value = float(match["value"].replace(",", ".")) * to_si(match["unit"].replace("µ", "u"))
    if not value:
        return None
    return 1.0 / value if "Hz" in match["unit"] else value


class _Guess:
    """Columns that are still free, and what has been decided."""

    def __init__(
        self, columns: list[ForeignColumn], named: Mapping[str, str], given: Mapping[str, str]
    ) -> None:
        self.named = {signal: _column_called(name, signal, columns) for signal, name in named.items()}
        self.given = given
        self.free = [column for column in columns if column not in self.named.values()]
        self.names: dict[str, str] = {}
        self.units: dict[str, str] = {}
        self.gains: dict[str, float] = {}
        self.period: float | None = None
        self.guesses: list[str] = []
        self.missing: list[str] = []

    def chosen(self, signal: str, candidates: Sequence[ForeignColumn]) -> ForeignColumn | None:
        """The column that is named for a signal, else the first candidate; in its given unit, if there is one."""
        column = self.named.get(signal, next(iter(candidates), None))
        return with_unit(column, self.given[signal]) if column and signal in self.given else column

    def take(self, signal: str, column: ForeignColumn, unit: str | None = None) -> None:
        """Decide that a column is a signal."""
        self.free = [other for other in self.free if other.header != column.header]
        self.names[signal] = column.header
        written = unit or column.unit
        if written:
            self.units[signal] = written
        if column.doubt:
            self.guesses.append(f"{signal} is column {column.header!r}, whose values {column.doubt}")
        if signal not in self.named or not column.stated:
            what = f"{signal} is column {column.header!r}{f' in {column.unit}' if column.unit else ''}"
            lacking = column.quantity is None and signal in self.named
            self.guesses.append(f"{what}: {'no unit, so SI is assumed' if lacking else column.reason}")

    def clock(self, sampling_period: float | None) -> None:
        """The column of the time, or the period of a file that has none."""
        time = self.chosen("t", [c for c in self.free if c.quantity == "time"])
        if time and time.unit:
            self.take("t", time)
        elif sampling_period is not None:
            self.period = sampling_period
            self.guesses.append(f"a sample every {sampling_period:g} s: given, or stated above the header")
        else:
            self.missing.append(
                "no column of the time has a known unit: give sampling_period in s (--rate), or the column of t"
            )

    def sensor(self, signal: str, quantity: str, alike: int, *, needed: bool) -> None:
        """A column for a sensor: one of its name, else the first measured one of its quantity.

        If the axis has fewer such sensors left (`alike`) than the file such columns, the guess names the others.
        """
        found = [c for c in self.free if c.quantity == quantity and not c.setpoint]
        found.sort(key=lambda c: not c.header.startswith(signal))
        column = self.chosen(signal, found)
        if column is not None:
            self.take(signal, column)
            others = [repr(c.header) for c in found if c.header != column.header]
            if signal not in self.named and not column.header.startswith(signal) and len(others) >= alike:
                self.guesses.append(f"{signal} may as well be column {' or '.join(others)}")
        elif needed:
            self.missing.append(f"no column seems to be the {quantity} {signal}: name it in columns")

    def drive(self, drive: Drive, unit: Unit, gain: float | None, rated: float | None) -> None:
        """A column for a drive's force, one of its name first, with its factor where it needs one."""
        signal, command = drive.signal, drive.command
        own = {Unit.of("A"): "current", Unit.of("V"): "voltage"}.get(unit, "force")
        found = sorted(self.free, key=lambda c: not c.header.startswith(signal))
        measured = {c.quantity: c for c in reversed(found) if not c.setpoint}
        if command and "voltage" in measured and own not in measured:
            self.take(command, measured["voltage"])
            return
        column = self.chosen(signal, [measured[q] for q in (own, "percent", "current") if q in measured])
        if column is None:
            self.missing.append(f"no column seems to be the force {signal}: name it in columns")
            return
        if rated is not None and column.quantity != "percent":
            self.guesses.append(f"the rated value is not used: column {column.header!r} is not in percent")
        misnamed = (
            signal in self.named and column.quantity in _MOTION and column.unit is None
        )  # v may be volts
        if (misnamed or column.quantity in (own, None)) and _measures(column.unit, unit):
            self.take(signal, column)
            if gain is not None:
                self.gains[signal] = gain
                self.guesses.append(f"{signal} is {gain:g} times that column: given")
            return
        self.take(signal, column, str(unit))
        in_percent = column.quantity == "percent"
        factor = rated / 100 if rated is not None and in_percent else gain
        per = "% (rated value / 100)" if in_percent else column.unit or "A"
        if factor is not None:
            self.gains[signal] = factor
            self.guesses.append(f"{signal} is {factor:g} {unit} per {'%' if in_percent else per}: given")
            return
        self.missing.append(f"{signal} has no factor: give gains {signal} in {unit} per {per}")


def _column_called(name: str, signal: str, columns: Sequence[ForeignColumn]) -> ForeignColumn:
    """The column with a header, or with a name before its unit."""
    wanted = name.strip()
    for column in (
        c for part in (0, 1) for c in columns if wanted == (c.header, split_header(c.header)[0])[part]
    ):
        return column
    raise SettingError(
        f"there is no column of numbers {name!r} for {signal}: choose from {', '.join(c.header for c in columns)}"
    )


def _measures(written: str | None, unit: Unit) -> bool:
    """Whether a written unit is one of the drive's force; without one, it is taken to be."""
    try:
        return written is None or to_si(written, unit) > 0
    except LogError:
        return False


def require_known(mapping: LogMapping, axis: Axis) -> None:
    """Raise LogError if the mapping is that of another axis."""
    commands = {drive.command for drive in axis.drives if drive.command}
    known = {"t", *references_of(axis.signal_units), *axis.signal_units, *commands}
    if strange := [name for name in mapping.columns if name not in known]:
        raise LogError(
            f"the mapping names {strange[0]!r}, which axis {axis.name!r} does not have: choose its own mapping"
        )
