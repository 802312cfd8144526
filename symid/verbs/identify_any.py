"""`identify` of any axis from any logs."""

from __future__ import annotations

import difflib
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, replace
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, cast, get_args, overload

from symid.arrays import FloatArray
from symid.axis import AnyAxis, Axis, axis_of
from symid.codegen import GeneratedModel, compiled, model_of
from symid.data import AnyLog, ForeignColumns, Log, first_block, in_memory
from symid.errors import SettingError, SymidError
from symid.identification import (
    Constraints,
    Identification,
    Preparation,
    SharedIdentification,
    identify_with_known,
    identify_with_steps,
    measured_signals,
    with_fixed,
)
from symid.identification.signals.axis_logs import LogLike, each_of, log_of, require_changing

if TYPE_CHECKING:
    from symid.output_error import OutputErrorIdentification
    from symid.simulation import ClosedLoop
    from symid.symbolic import DerivedModel

Method: TypeAlias = Literal["wls", "ols", "iv", "oe"]
"""Weighted or ordinary least squares, instrumental variables, output error."""


# `known` and `method` decide on the kind of result.
# The result has another type with values known in each log, and by output error; all settings are described below.
@overload
def identify(
    axis: AnyAxis, logs: LogLike | Sequence[LogLike], *, known: Mapping[str, Sequence[float]], **settings: Any
) -> SharedIdentification: ...


@overload
def identify(
    axis: AnyAxis, logs: LogLike | Sequence[LogLike], *, method: Literal["oe"], **settings: Any
) -> OutputErrorIdentification: ...


@overload
def identify(
    axis: AnyAxis,
    logs: LogLike | Sequence[LogLike],
    *,
    method: Literal["wls", "ols", "iv"] = "wls",
    known: None = None,
    **settings: Any,
) -> Identification: ...


