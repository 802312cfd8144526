"""`identify` of any axis from any logs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal, cast, overload

from symid.axis import Axis
from symid.codegen import as_generated, model_of
from symid.data import Log
from symid.errors import SettingError
from symid.estimation.least_squares import Method
from symid.identification import (
    Constraints,
    Identification,
    Preparation,
    SharedIdentification,
    identify_with_known,
    measured_signals,
    with_fixed,
)
from symid.identification import identify as identify_model
from symid.verbs.axes import AnyAxis, axis_of
from symid.verbs.logs import Recorded, are_several, log_of


@overload
def identify(
    axis: AnyAxis,
    logs: Recorded | Sequence[Recorded],
    *,
    known: Mapping[str, Sequence[float]],
    **settings: Any,
) -> SharedIdentification: ...


@overload
def identify(
    axis: AnyAxis, logs: Recorded | Sequence[Recorded], *, known: None = None, **settings: Any
) -> Identification: ...


def identify(
    axis: AnyAxis,
    logs: Recorded | Sequence[Recorded],
    *,
    measured: Sequence[str] | None = None,
    method: Method = "wls",
    preparation: Preparation | None = None,
    ddof: int | None = None,
    nominal: Mapping[str, float] | None = None,
    fixed: Mapping[str, float] | None = None,
    bounds: Mapping[str, tuple[float | None, float | None]] | Literal["physical"] | None = None,
    prior: Mapping[str, tuple[float, float]] | None = None,
    known: Mapping[str, Sequence[float]] | None = None,
    examine: bool = True,
    **columns: Any,
) -> Identification | SharedIdentification:
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
    fixed : mapping of str to float, optional
        Values of parameters that are known; the others are identified with them.
    bounds : mapping of str to (low, high), or "physical", optional
        Between which parameters lie, None for no bound; "physical" keeps masses, inertias, springs and frictions from
        being negative.
    prior : mapping of str to (mean, deviation), optional
        Prior value of parameters, with its standard deviation.
    known : mapping of str to sequence of float, optional
        Values of parameters in each log, in the order of the logs, such as the payload, SI; not with another method,
        with bounds or priors.
    examine : bool
        Whether timing and bias are estimated.
    **columns
        ``columns``, ``units``, ``gains``, ``layout`` and ``sampling_period`` of files and frames, as in
        `symid.read_axis_log`.

    Returns
    -------
    Identification, or SharedIdentification with `known`
        Its status states what cannot be determined; nothing is raised for it. It is "contradicted" where `fixed`,
        `bounds` or `prior` lead out of the intervals of the estimate without them.

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
    >>> known = identify("rigid_1m", {"t": t, "q [mm]": 1e3 * q, "F": 5 * a + v + 2 * np.sign(v)}, fixed={"M": 5.0})
    >>> list(known.physical_parameters), known.status
    (['Fv', 'Fs'], 'ok')
    """
    given = cast("Sequence[Recorded]", logs) if are_several(logs) else (cast("Recorded", logs),)
    settings: dict[str, Any] = {
        "method": method,
        "preparation": preparation,
        "ddof": ddof,
        "nominal": nominal,
        "examine": examine,
    }
    if known is not None:
        if method != "wls" or bounds or prior or ddof is not None:
            raise SettingError(
                "known= does not go with bounds=, prior=, ddof= or method='ols': leave these out"
            )
        return _with_known(axis_of(axis).with_known(fixed or {}), given, measured, known, settings, columns)
    if fixed:
        return _with_fixed(
            axis, given, measured, fixed, {**settings, "bounds": bounds, "prior": prior}, columns
        )
    if isinstance(axis, (Axis, str)):
        declared = axis_of(axis)
        runs = [log_of(declared, log, measured, **columns) for log in given]
        model = model_of(axis, measured_signals(declared, runs, measured))
    else:
        model = as_generated(axis)
        # a file or a frame needs the declaration for its units
        runs = [
            log if isinstance(log, Log) else log_of(axis_of(axis), log, model.measured, **columns)
            for log in given
        ]
    return identify_model(model, runs, constraints=Constraints.of(model, bounds, prior), **settings)


def _with_known(
    axis: Axis,
    logs: Sequence[Recorded],
    measured: Sequence[str] | None,
    known: Mapping[str, Sequence[float]],
    settings: Mapping[str, Any],
    columns: Mapping[str, Any],
) -> SharedIdentification:
    """Identify what logs share in each of which the values of some parameters are known."""
    for name, values in known.items():
        if isinstance(values, (int, float)) or len(values) != len(logs):
            raise SettingError(
                f"known {name}={values} for {len(logs)} logs: give a list of one value for each log"
            )
    runs = [log_of(axis, log, measured, **columns) for log in logs]
    return identify_with_known(
        axis,
        runs,
        [{name: float(values[i]) for name, values in known.items()} for i in range(len(runs))],
        measured_signals(axis, runs, measured),
        preparation=settings["preparation"],
        nominal=settings["nominal"],
        examine=settings["examine"],
    )


def _with_fixed(
    axis: AnyAxis,
    logs: Sequence[Recorded],
    measured: Sequence[str] | None,
    fixed: Mapping[str, float],
    settings: dict[str, Any],
    columns: dict[str, Any],
) -> Identification:
    """Identify the parameters that are not known, and compare with the estimate of all parameters."""
    declared = axis_of(axis)
    runs = [log_of(declared, log, measured, **columns) for log in logs]
    signals = (
        measured if measured is not None or isinstance(axis, (Axis, str)) else as_generated(axis).measured
    )
    found = identify(declared.with_known(fixed), runs, measured=signals, **settings)
    alone = identify(declared, runs, measured=signals, **{**settings, "bounds": None, "prior": None})
    return with_fixed(found, alone)
