"""Guess of the signals of an axis among the columns of a foreign file."""

import shlex
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

from symid.axis import Axis, Drive, Sensor
from symid.data import REFERENCE, ForeignColumn, Layout
from symid.data.text_files import LONGEST_STROKE, quantity_named, with_unit
from symid.identification.signals.fitting_columns import (
    UNITS_TO_GIVE,
    column_called,
    for_drive,
    for_sensor,
    in_si,
    is_unit_of,
    like_position,
    makes_torque,
    may_command,
)
from symid.identification.signals.mapping import LogMapping, require_known
from symid.units import Unit, to_si

_MOST_LISTED = 12  # columns in a message
_SUGGESTED = None, "position", "velocity", "acceleration", "command"  # by a name; an answer refutes it


def guessed_mapping(
    axis: Axis,
    columns: Iterable[ForeignColumn],
    *,
    left_out: Mapping[str, str] = MappingProxyType({}),
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
    left_out : mapping of str to str
        Columns that hold no numbers, with the reasons.
    named, units : mapping of str to str
        Columns and units that are known by signal; these are not guesses.
    layout, sampling_period
        Of the file.
    gain : float, optional
        Force per unit of the drive's column.
    rated : float, optional
        Force at 100 %.

    Raises
    ------
    SettingError
        If a signal or column that is named does not exist.
    LogError
        If a unit cannot be read.
    """
    require_known(LogMapping(columns={**named, **units}), axis)
    guess = _Guess(list(columns), left_out, named, units)
    if layout and layout.separator == layout.decimal:
        guess.guesses.append("every second comma is a decimal mark: lines have two fields for each name")
    guess.clock(sampling_period)
    for place, sensor in enumerate(axis.sensors):
        alike = sum(other.quantity == sensor.quantity for other in axis.sensors[place:])
        guess.sensor(sensor, axis.signal_units[sensor.signal], alike, needed=not place)
    for place, drive in enumerate(axis.drives):
        guess.drive(drive, axis.signal_units[drive.signal], len(axis.drives) - place, gain, rated)
    guess.reference()
    return LogMapping(
        columns=guess.names,
        units=guess.units,
        gains=guess.gains,
        layout=layout,
        sampling_period=guess.period,
        guesses=tuple(guess.guesses),
        missing=tuple(guess.missing),
    )


class _Guess:
    """Decisions so far, and the columns that are still free."""

    def __init__(
        self,
        columns: list[ForeignColumn],
        left_out: Mapping[str, str],
        named: Mapping[str, str],
        given: Mapping[str, str],
    ) -> None:
        self.named = {
            signal: column_called(name, signal, columns, left_out) for signal, name in named.items()
        }
        self.left_out = left_out
        self.given = given
        self.free = [column for column in columns if column not in self.named.values()]
        self.names: dict[str, str] = {}
        self.units: dict[str, str] = {}
        self.gains: dict[str, float] = {}
        self.period: float | None = None
        self.count: str | None = None  # unit of a position in counts
        self.position: ForeignColumn | None = None  # the column of the first position
        self.guesses: list[str] = []
        self.missing: list[str] = []

    def chosen(self, signal: str, candidates: Sequence[ForeignColumn]) -> ForeignColumn | None:
        """The column that is named for a signal, else the first candidate; in its given unit, if there is one."""
        column = self.named.get(signal, next(iter(candidates), None))
        return with_unit(column, self.given[signal]) if column and signal in self.given else column

    def take(self, signal: str, column: ForeignColumn, unit: str | None = None, such: str = "mm") -> None:
        """Decide that a column is a signal; `such` are examples of its units."""
        self.free = [other for other in self.free if other.header != column.header]
        self.names[signal] = column.header
        written = unit or column.unit
        if written:
            self.units[signal] = written
            if column.scaled and column.quantity == "position" and self.count is None:
                self.count = written
        elif column.scaled and signal not in self.given:
            self.missing.append(
                f"{signal} has no unit, {column.reason}: give it with `units` {signal}=UNIT, such as {such}"
            )
        if column.doubt:
            self.guesses.append(f"{signal} is column {column.header!r}, whose values {column.doubt}")
        if signal not in self.named or not column.stated:
            what = f"{signal} is column {column.header!r}{f' in {column.unit}' if column.unit else ''}"
            lacking = column.quantity is None and signal in self.named
            self.guesses.append(f"{what}: {'no unit, so SI is assumed' if lacking else column.reason}")

    def clock(self, sampling_period: float | None) -> None:
        """The column of the time, or the period of a file that has none."""
        times = [c for c in self.free if c.quantity == "time"]
        time = self.chosen("t", sorted(times, key=lambda c: (c.unit is None, c.constant, c.coarse)))
        if time and time.unit and not time.coarse:
            self.take("t", time)
        elif sampling_period is not None:
            self.period = sampling_period
            self.guesses.append(f"a sample every {sampling_period:g} s: given, or stated above the header")
        elif time and time.unit and time.row_period is not None:
            self.period = time.row_period * to_si(time.unit)
            self.guesses.append(
                f"a sample every {self.period:.7g} s by the numbers of the rows: samples share the rounded times of "
                f"column {time.header!r}, which rise evenly by that on average ({time.reason})"
            )
        elif time and time.coarse:
            self.missing.append(
                f"samples share the rounded times of column {time.header!r}, which do not rise evenly, as where "
                "samples are lost: record it with more digits, or give `sampling_period` if none is lost"
            )
        else:
            self.missing.append(
                "no column of the time has a known unit: give `sampling_period`, or the column of t"
                + (f" and its unit: {time.header!r} may be it, {time.reason}" if time else "")
                + self.but_for("time")
            )

    def unidentified(self, signal: str) -> str:
        """Option for one of the columns that nothing identifies, each with its extent; empty without any."""
        free = [c for c in self.free if not (c.quantity or c.unit or c.constant or c.setpoint or c.scaled)]
        listed = ", ".join(
            f"{c.header!r} ({c.extent[0]:.4g} to {c.extent[1]:.4g})" for c in free[:_MOST_LISTED]
        )
        such = f", such as `columns` {shlex.quote(f'{signal}={free[0].header}')}" if free else ""
        return f"{such}; of unknown meaning are {listed}" if free else ""

    def but_for(self, quantity: str) -> str:
        """Remark on columns of a quantity by their names, which hold something else than numbers."""
        alike = (header for header in self.left_out if quantity_named(header) == quantity)
        return "".join(f"; column {header!r} {self.left_out[header]}" for header in alike)

    def reference(self) -> None:
        """The commanded position, which nothing needs: of unknown counts only where the position has such ones too."""
        setpoint = [c for c in self.free if c.setpoint and c.quantity == "position" and not c.constant]
        column = self.chosen(REFERENCE, setpoint)
        if column is None:
            return
        if self.position and not (column.stated or column.scaled or {REFERENCE} & {*self.named, *self.given}):
            column = like_position(column, self.position)
        if column.scaled and not column.unit and REFERENCE not in self.named:
            if self.count is None:
                why = f"{column.header!r} has no unit, {column.reason}"
                self.guesses.append(f"{REFERENCE} is not taken: {why}")
                return
            column = replace(column, unit=self.count, reason="its counts are taken for those of the position")
        self.take(REFERENCE, column)

    def called(self, signal: str) -> list[ForeignColumn]:
        """The column that has the name of a signal, if no unit says that it measures something else."""
        same = [c for c in self.free if (c.header, c.unit) == (signal, None) and c.quantity in _SUGGESTED]
        return [replace(in_si(c), quantity=None) for c in same]

    def sensor(self, sensor: Sensor, unit: Unit, alike: int, *, needed: bool) -> None:
        """A column for a sensor: one of its name, else the first measured one of its quantity.

        If the axis has fewer such sensors left (`alike`) than the file such columns, the guess names the others.
        """
        signal, quantity = sensor.signal, sensor.quantity
        found = [c for c in self.free if c.quantity == quantity and not c.setpoint]
        found.sort(key=lambda c: (c.constant, not c.header.startswith(signal)))
        column = self.chosen(signal, found or self.called(signal))
        if column is not None:
            long = unit == Unit.of("m") and column.extent[1] - column.extent[0] > LONGEST_STROKE
            if signal in self.named and column.quantity is None and long:
                why = f"{column.extent[0]:.4g} to {column.extent[1]:.4g} are too far apart for SI"
                column = replace(column, quantity="position", scaled=True, reason=why)
            column = for_sensor(column, signal, unit)
            self.position = self.position or (column if quantity == "position" else None)
            such = UNITS_TO_GIVE.get(unit, f"'0.1 {unit}'")
            self.take(signal, column, None if column.unit or column.scaled else str(unit), such)
            self.name_others(signal, column, found, alike)
        elif needed:
            self.missing.append(
                f"no column seems to be the {quantity} {signal}: name it with `columns` {signal}=NAME"
                + self.unidentified(signal)
                + "".join(
                    f"; {c.header!r} is a velocity, which an axis may declare" for c in self.moving(quantity)
                )
                + self.but_for(quantity)
            )

    def moving(self, quantity: str) -> list[ForeignColumn]:
        """Measured velocities, where a position is sought."""
        speeds = [c for c in self.free if c.quantity == "velocity" and not c.setpoint]
        return speeds if quantity == "position" else []

    def name_others(
        self, signal: str, column: ForeignColumn, found: Sequence[ForeignColumn], alike: int
    ) -> None:
        """Name other columns that may be a signal, if there are as many as signals like it (`alike`) are left."""
        others = [repr(c.header) for c in found if c.header != column.header]
        if signal not in self.named and not column.header.startswith(signal) and len(others) >= alike:
            self.guesses.append(f"{signal} may as well be column {' or '.join(others)}")

    def drive(self, drive: Drive, unit: Unit, alike: int, gain: float | None, rated: float | None) -> None:
        """A column for a drive's force, measured or else commanded, with its factor where it needs one."""
        signal, command = drive.signal, drive.command
        own = {Unit.of("A"): "current", Unit.of("V"): "voltage"}.get(unit, "force")
        found = sorted(
            self.free, key=lambda c: (c.constant, not c.header.startswith(signal), not makes_torque(c))
        )
        measured = {c.quantity: c for c in reversed(found) if not c.setpoint}
        if command and "voltage" in measured and own not in measured:
            self.take(command, measured["voltage"])
            return
        commanded = {c.quantity: c for c in reversed(found) if c.setpoint}
        forces = [of[q] for of in (measured, commanded) for q in (own, "percent", "current") if q in of]
        sent = [of["command"] for of in (measured, commanded) if "command" in of]
        column = self.chosen(signal, forces or self.called(signal) or sent)
        if column is None:
            self.missing.append(
                f"no column seems to be the force {signal}: name it with `columns` {signal}=NAME"
                + self.unidentified(signal)
                + "".join(f"; {c.header!r} may be it" for c in found if may_command(c))
                + self.but_for("force")
            )
            return
        column = for_drive(column, signal, in_percent=rated is not None)
        kind = column.quantity, column.setpoint, False, makes_torque(column)
        same = [c for c in found if (c.quantity, c.setpoint, c.constant, makes_torque(c)) == kind]
        self.name_others(signal, column, same if column.quantity else [], alike)
        if column.setpoint and signal not in self.named:
            self.guesses.append(f"{signal} is a command: no column seems to be a measured force")
        if rated is not None and gain is None and not (column.unit or column.scaled):
            why = "no unit, so per cent is assumed of the rated value that is given"
            column = replace(column, quantity="percent", unit="%", reason=why)
        if rated is not None and column.quantity != "percent":
            self.guesses.append(f"the rated value is not used: column {column.header!r} is not in percent")
        # v may be volts
        misnamed = signal in self.named and column.quantity in _SUGGESTED[1:] and not column.unit
        in_unit = not column.scaled and is_unit_of(column.unit, unit)
        if (misnamed or column.quantity in (own, None)) and in_unit:
            self.take(signal, column, column.unit or str(unit))
            if gain is not None:
                self.gains[signal] = gain
            return
        self.take(signal, column, str(unit))
        in_percent = column.quantity == "percent"
        size = float((column.unit or "").partition(" ")[0].rstrip("%") or 1) if in_percent else 1.0
        factor = rated / 100 * size if rated is not None and in_percent else gain
        known = "A" if column.quantity == "current" and not column.scaled else f"unit of {column.header!r}"
        per = f"{column.unit} (rated value / {100 / size:g})" if in_percent else column.unit or known
        if factor is not None:
            self.gains[signal] = factor
            if column.unit not in (None, "A") and not in_percent:
                self.guesses.append(f"{signal} is {factor:g} {unit} per {per}")
            return
        self.missing.append(f"{signal} has no factor: give `gains` {signal} in {unit} per {per}")
