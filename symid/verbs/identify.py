"""`identify` of any axis from any logs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, cast

from symid.axis import Axis
from symid.codegen import GeneratedModel, as_generated, model_of
from symid.data import AnyLog, Log
from symid.estimation.least_squares import Method
from symid.identification import Identification, Preparation, measured_signals
from symid.identification import identify as identify_model
from symid.verbs.axes import AnyAxis, axis_of
from symid.verbs.logs import Recorded, are_several, log_of


def identify(
    axis: AnyAxis,
    logs: Recorded | Sequence[Recorded],
    *,
    measured: Sequence[str] | None = None,
    method: Method = "wls",
    preparation: Preparation | None = None,
    ddof: int | None = None,
    nominal: Mapping[str, float] | None = None,
    examine: bool = True,
    **columns: Any,
) -> Identification:
    """Identify the parameters of an axis from one log, or from several jointly.

    Parameters
    ----------
    axis : Axis, str, GeneratedModel or DerivedModel
        A declaration, the name or path of its file, or a model of it. What has no generated module is derived on the
        spot, once in a process.
    logs : Log, path-like, data frame, mapping, or list of these
        Runs of the axis; a frame of pandas, polars or pyarrow, or columns by name, is read as a file is.
    measured : sequence of str, optional
        Sensors to use; those that all logs hold by default, those of a model if one is given.
    method : {"wls", "ols"}
        Weighted or ordinary least squares.
    preparation : Preparation, optional
        Filter, differences, decimation, rows; what is left open is chosen from each log.
    ddof : int, optional
        Subtracted from the number of rows in the residual's deviation; the number of parameters by default.
    nominal : mapping of str to float, optional
        Nominal physical parameters, a start where the inverse map has no closed form.
    examine : bool
        Whether timing and bias are estimated.
    **columns
        ``columns``, ``units``, ``gains``, ``layout`` and ``sampling_period`` of files and frames, as in
        `symid.read_axis_log`.

    Returns
    -------
    Identification
        What cannot be determined is said by its status; nothing is raised for it.

    Raises
    ------
    LogError, SettingError
        If a log cannot be used, or a setting is not possible.

    Examples
    --------
    >>> import numpy as np
    >>> t = np.arange(4000) / 1000
    >>> q, v, a = np.sin(9 * t), 9 * np.cos(9 * t), -81 * np.sin(9 * t)
    >>> found = identify("rigid_1m", {"t": t, "q [mm]": 1e3 * q, "F": 5 * a + v + 2 * np.sign(v)})
    >>> {name: round(value, 1) for name, value in found.physical_parameters.items()}
    {'M': 5.0, 'Fv': 1.0, 'Fs': 2.0}
    """
    given = cast("Sequence[Recorded]", logs) if are_several(logs) else (cast("Recorded", logs),)
    if isinstance(axis, (Axis, str)):
        declared = axis_of(axis)
        runs = [log_of(declared, log, measured, **columns) for log in given]
        model = model_of(axis, measured_signals(declared, runs, measured))
    else:
        model = as_generated(axis)
        runs = [_of_model(axis, model, log, columns) for log in given]
    return identify_model(
        model, runs, method=method, preparation=preparation, ddof=ddof, nominal=nominal, examine=examine
    )


def _of_model(axis: AnyAxis, model: GeneratedModel, log: Recorded, columns: Mapping[str, Any]) -> AnyLog:
    """A log as it is; a file or a frame needs the declaration for its units."""
    return log if isinstance(log, Log) else log_of(axis_of(axis), log, model.measured, **columns)
