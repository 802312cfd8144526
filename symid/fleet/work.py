"""The work on one log in any process: from a path to a row. No log raises an error, whatever it contains."""

import contextlib
import ctypes
import hashlib
import os
import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np
from polars.exceptions import PanicException
from threadpoolctl import ThreadpoolController

from symid.codegen import GeneratedModel
from symid.data import AnyLog, ForeignColumns, Log, columns_in, in_memory
from symid.errors import LogError
from symid.files import irregular
from symid.fleet.batch_settings import ROW_METHODS
from symid.fleet.factors import log_factors
from symid.fleet.kept_factors import packed
from symid.fleet.plan import FleetAxis
from symid.fleet.row import FACTORS, ResultRow, Value, failure_row, finite, time_text, values_and_deviations
from symid.fleet.worker_limits import TooLongError
from symid.identification import (
    Constraints,
    Identification,
    identify_with_steps,
    measured_signals,
    open_axis_log,
)
from symid.instrumental import identify_by_instruments
from symid.simulation import ClosedLoop, feedthrough_of
from symid.text import visible


@dataclass(frozen=True)
class Task:
    """One log of a batch: the path as given, and absolute, since a worker may run in another folder.

    `made` are the keys of rows that earlier runs made of this path, `known` values of parameters in this log alone, SI.
    """

    log: str
    path: str
    made: tuple[str, ...] = ()
    known: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class LogOutcome:
    """Result for a log: a new row, or the key of a row that is still valid."""

    log: str
    row: ResultRow | None
    unchanged: str | None = None


def work(axes: tuple[FleetAxis, ...], task: Task) -> LogOutcome:
    """Row of one log, of the first axis whose signals it holds; of a single axis in any case."""
    begin = time.perf_counter()
    row: dict[str, Value] = {"log": visible(task.log)}
    try:
        row["recorded"] = time_text(os.stat(task.path).st_mtime)
        content = content_of(task.path)
        row["content"] = content
        axis = _axis_of(axes, task.path).with_known(task.known)
        key = hashlib.sha256(f"{content}\n{axis.fingerprint}".encode()).hexdigest()
        if key in task.made:
            return LogOutcome(task.log, None, unchanged=key)
        row |= {"key": key, "axis": axis.axis.name, "method": axis.settings.method}
        row["known"] = ", ".join(f"{name}={value:g}" for name, value in task.known.items()) or None
        _keep_freed_memory()
        with _threads().limit(limits=1):
            row |= _identified(axis, task.path)
    except (Exception, PanicException) as error:  # noqa: BLE001  any failure of a log becomes a row
        row |= failure_row(task.path, error)
        if isinstance(error, (MemoryError, OSError, TooLongError)):
            row["key"] = None  # another night may do better
    row |= {"seconds": time.perf_counter() - begin, "finished": time_text(time.time())}
    return LogOutcome(task.log, row)


def killed(task: Task) -> LogOutcome:
    """Row of a log that killed the process that worked on it, twice; no key, so that it is tried again."""
    message = "its worker died twice, for lack of memory or time: use fewer `jobs`, more `seconds`, or a shorter log"
    row = {"log": visible(task.log), "status": "failed", "message": message}
    return LogOutcome(task.log, {**row, "finished": time_text(time.time())})


def content_of(path: str) -> str:
    """SHA-256 of the bytes of a file, read in pieces; LogError for a pipe or a device, which may have no end."""
    if kind := irregular(path):
        if kind == "a folder":
            os.listdir(path)  # a folder that could not be read stands for its files
        raise LogError(f"is {kind}: give a regular file")
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


@lru_cache(maxsize=1)
def _threads() -> ThreadpoolController:
    return ThreadpoolController()  # looks through all loaded libraries: once a process


_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3  # of malloc.h
_KEPT = 128 * 2**20  # bytes


