"""Logs of an axis, given as such, as files or as data frames: the columns expected, and the sensors they hold."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, TypeAlias, Unpack, cast

from symid.axis import Axis, of_any_axis
from symid.data import MEMORY, AnyLog, ForeignColumns, Frame, Log, LongLog, in_memory, open_log, read_log
from symid.data.quality import constant_fault
from symid.errors import LogError, SettingError
from symid.units import Unit

LogLike: TypeAlias = "AnyLog | str | os.PathLike[str] | Frame"
"""A log, the path of one, a data frame, or columns by name."""


def axis_columns(
    axis: Axis, measured: Sequence[str] | None = None
) -> tuple[dict[str, Unit], Mapping[str, tuple[str, float]]]:
    """Signals and units that an axis expects of a log, and the commands from which its forces can be made.

    >>> from symid.axis import load_axis
    >>> axis_columns(load_axis("emps"))[1]
    {'F': ('vir', 35.15065188248547)}
    """
    used = (
        {sensor.signal for sensor in axis.measured(measured)}
        if measured
        else {s.signal for s in axis.sensors}
    )
    used |= {drive.signal for drive in axis.drives}
    expected = {name: unit for name, unit in axis.signal_units.items() if name in used}
    commands = {d.signal: (d.command, d.factor) for d in axis.drives if d.command is not None}
    return expected, commands


def _asked(foreign: ForeignColumns, axis: Axis, expected: Mapping[str, Unit]) -> ForeignColumns:
    """The same without the sensors that are not read: a mapping holds all sensors of its axis."""
    idle = set(axis.signal_units) - set(expected)
    columns, units, gains = foreign.get("columns"), foreign.get("units"), foreign.get("gains")
    return foreign | {
        "columns": {name: column for name, column in (columns or {}).items() if name not in idle},
        "units": {name: unit for name, unit in (units or {}).items() if name not in idle},
        "gains": {name: gain for name, gain in (gains or {}).items() if name not in idle},
    }


@of_any_axis
def read_axis_log(
    axis: Axis,
    path: str | os.PathLike[str] | Frame,
    *,
    measured: Sequence[str] | None = None,
    **foreign: Unpack[ForeignColumns],
) -> Log:
    """Log of an axis from a file or a data frame.

    Parameters
    ----------
    axis : Axis
        Says which signals to expect, and in which units.
    path : path-like or data frame
        The file, or a frame of pandas, polars or pyarrow, or columns by name.
    measured : sequence of str, optional
        Sensors to read; all that the file holds by default.
    **foreign
        ``columns``, ``units``, ``gains``, ``layout``, ``sampling_period`` and ``resample`` of a foreign file, as in
        `read_log`.

    Raises
    ------
    LogError
        If the log cannot be used.

    Examples
    --------
    >>> from symid.axis import load_axis, shipped_folder
    >>> file = shipped_folder("data") / "emps" / "DATA_EMPS.mat"
    >>> read_axis_log(load_axis("emps"), file, columns={"q": "qm"}).n_samples
    24841
    """
    expected, alternatives = axis_columns(axis, measured)
    return read_log(path, expected=expected, alternatives=alternatives, **_asked(foreign, axis, expected))


def open_axis_log(
    axis: Axis,
    path: str | os.PathLike[str] | Frame,
    *,
    measured: Sequence[str] | None = None,
    memory: int = MEMORY,
    whole: bool = False,
    **foreign: Unpack[ForeignColumns],
) -> AnyLog:
    """Log of an axis: `read_axis_log` if it fits in memory, otherwise a long log that is read in windows.

    Parameters
    ----------
    axis, path, measured, **foreign
        As in `read_axis_log`.
    memory : int
        Bytes that the log and the rows made of it may take.
    whole : bool
        Whether a log whose columns do not fit is refused instead of being read in blocks.

    Raises
    ------
    LogError
        If the log cannot be used.
    """
    expected, alternatives = axis_columns(axis, measured)
    options = _asked(foreign, axis, expected)
    return open_log(path, expected=expected, alternatives=alternatives, memory=memory, whole=whole, **options)


def measured_signals(
    axis: Axis, logs: Sequence[AnyLog], measured: Sequence[str] | None = None
) -> tuple[str, ...]:
    """Sensors to use: the requested ones, otherwise those that all logs have.

    Parameters
    ----------
    axis : Axis
        The declared axis.
    logs : sequence of Log or LongLog
        The logs.
    measured : sequence of str, optional
        Sensors that are requested.

    Raises
    ------
    LogError
        If a log does not have a force or sensor that is needed, or one of them never changes.
    """
    held = [sensor.signal for sensor in axis.sensors if all(sensor.signal in log.signals for log in logs)]
    wanted = list(measured) if measured else held
    needed = [*(drive.signal for drive in axis.drives), *(wanted or axis.required_sensors)]
    for log in logs:
        missing = [name for name in needed if name not in log.signals]
        if missing:
            raise LogError(
                f"{log.source}: there is no column for {', '.join(missing)}, which axis {axis.name!r} needs: "
                f"map one with `columns` {missing[0]}=NAME"
            )
        require_changing(log, needed)
    return tuple(wanted)


def require_changing(log: AnyLog, names: Iterable[str]) -> None:
    """LogError if one of the signals that the log holds is constant; a long log was checked when it was opened.

    >>> import numpy as np
    >>> log = Log.from_arrays({"F": np.cos(np.arange(100.0)), "q": np.zeros(100)}, sampling_period=0.01)
    >>> try:
    ...     require_changing(log, ["F", "q"])
    ... except LogError as error:
    ...     print(str(error)[:44])
    arrays: 'q' is constant (0) over the whole l
    """
    if isinstance(log, Log) and log.n_samples:
        for name in (name for name in names if name in log.signals):
            if fault := constant_fault(name, float(log[name].min()), float(log[name].max())):
                raise LogError(f"{log.source}: {fault}")


def log_of(axis: Axis, given: LogLike, measured: Sequence[str] | None = None, **columns: Any) -> AnyLog:
    """A log of an axis; a file or a frame is read and checked, with columns as in `symid.read_axis_log`."""
    if strange := [name for name in columns if name not in ForeignColumns.__annotations__]:
        known = ", ".join(ForeignColumns.__annotations__)
        raise SettingError(
            f"there is no setting {strange[0]!r}: how files and frames are read is set by {known}"
        )
    if isinstance(given, (Log, LongLog)):
        if columns:
            raise SettingError(
                f"{next(iter(columns))!r} is for files and frames, not for the Log {given.source}"
            )
        return given
    return read_axis_log(axis, given, measured=measured, **columns)


def each_of(given: LogLike | Sequence[LogLike]) -> Sequence[LogLike]:
    """Logs as a sequence; a single one may be given alone."""
    return cast("Sequence[LogLike]", given if isinstance(given, (list, tuple)) else (given,))


def logs_of(
    axis: Axis, given: LogLike | Sequence[LogLike], measured: Sequence[str] | None = None, **columns: Any
) -> list[Log]:
    """One or several logs of an axis, whole in memory."""
    return [in_memory(log_of(axis, each, measured, **columns)) for each in each_of(given)]
