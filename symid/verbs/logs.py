"""Logs, however they are given: as such, as files, or as data frames."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

from symid.axis import Axis
from symid.data import AnyLog, Frame, Log, LongLog
from symid.identification import logs as files
from symid.verbs.axes import AnyAxis, axis_of

Recorded: TypeAlias = "AnyLog | str | os.PathLike[str] | Frame"
"""A log, the path of one, a data frame, or columns by name."""


def log_of(axis: Axis, given: Recorded, measured: Sequence[str] | None = None, **columns: Any) -> AnyLog:
    """A log of an axis, read and checked if it is a file or a frame.

    Parameters
    ----------
    axis : Axis
        Says which signals to expect, and in which units.
    given : Log, path-like, data frame or mapping
        The log.
    measured : sequence of str, optional
        Sensors to use.
    **columns
        ``columns``, ``units``, ``gains``, ``layout``, ``sampling_period`` and ``resample`` as in `symid.read_axis_log`.

    Raises
    ------
    LogError
        If the log cannot be used.
    """
    if isinstance(given, (Log, LongLog)):
        return given
    return files.read_axis_log(axis, given, measured=measured, **columns)


def are_several(given: Recorded | Sequence[Recorded]) -> bool:
    """Whether these are logs in a list or tuple."""
    return isinstance(given, (list, tuple))


def read_axis_log(
    axis: AnyAxis,
    path: str | os.PathLike[str] | Frame,
    *,
    measured: Sequence[str] | None = None,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    gains: Mapping[str, float] | None = None,
    sampling_period: float | None = None,
    **layout: Any,
) -> Log:
    """Log of an axis from a file or from a data frame.

    Parameters
    ----------
    axis : Axis, str or model
        Says which signals to expect, and in which units.
    path : path-like or data frame
        The file, or a frame of pandas, polars or pyarrow, or columns by name.
    measured : sequence of str, optional
        Sensors to read; all that there are by default.
    columns, units, gains : mapping, optional
        Column, unit and factor of signals whose columns are foreign, as in `symid.read_log`.
    sampling_period : float, optional
        Time between two samples, s, of a log without a column of the time.
    **layout
        ``layout`` of a foreign file, and ``resample``, as in `symid.read_log`.

    Raises
    ------
    LogError
        If the log cannot be used.

    Examples
    --------
    >>> import numpy as np
    >>> t = np.arange(100) / 1000
    >>> read_axis_log("rigid_1m", {"t": t, "q [mm]": 1e3 * np.sin(t), "F [kN]": np.cos(t)}).n_samples
    100
    """
    return files.read_axis_log(
        axis_of(axis),
        path,
        measured=measured,
        columns=columns,
        units=units,
        gains=gains,
        sampling_period=sampling_period,
        **layout,
    )
