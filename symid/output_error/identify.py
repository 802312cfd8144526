"""`identify_output_error`: from logs of an axis to its parameters by maximum likelihood on the sampled axis."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from threadpoolctl import threadpool_limits

from symid.arrays import FloatArray
from symid.axis import Axis
from symid.codegen import GeneratedModel
from symid.data import Log
from symid.errors import SettingError
from symid.identification import Preparation, identify
from symid.identification.physical import jacobian
from symid.output_error.estimate import Fit, fit_runs, natural_frequencies
from symid.output_error.run import Course, run_of
from symid.output_error.starts import rigid_start, spread
from symid.simulation import ForwardDynamics, forward_dynamics

Status = Literal["ok", "no_start", "not_converged", "not_physical"]

_VELOCITY_BAND = 0.2
"""Of the sampling frequency: cutoff for the velocities whose signs friction follows."""
_VAGUE = 50.0
_CORRELATED = 1.5


@dataclass(frozen=True, eq=False)
class OutputErrorIdentification:
    """Parameters of an axis by maximum likelihood on the exactly sampled axis.

    Parameters
    ----------
    model : GeneratedModel
        Names, units and maps of the parameters.
    logs : tuple of Log
        What they were identified from.
    fit : Fit or None
        None if there was no start at which the axis could be evaluated.
    course : {"held", "smooth"}
        Course of the force between samples.
    timing_estimated : bool
        Whether the time by which the force is recorded late was estimated.
    status : str
        "ok", or what keeps the result from being complete.
    message : str
        What the status means here and what to do.
    notes : tuple of str
        What the user should know.
    """

    model: GeneratedModel
    logs: tuple[Log, ...]
    fit: Fit | None
    course: Course
    timing_estimated: bool
    status: Status
    message: str
    notes: tuple[str, ...]

    @property
    def physical_parameters(self) -> dict[str, float]:
        """Physical parameters by name, SI; nan for those that the sensors do not see."""
        if self.fit is None:
            return {}
        values = self.fit.search.parameters
        return {
            name: values[name] if name in self.fit.search.seen else math.nan
            for name in self.model.physical_units
        }

    @property
    def minimal_parameters(self) -> dict[str, float]:
        """Minimal parameters by name, SI."""
        if self.fit is None:
            return {}
        values = self.model.minimal_parameters(*self._all_values)
        return dict(zip(self.model.minimal_units, map(float, values), strict=True))

    @property
    def noise(self) -> dict[str, float]:
        """Standard deviations of the noise of the force and of each reading in the first log, SI."""
        return {} if self.fit is None else self.fit.noise

    @property
    def late(self) -> float:
        """Seconds by which the force of the first log is taken to be recorded late."""
        if self.fit is None:
            return 0.0
        run = self.fit.search.errors[0].run
        return run.late * run.period

    def physical_covariance(self, *, corrected: bool) -> FloatArray:
        """Covariance of the physical parameters, classical or corrected for correlation, (n_physical, n_physical)."""
        names = list(self.model.physical_units)
        whole = np.full((len(names), len(names)), np.nan)
        if self.fit is not None:
            places = [names.index(name) for name in self.fit.search.seen]
            covariance = self.fit.correlated.covariance if corrected else self.fit.linear.covariance
            whole[np.ix_(places, places)] = covariance[: len(places), : len(places)]
        return whole

    def minimal_covariance(self, *, corrected: bool) -> FloatArray:
        """Covariance of the minimal parameters, (n_minimal, n_minimal)."""
        slopes = jacobian(self.model, np.array(self._all_values))
        physical = self.physical_covariance(corrected=corrected)
        unseen = np.isnan(np.diag(physical)) & ~slopes.any(axis=0)
        physical[unseen], physical[:, unseen] = 0.0, 0.0
        return np.asarray(slopes @ physical @ slopes.T)

    @property
    def _all_values(self) -> list[float]:
        assert self.fit is not None
        return [self.fit.search.parameters[name] for name in self.model.physical_units]


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
        ("held", "smooth") if declared is None else ("held" if declared else "smooth",)
    )
    with threadpool_limits(1):
        starts = _starts(model, dynamics, runs, prepared, nominal)
        fits = [
            _fitted(
                model,
                dynamics,
                runs,
                course,
                prepared,
                starts,
                free_timing=declared is None and course == "smooth",
            )
            for course in courses
        ]
    ranked = sorted(zip(fits, courses, strict=True), key=lambda pair: pair[0].cost if pair[0] else math.inf)
    fit, course = ranked[0]
    found = OutputErrorIdentification(
        model=model,
        logs=runs,
        fit=fit,
        course=course,
        timing_estimated=declared is None and course == "smooth",
        status="ok",
        message="",
        notes=tuple(note for log in runs for note in log.notes),
    )
    status, message = _verdict(found)
    return replace(found, status=status, message=message, notes=(*found.notes, *_remarks(found)))


def _starts(
    model: GeneratedModel,
    dynamics: ForwardDynamics,
    logs: Sequence[Log],
    preparation: Preparation,
    nominal: Mapping[str, float] | None,
) -> list[dict[str, float]]:
    """Parameters to begin with: nominal ones, or those of least squares and rough ones; only possible ones."""
    if nominal is not None:
        dynamics.at(nominal)  # says what is missing or impossible
    positive = dynamics.parameters_of("mass") | dynamics.parameters_of("stiffness")
    first = dict(nominal) if nominal is not None else _least_squares_start(model, logs, preparation)
    usable = first is not None and all(first[name] > 0 for name in positive)
    known = [first] if first is not None and usable else []
    if nominal is None or not usable:
        known.append(rigid_start(model, dynamics, logs))
    return [start for values in known for start in spread(dynamics, values, logs[0].sampling_frequency)]


def _least_squares_start(
    model: GeneratedModel, logs: Sequence[Log], preparation: Preparation
) -> dict[str, float] | None:
    try:
        found = identify(model, logs, preparation=preparation).physical_parameters
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
    late = preparation.late.get(dynamics.axis.drive.signal, 0.0)
    runs = [
        run_of(
            dynamics,
            log,
            model.measured,
            course,
            cutoff_hz=_VELOCITY_BAND * log.sampling_frequency,
            late=late,
            standstill=preparation.standstill,
        )
        for log in logs
    ]
    try:
        return fit_runs(model, dynamics, runs, starts, free_timing=free_timing)
    except np.linalg.LinAlgError:
        return None


def _verdict(found: OutputErrorIdentification) -> tuple[Status, str]:
    if found.fit is None:
        return (
            "no_start",
            "no start was possible: a log holds no lasting motion, or give nominal values with --nominal P.json",
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
