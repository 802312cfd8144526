"""`identify` of any axis from any logs."""

from __future__ import annotations

import difflib
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields
from typing import TYPE_CHECKING, Any, Literal, cast, overload

from symid.axis import AnyAxis, Axis, axis_of
from symid.codegen import GeneratedModel, compiled
from symid.data import AnyLog, ForeignColumns, Log
from symid.errors import SettingError
from symid.identification import (
    Identification,
    IdentificationResult,
    Preparation,
    SharedIdentification,
    identify_with_known,
    measured_signals,
)
from symid.identification.signals import LogLike, each_of, log_of, require_changing
from symid.verbs.methods import (
    IdentificationMethod,
    IdentificationProblem,
    Result_co,
    WeightedLeastSquares,
    method_of,
)

if TYPE_CHECKING:
    from symid.output_error import OutputErrorIdentification
    from symid.simulation import ClosedLoop
    from symid.symbolic import DerivedModel


# `known` and `method` decide on the type of the result; all settings are described below.
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
    method: IdentificationMethod[Result_co],
    known: None = None,
    **settings: Any,
) -> Result_co: ...


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
    method: Literal["wls", "ols", "iv", "oe"] | IdentificationMethod[Any] = "wls",
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
) -> IdentificationResult:
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
    method : {"wls", "ols", "iv", "oe"}, or a method
        Weighted or ordinary least squares, instrumental variables, or output error (maximum likelihood); by name with
        the settings `ddof`, `bounds`, `prior` and `loop` here, or with its own as `WeightedLeastSquares`,
        `OrdinaryLeastSquares`, `InstrumentalVariables` or `OutputError`.
    preparation : Preparation, optional
        Filter, differences, decimation, rows; settings not given are chosen from each log. "oe" uses only `late`,
        `held` and `standstill`.
    ddof, bounds, prior, loop : optional
        Settings of the methods that have them, as described there.
    nominal : mapping of str to float, optional
        Nominal physical parameters, a start where the inverse map has no closed form.
    fixed : mapping of str to float, optional
        Values of parameters that are known; the others are identified with them.
    known : mapping of str to sequence of float, optional
        Values of parameters in each log, in the order of the logs, such as the payload, SI; with "wls".
    examine : bool
        Whether timing and bias are estimated; "oe" always examines.
    **columns
        ``columns``, ``units``, ``gains``, ``layout`` and ``sampling_period`` of files and frames, as in
        `symid.read_axis_log`.

    Returns
    -------
    Identification, OutputErrorIdentification by "oe", or SharedIdentification with `known`
        Each is an `IdentificationResult`. The status states what cannot be determined, without an error. It is
        "contradicted" if the result lies outside the intervals of the estimate without `fixed`, `bounds` or `prior`.

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
    chosen, given = _chosen(method, ddof=ddof, bounds=bounds, prior=prior, loop=loop), each_of(logs)
    by_log = None if known is None else _by_log(known, chosen, len(given))
    axis = os.fspath(axis) if isinstance(axis, os.PathLike) else axis
    runs, signals = _opened(axis, given, measured, columns)
    problem = IdentificationProblem(axis, runs, signals, fixed or {}, preparation, nominal, examine)
    if by_log is None:
        result: IdentificationResult = chosen.solve(problem)
        return result
    return identify_with_known(
        problem.declared, runs, by_log, signals, bounds=chosen.bounds, prior=chosen.prior, **problem.settings
    )


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


def _chosen(method: IdentificationMethod[Any] | str, **settings: object) -> Any:
    """The method given as such, or by its short name and its settings."""
    if isinstance(method, str):
        return method_of(method, settings)
    if given := [name for name, value in settings.items() if value is not None and value != {}]:
        own = ", ".join(f"{name}=..." for name in given)
        raise SettingError(
            f"{' and '.join(given)} beside {method}, which holds its settings: give {type(method).__name__}({own})"
        )
    return method


def _by_log(
    known: Mapping[str, Sequence[float]], method: IdentificationMethod[Any], logs: int
) -> list[dict[str, float]]:
    """Values known in each log, by weighted least squares alone."""
    if type(method) is not WeightedLeastSquares or method.ddof is not None:
        raise SettingError(f"known is not possible with {method}: leave it out, or take wls without ddof")
    for name, values in known.items():
        if isinstance(values, (int, float)) or len(values) != logs:
            raise SettingError(
                f"known {name}={values} for {logs} logs: give a list of one value for each log"
            )
    return [{name: float(values[i]) for name, values in known.items()} for i in range(logs)]
