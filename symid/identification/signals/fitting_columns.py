"""Columns of a foreign file that may be a signal of an axis."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from symid.data import ForeignColumn
from symid.data.text_files.column_names import split_header
from symid.errors import LogError, SettingError
from symid.units import Unit, to_si


def may_command(column: ForeignColumn) -> bool:
    """Whether a column may be the command of a drive, of which neither name nor unit says so."""
    return not column.constant and (column.quantity == "voltage" or (column.setpoint and not column.quantity))


def in_degrees(columns: Sequence[ForeignColumn], unit: Unit) -> list[ForeignColumn]:
    """Columns of a sensor in `unit`: where a length was guessed and it is an angle, in degrees."""
    why = "no unit, degrees are assumed: in rad it would be many turns"
    return [
        replace(c, unit="deg", reason=why)
        if unit == Unit.of("rad") and c.unit == "mm" and not c.stated
        else c
        for c in columns
    ]


def column_called(
    name: str, signal: str, columns: Sequence[ForeignColumn], left_out: Mapping[str, str]
) -> ForeignColumn:
    """The column with a header, or with a name before its unit."""
    wanted = name.strip()
    for column in (
        c for part in (0, 1) for c in columns if wanted == (c.header, split_header(c.header)[0])[part]
    ):
        return column
    if wanted in left_out:
        raise SettingError(f"column {name!r} for {signal} {left_out[wanted]}")
    raise SettingError(
        f"there is no column of numbers {name!r} for {signal}: choose from {', '.join(c.header for c in columns)}"
    )


def is_unit_of_drive(written: str | None, unit: Unit) -> bool:
    """Whether a written unit is one of the drive's force; without one, it is taken to be."""
    try:
        return written is None or to_si(written, unit) > 0
    except LogError:
        return False
