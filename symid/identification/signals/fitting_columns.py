"""Columns of a foreign file that may be a signal of an axis."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from symid.data import ForeignColumn
from symid.data.text_files import ANGLES, TORQUE, TORQUE_CURRENT
from symid.errors import LogError, SettingError
from symid.units import Unit, to_si

_AS_LARGE = 2.0
"""Largest ratio of the strokes of a commanded position and its measured one."""


def may_command(column: ForeignColumn) -> bool:
    """Whether a column may be the command of a drive although neither name nor unit states it."""
    return not column.constant and (column.quantity == "voltage" or (column.setpoint and not column.quantity))


_POSSIBLE = {Unit.of("rad"): "rad, deg or turn", Unit.of("rad/s"): "rad/s, deg/s, rpm or turn/s"}
"""Units that the column of an angle may have where none is usual."""
UNITS_TO_GIVE = {
    Unit.of("rad"): "deg or '4096 counts/rev'",
    Unit.of("rad/s"): "rpm or '0.1 deg/s'",
    Unit.of("m"): "mm, '5000 counts/mm' or, where one is that, '5 mm'",
}
"""Examples of units by that of a sensor."""


def makes_torque(column: ForeignColumn) -> bool:
    """Whether a current is named as the one that makes torque, beside those of the phases.

    >>> [makes_torque(ForeignColumn(c, "current", "A", False, "", True)) for c in ("iq_mA", "q_current", "Strom U [A]")]
    [True, True, False]
    """
    return column.is_named(TORQUE_CURRENT)


def for_sensor(column: ForeignColumn, signal: str, unit: Unit) -> ForeignColumn:
    """The column of a sensor in `unit`; of unknown unit, with the reason, if nothing shows a possible one.

    >>> pos = ForeignColumn("theta", "position", None, False, "no unit", False)
    >>> long, named = replace(pos, unit="mm"), replace(pos, header="position")
    >>> [for_sensor(c, "q", Unit.of("rad")).reason for c in (pos, long, named)]
    ['no unit', 'it may be in rad, deg or turn', 'it may be in rad, deg or turn']
    >>> for_sensor(replace(pos, unit="turn"), "q", Unit.of("m")).reason
    "as that of column 'theta', turn, does not convert to m"
    """
    is_long = column.unit == "mm" and not column.stated  # guessed for its stroke
    if column.header == signal and not column.stated:
        return in_si(column) if is_long and unit in _POSSIBLE else as_called(column, signal)
    is_open = not (column.stated or column.scaled) and (is_long or not column.unit) and column.quantity
    is_small_angle = not is_long and column.is_named(ANGLES)
    if is_open and unit in _POSSIBLE and not is_small_angle:
        return replace(column, unit=None, scaled=True, reason=f"it may be in {_POSSIBLE[unit]}")
    if not is_unit_of(column.unit, unit):
        why = f"as that of column {column.header!r}, {column.unit}, does not convert to {unit}"
        return replace(column, unit=None, scaled=True, reason=why)
    return column


def in_si(column: ForeignColumn) -> ForeignColumn:
    """A column that has the name of a signal, as in a log of an axis, whatever its numbers suggest."""
    why = "its name is that of the signal; no unit, so SI is assumed"
    return replace(column, unit=None, scaled=False, reason=why)


def as_called(column: ForeignColumn, signal: str) -> ForeignColumn:
    """A column in SI if it has the name of a signal and no unit, unless it is a position that may be in counts."""
    is_named = column.header == signal and column.scaled and column.quantity != "position"
    return in_si(column) if is_named else column


def for_drive(column: ForeignColumn, signal: str, *, in_percent: bool) -> ForeignColumn:
    """The column of a drive; of unknown size if it is a torque without a unit that is not known to be `in_percent`.

    >>> torque = ForeignColumn("TorqueReference", "force", None, True, "no unit, so SI is assumed", False)
    >>> [for_drive(torque, signal, in_percent=False).scaled for signal in ("F", "TorqueReference")]
    [True, False]
    """
    is_open = column.quantity == "force" and not (column.unit or column.scaled or column.header == signal)
    if is_open and not in_percent and column.is_named(TORQUE):
        why = f"a torque without a unit, in N*m (`units` {signal}=Nm) or per cent of its rated value"
        return replace(column, scaled=True, reason=why)
    return as_called(column, signal)


def is_unit_of(written: str | None, unit: Unit) -> bool:
    """Whether a written unit converts to another one; without one, it is taken to."""
    try:
        return written is None or to_si(written, unit) > 0
    except LogError:
        return False


def like_position(column: ForeignColumn, position: ForeignColumn) -> ForeignColumn:
    """The column of a commanded position without a stated unit, in that of a measured one of about its extent."""
    if position.scaled and not position.unit:
        return replace(column, unit=None, scaled=True, reason="as the position")
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
    for column in (c for part in (0, 1) for c in columns if wanted == (c.header, c.name)[part]):
        return column
    if wanted in left_out:
        raise SettingError(f"column {name!r} for {signal} {left_out[wanted]}")
    raise SettingError(
        f"there is no column of numbers {name!r} for {signal}: choose from {', '.join(c.header for c in columns)}"
    )