def identify(
    axis: AnyAxis,
    logs: LogLike | Sequence[LogLike],
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
    loop: ClosedLoop | None = None,
    examine: bool = True,
    **columns: Any,
) -> Identification | SharedIdentification | OutputErrorIdentification:
    """Identify the parameters of an axis from one log, or from several jointly.

    Parameters
    ----------
    axis : Axis, str, GeneratedModel or DerivedModel
        A declaration, the name or path of its file, or a model of it. Without a generated module the model is derived
        once in each process.
    logs : Log, path-like, data frame, mapping, or list of these
        Runs of the axis; a frame of pandas, polars or pyarrow, or columns by name, is read as a file is.
    measured : sequence of str, optional
        Sensors to use; by default those of a given model, or else those that all logs hold.
    method : {"wls", "ols", "iv", "oe"}
        Weighted or ordinary least squares, instrumental variables, or output error (maximum likelihood).
    preparation : Preparation, optional
        Filter, differences, decimation, rows; settings not given are chosen from each log. "oe" uses only `late`,
        `held` and `standstill`.
    ddof : int, optional
        Subtracted from the number of rows in the residual's deviation; the number of parameters by default. Only with
        "wls" and "ols".
    nominal : mapping of str to float, optional
        Nominal physical parameters, a start where the inverse map has no closed form.
    fixed : mapping of str to float, optional
        Values of parameters that are known; the others are identified with them.
    bounds : mapping of str to (low, high), or "physical", optional
        Bounds of parameters, None for no bound; "physical" keeps masses, inertias, springs and frictions from being
        negative. Not with "oe".
    prior : mapping of str to (mean, deviation), optional
        Prior value of parameters, with its standard deviation. Not with "oe".
    known : mapping of str to sequence of float, optional
        Values of parameters in each log, in the order of the logs, such as the payload, SI; not with another method.
    loop : ClosedLoop, optional
        The axis under its known controller, for "iv" and "oe"; without it "iv" reads a cascade from the log or tunes
        one, and "oe" predicts each reading from earlier ones.
    examine : bool
        Whether timing and bias are estimated; "oe" always examines.
    **columns
        ``columns``, ``units``, ``gains``, ``layout`` and ``sampling_period`` of files and frames, as in
        `symid.read_axis_log`.

    Returns
    -------
    Identification, OutputErrorIdentification by "oe", or SharedIdentification with `known`
        All results have `physical_parameters`, `covariance`, `standard_deviations` and `notes`. The status
        states what cannot be determined, without an error. It is "contradicted" if the result lies outside the
        intervals of the estimate without `fixed`, `bounds` or `prior`.

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
    _require_no_preparation(columns)
    given = each_of(logs)
    axis = os.fspath(axis) if isinstance(axis, os.PathLike) else axis
    _require_possible(method, {"bounds": bounds, "prior": prior, "ddof": ddof, "known": known, "loop": loop})
    settings: dict[str, Any] = {"preparation": preparation, "nominal": nominal, "examine": examine}
    if known is not None and ddof is not None:
        raise SettingError("known= does not go with ddof=: leave that out")
    by_log = None if known is None else _known_by_log(known, len(given))
    runs, signals = _opened(axis, given, measured, columns)
    if by_log is not None:
        declared = axis_of(axis).with_known(fixed or {})
        return identify_with_known(declared, runs, by_log, signals, bounds=bounds, prior=prior, **settings)
    if fixed:
        settings |= {"measured": signals, "method": method, "ddof": ddof, "bounds": bounds, "prior": prior}
        return _with_fixed(axis_of(axis), runs, fixed, loop, settings)
    if method == "oe":
        from symid.output_error import identify_output_error  # takes 0.3 s to load

        return identify_output_error(
            axis_of(axis),
            signals,
            list(map(in_memory, runs)),
            loop=loop,
            preparation=preparation,
            nominal=nominal,
        )
    model = model_of(axis, signals) if isinstance(axis, (Axis, str)) else _model_given(axis)
    settings["constraints"] = Constraints.of(model, bounds, prior)
    if method == "iv":
        from symid.instrumental import identify_by_instruments  # takes 0.1 s to load
        from symid.simulation import ClosedLoop

        found = identify_by_instruments(
            model, list(map(in_memory, runs)), loop or ClosedLoop(axis_of(axis)), **settings
        )
    else:
        found = identify_with_steps(
            _declaration(axis), model, runs, _feedthrough, method=method, ddof=ddof, **settings
        )
    if isinstance(axis, GeneratedModel):  # its axis is a name, whose declaration may be another one
        return found
    return replace(found, axis=axis_of(axis), runs=tuple(map(first_block, runs)))


def _opened(
    axis: AnyAxis, given: Sequence[LogLike], measured: Sequence[str] | None, columns: dict[str, Any]
) -> tuple[list[AnyLog], tuple[str, ...]]:
    """The logs, those of files and frames read, and the sensors to use: those of a model where one is given."""
    if isinstance(axis, (Axis, str)):
        runs = [log_of(axis_of(axis), log, measured, **columns) for log in given]
        return runs, measured_signals(axis_of(axis), runs, measured)
    model = _model_given(axis)
    # a file or a frame needs the declaration for its units
    runs = [
        log if isinstance(log, Log) and not columns else log_of(axis_of(axis), log, model.measured, **columns)
        for log in given
    ]
    for log in runs:
        require_changing(log, model.highest_derivatives)
    return runs, model.measured


def _feedthrough(axis: Axis, values: Mapping[str, float]) -> Mapping[str, FloatArray]:
    from symid.simulation import feedthrough_of  # takes 0.1 s to load

    return feedthrough_of(axis, values)


def _declaration(axis: AnyAxis) -> Axis | None:
    """The declaration of an axis; None of a generated model whose axis file is elsewhere."""
    try:
        return axis_of(axis)
    except SymidError:
        return None


def _model_given(axis: AnyAxis) -> GeneratedModel:
    """A model given in place of an axis; SettingError for anything else."""
    if not hasattr(axis, "axis"):
        axis_of(axis)
    return compiled(cast("GeneratedModel | DerivedModel", axis))


def _require_no_preparation(settings: Iterable[str]) -> None:
    """Refuse settings of the preparation, also misspelt ones, among those by which files and frames are read."""
    prepared, read = [field.name for field in fields(Preparation)], [*ForeignColumns.__annotations__]
    for name in settings:
        meant = next(iter(difflib.get_close_matches(name, [*read, *prepared], 1)), "")
        if meant in prepared:
            raise SettingError(
                f"{name!r} is a setting of the preparation: give preparation=Preparation({meant}=...)"
            )


def _require_possible(method: str, given: Mapping[str, object]) -> None:
    """SettingError for an unknown method, or a setting that a method does not have."""
    if method not in get_args(Method):
        raise SettingError(f"there is no method {method!r}: choose from {', '.join(get_args(Method))}")
    methods = {
        "bounds": ("wls", "ols", "iv"),
        "prior": ("wls", "ols", "iv"),
        "ddof": ("wls", "ols"),
        "known": ("wls",),
        "loop": ("iv", "oe"),
    }
    for name, possible in methods.items():
        if given[name] is not None and given[name] != {} and method not in possible:
            raise SettingError(
                f"{name} is not possible with method {method!r}: leave it out, or take {' or '.join(possible)}"
            )


def _known_by_log(known: Mapping[str, Sequence[float]], logs: int) -> list[dict[str, float]]:
    """Known values in each log."""
    for name, values in known.items():
        if isinstance(values, (int, float)) or len(values) != logs:
            raise SettingError(
                f"known {name}={values} for {logs} logs: give a list of one value for each log"
            )
    return [{name: float(values[i]) for name, values in known.items()} for i in range(logs)]


def _with_fixed(
    declared: Axis,
    runs: Sequence[AnyLog],
    fixed: Mapping[str, float],
    loop: ClosedLoop | None,
    settings: dict[str, Any],
) -> Identification | OutputErrorIdentification:
    """Identify the parameters that are not fixed, and compare with the estimate of all parameters."""

    def found(axis: Axis, **changed: Any) -> Any:
        return identify(axis, runs, loop=loop and replace(loop, axis=axis), **{**settings, **changed})

    known = found(declared.with_known(fixed))
    if settings["method"] == "oe":
        return cast("OutputErrorIdentification", known)
    return with_fixed(known, found(declared, bounds=None, prior=None))
