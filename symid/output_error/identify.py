"""`identify_output_error`: from logs of an axis to its parameters by maximum likelihood on the sampled axis."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from threadpoolctl import threadpool_limits

from symid.axis import Axis
from symid.codegen import GeneratedModel
from symid.data import Log
from symid.errors import SettingError
from symid.identification import Preparation, identify
from symid.output_error.estimate import Fit, fit_runs, natural_frequencies
from symid.output_error.prediction import OutputErrorPrediction, prediction_of
from symid.output_error.result import OutputErrorIdentification, Status
from symid.output_error.run import Course, Run, run_of
from symid.output_error.starts import rigid_start, spread
from symid.simulation import ForwardDynamics, forward_dynamics

_VELOCITY_BAND = 0.2
"""Of the sampling frequency: cutoff for the velocities whose signs friction follows."""
_VAGUE = 50.0
_CORRELATED = 1.5


def identify_output_error(
    axis: Axis,
    model: GeneratedModel,
    logs: Log | Sequence[Log],
    *,
    held: bool | None = None,
    preparation: Preparation | None = None,
    nominal: Mapping[str, float] | None = None,
) -> OutputErrorIdentification:
    """Identify an axis without differentiating its signals: simulate from sample to sample, compare, correct.

    Parameters
    ----------
    axis : Axis
        The declared axis.
    model : GeneratedModel
        For the sensors to use.
    logs : Log or sequence of Log
        Runs of one axis.
    held : bool, optional
        Whether the force is held from each sample to the next. If not given, the declaration of the drive, and if that
        is silent, the likelihood decides between a held force and a smooth one whose timing is estimated.
    preparation : Preparation, optional
        `late` and `standstill` are respected; a `late` of the force fixes its timing. There is nothing else to choose.
    nominal : mapping of str to float, optional
        Nominal physical parameters to begin with; otherwise those of weighted least squares, and rough ones.

    Returns
    -------
    OutputErrorIdentification
        What cannot be determined is said by its status and notes.

    Raises
    ------
    LogError, SettingError
        If a log lacks a signal, or a setting is not possible.

    Examples
    --------
    >>> from symid.axis import load_axis
    >>> from symid.codegen import load_generated
    >>> from symid.simulation import chirp, plant_of, simulate, tuned_cascade
    >>> axis, truth = load_axis("rigid_1m"), {"M": 5.0, "Fv": 3.0, "Fs": 0.0}
    >>> reference = chirp(1.0, 5.0, 4.0, 0.01, sampling_period=4e-3)
    >>> log = simulate(axis, truth, reference, tuned_cascade(plant_of(axis, truth), "q")).log
    >>> found = identify_output_error(axis, load_generated("rigid_1m"), log, held=True)
    >>> {name: round(value, 3) for name, value in found.physical_parameters.items() if name != "Fs"}
    {'M': 5.0, 'Fv': 3.0}
    """
    runs = (logs,) if isinstance(logs, Log) else tuple(logs)
    if not runs:
        raise SettingError("there is no log: give at least one")
    prepared, dynamics = preparation or Preparation(), forward_dynamics(axis)
    force = axis.drive.signal
    declared = held if held is not None else axis.drive.held or (False if force in prepared.late else None)
    courses: tuple[Course, ...] = (
        ("smooth", "held") if declared is None else ("held" if declared else "smooth",)
    )
    with threadpool_limits(1):
        starts = _starts(model, dynamics, runs, _for_least_squares(prepared, force, runs, declared), nominal)
        fits: list[tuple[Fit, Course]] = []
        for course in courses:
            free_timing = declared is None and course == "smooth"
            known = [*starts, *(fit.search.parameters for fit, _ in fits)]
            fit = _fitted(model, dynamics, runs, course, prepared, known, free_timing=free_timing)
            fits += [(fit, course)] if fit else []
    fit, course = min(fits, key=lambda pair: pair[0].cost, default=(None, courses[0]))
    found = OutputErrorIdentification(
        axis=axis,
        model=model,
        logs=runs,
        preparation=prepared,
        fit=fit,
        course=course,
        timing_estimated=declared is None and course == "smooth",
        status="ok",
        message="",
        notes=tuple(note for log in runs for note in log.notes),
    )
    status, message = _verdict(found)
    return replace(found, status=status, message=message, notes=(*found.notes, *_remarks(found)))


def _for_least_squares(
    preparation: Preparation, force: str, logs: Sequence[Log], held: bool | None
) -> Preparation:
    """Settings of least squares, to which a held force is one that acts half a sample later than it is recorded."""
    if not held:
        return preparation
    late = preparation.late.get(force, 0.0) - logs[0].sampling_period / 2
    return replace(preparation, late={**preparation.late, force: late})


def _starts(
    model: GeneratedModel,
    dynamics: ForwardDynamics,
    logs: Sequence[Log],
    preparation: Preparation,
    nominal: Mapping[str, float] | None,
) -> list[dict[str, float]]:
    """Parameters to begin with: nominal ones, else those of least squares if they are possible, else rough ones."""
    known = dict(nominal) if nominal is not None else _least_squares_start(model, logs, preparation)
    positive = dynamics.parameters_of("mass") | dynamics.parameters_of("stiffness")
    if known is None or not all(known[name] > 0 for name in positive):
        known = rigid_start(model, dynamics, logs)
    return spread(dynamics, known, logs[0].sampling_frequency)


def _least_squares_start(
    model: GeneratedModel, logs: Sequence[Log], preparation: Preparation
) -> dict[str, float] | None:
    try:
        found = identify(model, logs, preparation=preparation, examine=False).physical_parameters
    except SettingError:
        return None
    return {name: value if math.isfinite(value) else 0.0 for name, value in found.items()} or None


def _fitted(
    model: GeneratedModel,
    dynamics: ForwardDynamics,
    logs: Sequence[Log],
    course: Course,
    preparation: Preparation,
    starts: Sequence[Mapping[str, float]],
    *,
    free_timing: bool,
) -> Fit | None:
    runs = [_run(model, dynamics, log, course, preparation) for log in logs]
    try:
        return fit_runs(model, dynamics, runs, starts, free_timing=free_timing)
    except np.linalg.LinAlgError:
        return None


def _run(
    model: GeneratedModel, dynamics: ForwardDynamics, log: Log, course: Course, preparation: Preparation
) -> Run:
    return run_of(
        dynamics,
        log,
        model.measured,
        course,
        cutoff_hz=_VELOCITY_BAND * log.sampling_frequency,
        late=preparation.late.get(dynamics.axis.drive.signal, 0.0),
        standstill=preparation.standstill,
    )


def predict_output_error(found: OutputErrorIdentification, log: Log) -> OutputErrorPrediction:
    """Predict the readings of another log with identified parameters, noise and timing.

    Parameters
    ----------
    found : OutputErrorIdentification
        What `identify_output_error` returned; it must hold an estimate.
    log : Log
        A log that took no part in it.

    Raises
    ------
    LogError, SettingError
        If the log lacks a signal, or there is no estimate.
    """
    if found.fit is None:
        raise SettingError(f"there are no parameters to predict with: {found.message}")
    search = found.fit.search
    timing = {found.axis.drive.signal: found.late}
    late = replace(found.preparation, late={**found.preparation.late, **timing})
    run = _run(found.model, search.dynamics, log, found.course, late)
    return prediction_of(log, search.applied_to(run), search, search.nuisance[0])


def _verdict(found: OutputErrorIdentification) -> tuple[Status, str]:
    if found.fit is None:
        return (
            "no_start",
            "no start was possible: give nominal values with --nominal P.json, or measure a position",
        )
    minimum = found.fit.search.minimum
    if minimum is None or not minimum.converged:
        return (
            "not_converged",
            "the iterations did not come to rest: give nominal values with --nominal P.json",
        )
    deviations = np.sqrt(np.diag(found.physical_covariance(corrected=True)))
    below = [
        name
        for (name, value), std in zip(found.physical_parameters.items(), deviations, strict=True)
        if value < -3 * np.nan_to_num(std) and name not in found.model.signed
    ]
    if below:
        return (
            "not_physical",
            f"{', '.join(below)} came out negative: the model, the timing or the log does not fit",
        )
    return "ok", ""


def _remarks(found: OutputErrorIdentification) -> tuple[str, ...]:
    """What the user should know about the estimate."""
    if found.fit is None:
        return ()
    remarks = [_course_remark(found)]
    covariance = found.physical_covariance(corrected=True)
    values = np.array(list(found.physical_parameters.values()))
    with np.errstate(invalid="ignore", divide="ignore"):
        relative = 100 * np.sqrt(np.diag(covariance)) / np.abs(values)
    vague = [n for n, r in zip(found.model.physical_units, relative, strict=True) if r > _VAGUE]
    if vague:
        remarks.append(
            f"the log hardly determines {', '.join(vague)}: the standard deviation exceeds {_VAGUE:g} %"
        )
    fit = found.fit
    inflation = np.sqrt(fit.linear.rows[0] / max(fit.correlated.effective_samples, 1.0))
    if inflation > _CORRELATED:
        remarks.append(
            "the innovations are correlated, as if the model or the timing did not fit quite: "
            f"{fit.linear.rows[0]} of them are worth {fit.correlated.effective_samples:.0f}"
        )
    highest = max(natural_frequencies(fit.search.dynamics, fit.search.parameters), default=0.0)
    if highest:
        rate = found.logs[0].sampling_frequency
        remarks.append(
            f"the highest mode, {highest:.3g} Hz, is taken to lie below half the sampling frequency of {rate:g} Hz"
        )
    return tuple(remarks)


def _course_remark(found: OutputErrorIdentification) -> str:
    force = found.model.force
    if found.course == "held":
        return f"{force} is held from each sample to the next"
    if not found.timing_estimated:
        return f"{force} runs smoothly between its samples"
    samples = found.late / found.logs[0].sampling_period
    how = "later" if samples < 0 else "earlier"
    return (
        f"{force} runs smoothly between its samples and acts {abs(samples):.2f} samples {how} than recorded"
    )
