"""Columns of a foreign file that may be a signal of an axis."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from symid.data import ForeignColumn
from symid.data.text_files.column_names import match, split_header, words_of
from symid.data.text_files.column_words import ANGLES
from symid.errors import LogError, SettingError
from symid.units import Unit, to_si

_AS_LARGE = 2.0
"""Largest ratio of the strokes of a commanded position and its measured one."""


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


def in_doubt_of_angle(column: ForeignColumn, unit: Unit) -> str:
    """Units in which the column of a sensor in `unit` may be, if that is an angle and nothing tells which of them.

    >>> pos = ForeignColumn("position", "position", None, False, "no unit", False)
    >>> in_doubt_of_angle(pos, Unit.of("rad")), in_doubt_of_angle(pos, Unit.of("m"))
    ('rad, deg or turn', '')
    """
    known = column.stated or column.unit or column.scaled or column.quantity is None
    if known or match(words_of(split_header(column.header)[0]), ANGLES):
        return ""
    return {Unit.of("rad"): "rad, deg or turn", Unit.of("rad/s"): "rad/s, deg/s, rpm or turn/s"}.get(unit, "")


def like_position(column: ForeignColumn, position: ForeignColumn) -> ForeignColumn:
    """The column of a commanded position without a stated unit, in that of a measured one of about its extent."""
    sizes = [abs(c.extent[1] - c.extent[0]) for c in (column, position)]
    if position.unit in (None, column.unit) or not min(sizes) > max(sizes) / _AS_LARGE:
        return column
    why = "no unit, that of the position is taken, which moves as far"
    return replace(column, unit=position.unit, scaled=False, reason=why)


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
