"""Questions of `symid import` about a foreign file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import click

from symid.axis import Axis
from symid.cli.options import named_values, number
from symid.data import ForeignColumn
from symid.data.text_files import with_unit
from symid.errors import LogError, SettingError
from symid.identification import LogMapping
from symid.identification.signals import UNITS_TO_GIVE, for_drive, for_sensor
from symid.units import Unit, to_si

_OF_A_DRIVE = ("force", "current", "percent")
_EXAMPLES = {
    "time": "s, ms, us",
    "position": "mm",
    "velocity": "mm/s",
    "acceleration": "m/s^2, g",
    "force": "N, Nm, A, %",
}


@dataclass(frozen=True)
class Known:
    """Facts about a foreign file that its text does not state.

    Columns and units by signal; sampling rate without a column of the time, Hz; force per unit of the drive's column;
    force at 100 %.
    """

    named: dict[str, str] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)
    rate: float | None = None
    gain: float | None = None
    rated: float | None = None

    @classmethod
    def of(cls, options: dict[str, Any]) -> Known:
        """Facts that the options of `symid import` give."""
        named, units = named_values(options["column"], "--column"), named_values(options["unit"], "--unit")
        return cls(named, units, options["rate"], options["gain"], options["rated"])


def asked(
    axis: Axis, columns: Sequence[ForeignColumn], guess: Callable[[Known], LogMapping], known: Known
) -> Known:
    """Ask for the column and unit of each signal, the factor of the drive and the rate, unless options give them.

    `guess` supplies the defaults.
    """
    quantities = {"t": "time", **{s.signal: s.quantity for s in axis.sensors}}
    quantities |= {drive.signal: "force" for drive in axis.drives}
    for signal, quantity in quantities.items():
        unit = Unit.of("s") if signal == "t" else axis.signal_units[signal]
        known = _with_signal(signal, quantity, unit, columns, guess(known), known)
    missing = guess(known).missing
    if known.rate is None and any("sampling_period" in line for line in missing):
        known = replace(known, rate=_asked_number("Sampling rate in Hz"))
    if lacking := next((line for line in missing if "has no factor" in line), None):
        signal = lacking.partition(" ")[0]
        if "%" in lacking:
            prompt = f"{signal} at 100 %, in {axis.signal_units[signal]}"
            return replace(known, rated=_asked_number(prompt))
        return replace(known, gain=_asked_number(f"{signal}, {lacking.rpartition(' in ')[2]}"))
    return known


def asked_file(log: Path) -> str:
    """Ask for an unused file name for the mapping."""

    def free(text: str) -> str:
        if Path(text).exists():
            raise click.UsageError(f"{text} exists: give another name")
        return text

    return str(click.prompt("Write the mapping to", default=f"{log.name}.mapping.json", value_proc=free))


def _with_signal(
    signal: str,
    quantity: str,
    unit: Unit,
    columns: Sequence[ForeignColumn],
    mapping: LogMapping,
    known: Known,
) -> Known:
    """All known facts after the questions about a signal."""
    if signal not in known.named:
        column = click.prompt(
            f"Column of {signal}, the {quantity} (name, number, or - for none)",
            default=mapping.columns.get(signal, "-"),
            value_proc=lambda text: _column_of(text, columns),
        )
        if column is None:
            return known
        known = replace(known, named={**known.named, signal: column.header})
    column = _column_of(known.named[signal], columns)
    if column is not None and signal not in known.units:
        if quantity == "force":
            column = for_drive(column, signal, in_percent=known.rated is not None)
        else:
            column = for_sensor(column, signal, unit)
    if column is None or column.stated or signal in known.units:
        return known
    of_drive = quantity == "force" and column.scaled
    such = UNITS_TO_GIVE.get(unit, _EXAMPLES[quantity]).replace("'", "")
    answer = click.prompt(
        f"Unit of {column.header!r} ({such}{', or - if only its factor is known' * of_drive})",
        default="-" if of_drive else None if column.scaled else column.unit or str(unit),
        value_proc=lambda text: "" if of_drive and text == "-" else _unit_of(text, quantity, unit, column),
    )
    return replace(known, units={**known.units, signal: answer}) if answer else known


def _column_of(text: str, columns: Sequence[ForeignColumn]) -> ForeignColumn | None:
    """The column with a name or a number in the table; None for -."""
    name = text.strip()
    if name in ("", "-"):
        return None
    column = next((c for c in columns if name in (c.header, c.name)), None)
    if column is None and name.isascii() and name.isdigit() and 1 <= int(name) <= len(columns):
        return columns[int(name) - 1]
    if column is None:
        raise click.UsageError(
            f"there is no column {name!r}: give a name or number of the table, or - for none"
        )
    return column


def _unit_of(text: str, quantity: str, unit: Unit, column: ForeignColumn) -> str:
    """A unit of the expected quantity; for the drive also of a current or a percentage."""
    try:
        if quantity != "force" or with_unit(column, text).quantity not in _OF_A_DRIVE:
            to_si(text, unit)
    except LogError as error:
        raise click.UsageError(str(error)) from error
    return text


def _asked_number(question: str) -> float:
    def read(text: str) -> float:
        try:
            return number(text, "the answer")
        except SettingError as error:
            raise click.UsageError(str(error)) from error

    return float(click.prompt(question, value_proc=read))
