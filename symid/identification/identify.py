"""Identification by least squares: the steps from logs of an axis to its parameters.

Each log is prepared and sampled (`observe`), all of them together are solved by weighted least squares in which every
equation of every log has its own weight (`estimate`), the deviations are corrected for the correlation of the
residual (`corrected_covariance`), and the minimal parameters are mapped to physical ones (`physical_estimates`).
Errors that no deviation shows are examined last: a force recorded at another time than it acts (`delays_of`),
noise in W and differences that only approximate derivatives (`Correction`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from symid.arrays import FloatArray
from symid.codegen import GeneratedModel, compiled
from symid.data import AnyLog, Log, LongLog, in_memory
from symid.errors import SettingError
from symid.estimation import (
    LeastSquares,
    Method,
    corrected_covariance_of_blocks,
    estimate,
)
from symid.identification.criteria import CRITERIA
from symid.identification.cutoff import CutoffTrial, Estimation, disagreements_of, least_uncertain
from symid.identification.delays.clock_drift import drift_by_rows, drift_within_a_row
from symid.identification.delays.timing import delays_of, likeliest
from symid.identification.deviations.bias import Bias, Correction, bias_of_instruments
from symid.identification.deviations.discrepancy import discrepancies_of
from symid.identification.deviations.explained import explained_by_instruments
from symid.identification.deviations.log_agreement import LogEstimate, disagreement_between
from symid.identification.deviations.stability import greatest_change, scatter
from symid.identification.deviations.whitened import Segment, segments
from symid.identification.faults.examined_faults import faults_of
from symid.identification.faults.lagging import lag_of
from symid.identification.faults.poor_fit import unexplained
from symid.identification.faults.smoothing import slowly_updated
from symid.identification.parameters.constrained import physical_of
from symid.identification.parameters.constraints import Constraints
from symid.identification.results.contradiction import with_constraint_check
from symid.identification.results.identification_result import Identification, best_covariance
from symid.identification.results.reliability import with_discrepancies, with_faults
from symid.identification.results.status import OPEN, identification_status
from symid.identification.rows.excerpts import Excerpt, blocks_of, excerpts
from symid.identification.rows.observation import Observation
from symid.identification.rows.row_blocks import Run, blocks_of_runs
from symid.identification.rows.settings import Preparation, notes_on_declared

if TYPE_CHECKING:
    from symid.symbolic import DerivedModel


def identify_by_least_squares(
    model: GeneratedModel | DerivedModel,
    logs: AnyLog | Sequence[AnyLog],
    *,
    method: Method = "wls",
    preparation: Preparation | None = None,
    ddof: int | None = None,
    nominal: Mapping[str, float] | None = None,
    constraints: Constraints | None = None,
    examine: bool | Literal["bias"] = True,
) -> Identification:
    """Identify the parameters of an axis from one log, or from several of the same axis jointly.

    Parameters
    ----------
    model : GeneratedModel or DerivedModel
        Regressor and maps, from `symid.load_generated` or `symid.derive`.
    logs : Log, LongLog or sequence of these
        Runs of one axis; every equation of every log gets its own weight. A long log is identified in blocks.
    method : {"wls", "ols"}
        Weighted [24]-[30] or ordinary [20]-[23] least squares.
    preparation : Preparation, optional
        Filter, differences, decimation, rows; what is left open is chosen from each log.
    ddof : int, optional
        Subtracted from the number of rows in the residual's deviation; the number of parameters by default.
    nominal : mapping of str to float, optional
        Nominal physical parameters, a start where the inverse map has no closed form.
    constraints : Constraints, optional
        Bounds and priors of physical parameters.
    examine : bool or "bias"
        Whether bias, timing and faults are estimated, which takes up to as long again as the rest for a short log; or
        bias alone, with what widens the deviations.

    Returns
    -------
    Identification
        The status states what cannot be determined; this raises no error.

    Raises
    ------
    LogError, SettingError
        If a log does not have a signal, or a setting is not possible.

    Examples
    --------
    >>> import numpy as np
    >>> from symid.codegen import load_generated
    >>> t = np.arange(4000) / 1000
    >>> q, a = np.sin(9 * t), -81 * np.sin(9 * t)
    >>> F = 5 * a + 2 * np.sign(np.cos(9 * t)) + 9 * np.cos(9 * t)
    >>> log = Log.from_arrays({"q": q, "F": F}, sampling_period=1e-3)
    >>> found = identify_by_least_squares(load_generated("rigid_1m"), log).physical_parameters
    >>> round(found["M"], 2), round(found["Fv"], 1), round(found["Fs"], 1)
    (5.0, 1.0, 2.0)
    """
    model = compiled(model)
    every = (logs,) if isinstance(logs, Log | LongLog) else tuple(logs)
    _require_usable(model, every)
    estimation = Estimation(model, every, preparation or Preparation(), method, ddof)
    parts_of = estimation.parts_of
    found_at = partial(
        _found_at,
        model,
        every,
        nominal=nominal,
        constraints=constraints,
        parts_of=parts_of if examine else None,
    )
    # The first cutoff comes from spectra; another replaces it where the estimate is less uncertain with that.
    trial = estimation.trial()
    if trial.fit.status == "too_few_rows":
        trial = estimation.widest(trial)
    if not examine or trial.fit.status != "ok":
        return with_constraint_check(found_at(trial))
    found, tried = least_uncertain(estimation, trial, found_at)
    if examine == "bias" or found.fit.status != "ok":
        return with_constraint_check(found)
    checked = with_checks(found, parts_of(found.observations), every, tried=tried)
    # what a joint residual seems to show is unsure where the logs differ
    several = len(every) > 1 and checked.status in ("ok", "poor_fit")
    apart = _disagreement_of_logs(estimation, checked, constraints) if several else ""
    return replace(checked, status="poor_fit", message=apart) if apart else checked


def _require_usable(model: GeneratedModel, logs: Sequence[AnyLog]) -> None:
    """SettingError if there is no log, one is too short, or several have parameters of their own."""
    if not logs:
        raise SettingError("there is no log: give at least one")
    if short := next((log for log in logs if log.n_samples < 3), None):
        raise SettingError(
            f"{short.source} has {short.n_samples} samples, an acceleration needs 3: record longer"
        )
    if len(logs) > 1 and model.per_log:
        own = ", ".join(model.per_log)
        raise SettingError(
            f"axis {model.axis!r} has a parameter of each log ({own}): identify each log alone"
        )


def _found_at(
    model: GeneratedModel, logs: Sequence[AnyLog], trial: CutoffTrial, **settings: Any
) -> Identification:
    """Identification of the rows and the estimate at a cutoff; settings as in `found_from`."""
    return found_from(model, logs, trial.runs, trial.fit, **settings)


def _disagreement_of_logs(
    estimation: Estimation, joint: Identification, constraints: Constraints | None
) -> str:
    """Statement on a parameter of one log that differs from that of the others; empty without one."""
    model, alone = estimation.model, list[LogEstimate]()
    for log, seen in zip(estimation.logs, joint.observations, strict=True):
        run = Run.again(model, log, seen)  # the rows of the joint estimate hold what each log says alone
        trial = CutoffTrial((run,), estimate(run.factors(), estimation.method, estimation.ddof))
        one = _found_at(
            model,
            (log,),
            trial,
            nominal=joint.physical_parameters,
            constraints=constraints,
            parts_of=partial(excerpts, model, (log,)),
        )
        if one.physical:
            alone.append(LogEstimate(log.source, one.physical[0].parameters, one.physical_deviations))
    return disagreement_between(list(model.physical_units), alone)


def found_from(
    model: GeneratedModel,
    logs: Sequence[AnyLog],
    runs: Sequence[Run],
    fit: LeastSquares,
    *,
    instruments: tuple[FloatArray, ...] | None = None,
    nominal: Mapping[str, float] | None = None,
    constraints: Constraints | None = None,
    parts_of: Callable[[tuple[Observation, ...]], tuple[Excerpt, ...]] | None = None,
) -> Identification:
    """Identification of an estimate: its corrected covariance, physical parameters and status.

    `runs` are the rows of each log. An estimate by instrumental variables has `instruments`, for each log an array of
    the shape of W. On the excerpts `parts_of` the observations, the bias by noise is estimated and taken off, and what
    widens the deviations is added.
    """
    observations = tuple(run.observation for run in runs)
    by_instruments = None if instruments is None else blocks_of(observations, instruments)
    correlated = corrected_covariance_of_blocks(lambda: by_instruments or blocks_of_runs(runs), fit)
    bias: Bias | None = None
    sums, spread = tuple[Segment, ...](), None
    if parts_of and fit.status == "ok":
        # Noise in W attenuates the parameters. The expected error is taken off, and what is uncertain in it widens the
        # covariances: that of the correlated residual, and that of the scatter between segments.
        parts = parts_of(observations)
        correction = Correction.of(model, parts, fit)
        bias = correction.bias
        sums = segments(runs, fit)
        spread = correction.grown(scatter(sums, fit))
        fit, correlated = correction.applied(fit, correlated)
    wide = best_covariance(fit, correlated)
    physical = physical_of(model, fit.parameters, wide, nominal, constraints) if fit.status == "ok" else ()
    late, hold = observations[0].preparation.late, logs[0].sampling_period / 2
    notes = notes_on_declared(model.delays, late, model.passed_over, hold=hold)
    found = Identification(
        model=model,
        logs=tuple(log.source for log in logs),
        sampling_period=logs[0].sampling_period,
        observations=observations,
        fit=fit,
        correlated=correlated,
        physical=physical,
        status="ok",
        message="",
        notes=(*(note for log in logs for note in log.notes), *notes),
        bias=bias,
        segments=sums,
        scatter=spread,
    )
    return _judged(found, logs, has_start=nominal is not None)


def _judged(found: Identification, logs: Sequence[AnyLog], *, has_start: bool) -> Identification:
    """The identification with the status of its estimate, before any check."""
    per_log = np.reshape(found.fit.rows, (len(logs), -1)).sum(axis=1)
    if not per_log.all() and per_log.any():
        unused = ", ".join(log.source for log, rows in zip(logs, per_log, strict=True) if not rows)
        message = f"no row of {unused} is left: check its signals, or leave it out"
        return replace(found, status="too_few_rows", message=message)
    deviations = found.physical_deviations if found.physical else None
    status, message = identification_status(
        found.model, found.fit, found.physical, found.correlated, has_start=has_start, deviations=deviations
    )
    if status == "too_few_rows" and (slow := slowly_updated(found.model, logs)):
        message = f"{message.partition(': ')[0]}: {slow}"
    return replace(found, status=status, message=message)


def with_checks(
    found: Identification,
    parts: tuple[Excerpt, ...],
    logs: Sequence[AnyLog],
    instruments: tuple[FloatArray, ...] | None = None,
    tried: Sequence[Identification] = (),
) -> Identification:
    """The identification after checks on excerpts, and against those tried at other cutoffs; else as `found_from`."""
    model, fit, bias, sums = found.model, found.fit, found.bias, found.segments
    if bias is not None and bias.removed is not None:
        fit = replace(fit, solution=fit.solution + bias.removed)  # its residual is orthogonal to the columns
    own, spread = fit, found.scatter
    if instruments is not None:
        bias = bias_of_instruments(model, list(map(in_memory, logs)), found.observations, fit, instruments)
        whole, own = explained_by_instruments(found.observations, instruments, fit)
        sums = segments([Run.again(model, *pair) for pair in zip(logs, whole, strict=True)], own)
        spread = scatter(sums, own)
    # Signals that are late by a constant time, by one that grows along the log, or by the lag of a filter
    delays = delays_of(model, parts, fit)
    examined = replace(found, timing=likeliest(delays), bias=bias, scatter=spread)
    noise_alone = not np.any(unexplained(model, parts, fit, CRITERIA.noise_alone))
    drifting = [one for one in delays if not (noise_alone and one.is_force)]
    drift = drift_by_rows(parts, fit, model.forces) or lag_of(examined, parts, fit)
    drift = drift or drift_within_a_row(parts, fit, drifting)
    # Faults of channels, of parts of the logs and of the structure; then what no fault explains widens the deviations
    change = greatest_change(sums, own.solution, own.rank.inverse_root)
    faults = faults_of(examined, fit, parts, change, drift, noise_alone=noise_alone)
    checked = with_faults(examined, faults)
    if checked.status in OPEN and checked.fault is None:
        seen = discrepancies_of(model, parts, fit, found.fit, noise_alone=noise_alone)
        checked = with_discrepancies(checked, (*seen, *disagreements_of(found, tried)))
    return with_constraint_check(checked)
