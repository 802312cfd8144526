"""Logs, given as such, as files or as data frames."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, TypeAlias, cast

from symid.axis import Axis
from symid.data import AnyLog, Frame, Log, LongLog, in_memory
from symid.identification.signals.axis_logs import read_axis_log

LogLike: TypeAlias = "AnyLog | str | os.PathLike[str] | Frame"
"""A log, the path of one, a data frame, or columns by name."""


def log_of(axis: Axis, given: LogLike, measured: Sequence[str] | None = None, **columns: Any) -> AnyLog:
    """A log of an axis; a file or a frame is read and checked, with columns as in `symid.read_axis_log`."""
    if isinstance(given, (Log, LongLog)):
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