@lru_cache(maxsize=1)
def _keep_freed_memory() -> None:
    """Make glibc keep freed memory, which it would return to the system after each array and then request again.

    Its threshold is 128 kB at first; it adapts, but not in a worker of Dask, which sets it. Other C libraries have no
    mallopt.
    """
    with contextlib.suppress(AttributeError, OSError, TypeError):
        mallopt = ctypes.CDLL(None).mallopt
        mallopt(_TRIM_THRESHOLD, _KEPT)
        mallopt(_MMAP_THRESHOLD, _KEPT // 4)


def _axis_of(axes: tuple[FleetAxis, ...], log: str) -> FleetAxis:
    if len(axes) == 1:
        return axes[0]
    columns = columns_in(log, axes[0].settings.layout)
    for axis in axes:
        if axis.is_held_in(columns):
            return axis
    names = ", ".join(axis.axis.name for axis in axes)
    raise LogError(
        f"does not hold the force and a sensor of any of {names}: name columns with `columns` SIGNAL=NAME"
    )


def _identified(axis: FleetAxis, path: str) -> dict[str, Value]:
    """Columns of the identification, and of the diagnosis if there is to be one."""
    settings, declared = axis.settings, axis.axis
    in_blocks = settings.method in ROW_METHODS
    foreign: Any = {name: getattr(settings, name) for name in ForeignColumns.__annotations__}
    log = open_axis_log(
        declared, path, measured=settings.measured, memory=settings.memory, whole=not in_blocks, **foreign
    )
    measured = measured_signals(declared, [log], settings.measured)
    row: dict[str, Value] = {"samples": log.n_samples, "measured": ",".join(measured)}
    model = axis.model(measured)
    if settings.method == "oe":
        row |= _by_output_error(axis, model, in_memory(log))
    else:
        identification = _by_regression(axis, model, log)
        row |= _columns_of(identification)
        row |= {FACTORS: packed(log_factors(identification))} if settings.joint else {}
    if settings.diagnose:
        row |= _diagnosed(axis, in_memory(log), str(row["message"] or ""))
    return row


def _by_regression(axis: FleetAxis, model: GeneratedModel, log: AnyLog) -> Identification:
    settings = axis.settings
    given: Any = {
        "preparation": settings.preparation,
        "nominal": settings.nominal,
        "constraints": Constraints.of(model, dict(settings.bounds), dict(settings.prior)),
        "examine": settings.examine,
    }
    if settings.method == "iv":
        loop = ClosedLoop.with_gains(axis.axis, settings.controller, settings.rate_hz)
        return identify_by_instruments(model, in_memory(log), loop, **given)
    return identify_with_steps(
        axis.axis, model, [log], feedthrough_of, method=settings.method, ddof=settings.ddof, **given
    )


def _columns_of(identification: Identification) -> dict[str, Value]:
    """Deviations are those that `symid identify` prints, of correlation, scatter between segments and bias.

    Effects that the model lacks move all logs of a machine alike: they have a separate column, relative to the values.
    """
    wide, identification = identification, replace(identification, discrepancies=())
    prepared, residual = identification.observations[0].preparation, identification.residuals[0]
    row: dict[str, Value] = {
        "status": identification.status,
        "message": identification.message,
        "cutoff_hz": prepared.cutoff_hz,
        "order": prepared.order,
        "decimation": prepared.decimation,
        "condition_number": finite(identification.fit.condition_number),
        "residual_rms": finite(residual.rms),
        "residual_relative": finite(residual.relative),
        "notes": "; ".join(identification.notes) or None,
    }
    if identification.timing is not None:
        timing = identification.timing
        row |= {
            "late_signal": timing.signal,
            "late_s": finite(timing.late),
            "late_std_s": finite(timing.deviation),
        }
    bias = identification.physical_bias or identification.bias
    if bias is not None:
        values = (
            identification.physical[0].parameters
            if identification.physical
            else identification.fit.parameters
        )
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.abs(bias.total / values)
        row["largest_bias"] = finite(np.nanmax(share, initial=0.0))
    row |= values_and_deviations(identification.minimal_parameters, identification.standard_deviations)
    if identification.physical:
        row |= values_and_deviations(identification.physical_parameters, identification.physical_deviations)
        if wide.discrepancies:
            lacking = np.sqrt(wide.physical_deviations**2 - identification.physical_deviations**2)
            with np.errstate(divide="ignore", invalid="ignore"):
                share = lacking / np.abs(identification.physical[0].parameters)
            row["largest_discrepancy"] = finite(np.nanmax(share, initial=0.0))
    return row


def _by_output_error(axis: FleetAxis, model: GeneratedModel, log: Log) -> dict[str, Value]:
    """Columns of maximum likelihood; the residual is that of the one-step predictions of the first sensor."""
    from symid.output_error import identify_output_error  # takes 0.2 s to load

    settings, declared = axis.settings, axis.axis
    loop = None
    if settings.controller:
        loop = ClosedLoop.with_gains(declared, settings.controller, settings.rate_hz)
    given: Any = {"preparation": settings.preparation, "nominal": settings.nominal}
    identification = identify_output_error(declared, model, log, loop=loop, **given)
    row: dict[str, Value] = {
        "status": identification.status,
        "message": identification.message,
        "decimation": 1,
    }
    row["notes"] = "; ".join(identification.notes) or None
    if identification.fit is None:
        return row
    residual = identification.predictions[0].residuals[0]
    row |= {
        "condition_number": finite(identification.fit.linear.condition_number),
        "residual_rms": finite(residual.rms),
        "residual_relative": finite(residual.relative),
    }
    row |= values_and_deviations(identification.minimal_parameters, identification.standard_deviations)
    return row | values_and_deviations(identification.physical_parameters, identification.physical_deviations)


def _diagnosed(axis: FleetAxis, log: Log, message: str) -> dict[str, Value]:
    """Columns of the diagnosis; where it fails, the reason is added to the message."""
    from symid.diagnosis import diagnose  # takes 0.3 s to load

    settings, prepared = axis.settings, axis.settings.preparation
    try:
        diagnosis = diagnose(axis.axis, log, nominal=settings.nominal, late=prepared.late, held=prepared.held)
    except (Exception, PanicException) as error:  # noqa: BLE001  the identification stands whatever happens here
        cause = str(failure_row(log.source, error)["message"])
        return {"message": "; ".join(part for part in (message, f"no diagnosis: {cause}") if part)}
    row: dict[str, Value] = {
        "verdict": diagnosis.verdict,
        "closed_fraction": finite(diagnosis.gap.closed_fraction),
        "gap_reidentified": finite(diagnosis.gap.reidentified.rms),
        "gap_explained": finite(diagnosis.gap.explained.rms),
        "gap_floor": finite(diagnosis.gap.noise_floor.rms),
        "sentence": diagnosis.sentence,
    }
    if diagnosis.effects:
        first = diagnosis.effects[0]
        row |= {"effect": first.effect, "at": first.at, "probability": finite(first.probability)}
    return row
