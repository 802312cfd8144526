"""The steps of a diagnosis, from logs to the verdict."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from symid.axis import AnyAxis, Axis, axis_of
from symid.diagnosis.effects import LIBRARY, Effect
from symid.diagnosis.findings.changed_span import changed_span
from symid.diagnosis.findings.comparison import Comparison, compared
from symid.diagnosis.findings.conclusion import concluded
from symid.diagnosis.findings.diagnosis_result import Diagnosis
from symid.diagnosis.findings.faults import damage
from symid.diagnosis.findings.feedback import driven_backwards, feedback_law
from symid.diagnosis.findings.location import momentary
from symid.diagnosis.findings.steady_force import steady_force
from symid.diagnosis.findings.wording import rejection, sentence
from symid.diagnosis.findings.wrong_gain import wrong_gain
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.start import fitted_axis, starting_parameters
from symid.diagnosis.fitting.state import State, first_state
from symid.diagnosis.in_motion.motion import is_contradicted, with_motion
from symid.diagnosis.late_reading import lateness, with_late_reading
from symid.diagnosis.prediction.data import Data, Recorded, Runs, data_of, one_run
from symid.diagnosis.prediction.integrated_speed import with_positions
from symid.diagnosis.prediction.recorder import recovered
from symid.diagnosis.prediction.scaled_sensors import with_quantities
from symid.diagnosis.selection.backward import backward_elimination, brought_first, most_probable, without
from symid.diagnosis.selection.forward import forward_selection
from symid.diagnosis.selection.held import HELD, is_held, nominal_shows_hold, shows_hold
from symid.diagnosis.selection.step import LATE_READING, SelectionStep
from symid.diagnosis.thresholds import THRESHOLDS
from symid.identification.axis_logs import require_changing
from symid.identification.log_like import LogLike, logs_of
from symid.simulation import Cascade

_ELSEWHERE = 5.0
"""Mean square left of the validation log relative to that of the other log, both in multiples of the noise, from which
on something acts there that does not act here."""
_MOST_READINGS = 3
"""Most steps to the time by which a reading is late: the errors that it makes hide a part of it."""
_ONLY_IN_VALIDATION = (
    "The effect shows in the validation log and hardly in the other one. It was identified from two thirds of the "
    "former, and the gap measured on the rest."
)


def diagnose(
    axis: AnyAxis,
    log: LogLike | Sequence[LogLike],
    *,
    validation: LogLike | Sequence[LogLike] | None = None,
    nominal: Mapping[str, float] | None = None,
    measured: Sequence[str] | None = None,
    late: Mapping[str, float] | None = None,
    held: bool | None = None,
    library: Sequence[Effect] = LIBRARY,
    controller: Cascade | Sequence[Cascade] | None = None,
    **columns: Any,
) -> Diagnosis:
    """Find out why simulation and machine differ.

    Parameters
    ----------
    axis : Axis, str, path-like or model
        The simulation: a declaration, the name or path of its file, or a model of it.
    log : Log, path-like, data frame or mapping, or a list of them
        Logs of the machine, from which everything is identified: values and effects are common to them.
    validation : the same, optional
        Other logs, on which the gap is measured. By default the last of several logs, or every third part of a single
        one, which then takes no part in the identification.
    nominal : mapping of str to float, optional
        Parameter values of the simulation, SI.
    measured : sequence of str, optional
        Sensors to read from files and frames; all of them by default.
    late : mapping of str to float, optional
        Time by which signals were recorded late, s; negative for a force that acts later than recorded.
    held : bool, optional
        Whether the force is held from sample to sample, so that it acts half a sample later than it is recorded. If it
        is not given and the axis does not declare it, the log is tested for it.
    library : sequence of Effect
        Effects that are considered.
    controller : Cascade or sequence of Cascade, optional
        That of the machine, or one for each drive, under which the axis is simulated for `Gap.motion`; read from the
        log if it is not given.
    **columns
        ``columns``, ``units``, ``gains``, ``layout`` and ``sampling_period`` of files and frames, as in
        `symid.read_axis_log`.

    Raises
    ------
    LogError
        If a log cannot be read, is too short or holds neither position nor speed, or sampling periods of logs differ.
    SettingError
        If there are no nominal values and none can be identified to begin with.

    Examples
    --------
    >>> from symid.axis import OffsetForce, load_axis
    >>> from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade
    >>> axis, values = load_axis("rigid_1m"), {"M": 100.0, "Fv": 120.0, "Fs": 30.0}
    >>> noisy = axis.with_signal("q", noise=1e-7).with_signal("F", noise=1.0)
    >>> hung, pulled = noisy.with_effect(OffsetForce(axis.bodies[0], "F0")), values | {"F0": 20.0}
    >>> reference = trapezoids(0.1, [0.1, 0.2, 0.3], acceleration=3.0, jerk=60.0, dwell=0.1, sampling_period=1e-3)
    >>> log = simulate(hung, pulled, reference, tuned_cascade(plant_of(axis, values), "q")).log
    >>> found = diagnose(axis, log, nominal=values, held=True)
    >>> found.verdict, found.effects[0].effect
    ('effect', 'offset_force')
    """
    axis = axis_of(axis)
    logs = logs_of(axis, log, measured, **columns)
    others = logs_of(axis, () if validation is None else validation, measured, **columns)
    if not others and len(logs) > 1:
        others = [logs.pop()]
    for each in (*logs, *others):
        require_changing(each, [*(d.signal for d in axis.drives), *(s.signal for s in axis.sensors)])
    whole = recovered(axis, [*logs, *others])
    plain = with_quantities(axis, whole.logs, nominal)
    moved, every, notes = with_positions(plain.axis, plain.logs)
    logs, others = every[: len(logs)], every[len(logs) :]
    runs = one_run(moved, logs), one_run(moved, others) if others else None
    with threadpool_limits(1):  # matrices are small: threads of the linear algebra would wait for each other
        recorded = Recorded(dict(late or {}), held, controller, whole.thinned)
        found = _either_way(moved, runs, nominal, recorded, library)
    assumed = (*found.assumptions, *plain.notes, *notes)
    return replace(found, axis=plain.declared, faults=(*whole.notes, *found.faults), assumptions=assumed)


def _either_way(
    axis: Axis, runs: Runs, nominal: Mapping[str, float] | None, recorded: Recorded, library: Sequence[Effect]
) -> Diagnosis:
    """Identified from the logs, or from the validation logs where these alone show the effect."""
    found = _physically_read(axis, runs, nominal, recorded, library)
    validation = runs[1]
    if validation is None or not _shows_in_validation(found):
        return found
    other = _diagnosed(axis, (validation, None), nominal, recorded, library)
    if other.verdict not in ("effect", "partly") or _leads(other) == _leads(found):
        return found
    if found.verdict == "partly" and not other.gap.unexplained_share < found.gap.unexplained_share:
        return found
    return replace(other, assumptions=(_ONLY_IN_VALIDATION, *other.assumptions))


def _leads(found: Diagnosis) -> tuple[tuple[str, str], ...]:
    """Name and place of the first effect, if there is one."""
    return tuple((one.effect, one.at) for one in found.effects[:1])


def _physically_read(
    axis: Axis, runs: Runs, nominal: Mapping[str, float] | None, recorded: Recorded, library: Sequence[Effect]
) -> Diagnosis:
    """Diagnosed with the reading of a load taken as late where friction would be negative without."""
    found = late = _diagnosed(axis, runs, nominal, recorded, library)
    times: dict[str, float] = {}
    for _ in range(_MOST_READINGS):
        if not (further := lateness(axis, late)):
            break
        delays = {sensor.signal: sensor.delay for sensor in axis.sensors} | dict(recorded.late) | times
        times = {signal: delays[signal] + time for signal, time in further.items()}
        read = replace(recorded, late={**recorded.late, **times})
        late = _diagnosed(axis, runs, nominal, read, library)
    return with_late_reading(found, late, times) if times else found


def _shows_in_validation(found: Diagnosis) -> bool:
    """Whether the model found leaves only noise of its own log, or many times as much error of the other."""
    if not found.search or found.verdict not in ("unexplained", "partly"):
        return False
    accepted = [step for step in found.search if step.accepts][: len(found.effects)]
    fit = accepted[-1].confirmed[0].fit if accepted else found.search[0].before
    other = (found.gap.explained.rms / found.gap.noise_floor.rms) ** 2
    return fit.mean_square < THRESHOLDS.fit_of_noise or other > _ELSEWHERE * fit.mean_square


def _diagnosed(
    axis: Axis, runs: Runs, nominal: Mapping[str, float] | None, recorded: Recorded, library: Sequence[Effect]
) -> Diagnosis:
    data = data_of(axis, runs, recorded)
    if nominal:  # values in the order of the declaration, as their deviations are
        start = {name: nominal[name] for name in axis.physical_parameters if name in nominal}
    else:
        start = starting_parameters(axis, data.record)
    state, weighting = first_state(data.record, start, data.training)
    base = replace(fitted_axis(state, weighting), nominal=dict(nominal or {}))
    if base.state.prediction.follows:
        state, weighting = first_state(data.record, start, data.training, follows=True)
    begun = Fit(state, weighting)
    unknown = recorded.may_be_held(axis)
    if unknown and (shows_hold(base) or (nominal and nominal_shows_hold(begun, base))):
        return _with_hold(axis, runs, nominal, recorded, library)
    before = begun if len(data.record.dynamics.bodies) > 1 else None
    steps: Sequence[SelectionStep] = backward_elimination(forward_selection(base, library, before), library)
    base = steps[0].before
    if unknown and any(is_held(step.confirmed[0].fit) for step in steps if step.accepts):
        return _with_hold(axis, runs, nominal, recorded, library)
    declared = state if nominal else None
    if accepted := [step for step in steps if step.accepts]:
        steps = [step.fitted_on() for step in most_probable(accepted)]
    steps, comparison = _on_held_out(base, steps, declared, data)
    steps, comparison = _strongest_first(base, steps, declared, data, comparison)
    fits = fits_of(base, steps)
    logs = runs[0].log, runs[1].log if runs[1] else None
    parts = [part for run in runs if run is not None for part in run.parts]
    damaged = damage(parts, begun, base).led_by(feedback_law(fits[-1]))
    if not damaged.fatal:
        damaged = damaged.led_by(driven_backwards(fits[-1]))
    damaged = damaged.led_by(wrong_gain(base), silent=True).led_by(steady_force(base), silent=True)

    def concluded_from(models: Comparison) -> Diagnosis:
        found = concluded(models, steps, fits, nominal, logs, damaged)
        if found.verdict in ("unexplained", "partly") and len(parts) == 1:
            moment = momentary(models.with_effects(len(found.effects)), fits[len(found.effects)])
            found = replace(found, next_experiment=moment or changed_span(base) or found.next_experiment)
        return with_motion(found, models, runs, data.held_out, controller=recorded.controller)

    found = concluded_from(comparison)
    if is_contradicted(found):  # by all effects together, and by the first alone: there is no cause
        rejected = rejection(found)
        found = concluded_from(comparison.with_effects(0))
        found = replace(found, assumptions=(*found.assumptions, rejected))
    return replace(found, sentence=sentence(found))


def _on_held_out(
    base: Fit, steps: Sequence[SelectionStep], nominal: State | None, data: Data
) -> tuple[Sequence[SelectionStep], Comparison]:
    """Models on the validation data, without an effect beside others that makes their error grow there."""
    comparison = compared(data.validation, nominal, fits_of(base, steps), data.held_out)
    if comparison.worsened is None:
        return steps, comparison
    accepted = [step for step in steps if step.accepts]
    rest = without(accepted, comparison.worsened)
    return (steps, comparison) if len(rest) == len(accepted) else _on_held_out(base, rest, nominal, data)


def _strongest_first(
    base: Fit, steps: Sequence[SelectionStep], nominal: State | None, data: Data, comparison: Comparison
) -> tuple[Sequence[SelectionStep], Comparison]:
    """The effect that alone would leave the largest error of the force as the first, see `strengths`.

    Logs excite effects differently, and an effect that is found first takes over what it has in common with others. One
    that removes less than half of the largest share shows only beside the others and is not the first.
    """
    accepted = [step for step in steps if step.accepts][: comparison.validated]
    if len(accepted) < 2:
        return steps, comparison
    shares = [comparison.removed(i + 1, i + 2).share for i in range(len(accepted))]
    least = THRESHOLDS.stands_in * max(shares)
    if accepted[0].confirmed[0].effect.name == LATE_READING and shares[0] >= least:
        return steps, comparison
    for at in np.argsort(-comparison.with_effects(len(accepted)).strengths, kind="stable"):
        if at == 0 and shares[0] >= least:
            break
        ordered = brought_first(accepted, int(at))
        other = compared(data.validation, nominal, fits_of(base, ordered), data.held_out)
        # A second fit leaves a little more or less of the noise, which is most of what a good model leaves.
        most = comparison.relative_error**2
        as_good = other.relative_error**2 < max(THRESHOLDS.as_good * most, most + THRESHOLDS.hardly_more_left)
        if as_good and other.validated > 0 and other.removed(1, 2).share >= least:
            return ordered, other
    return steps, comparison


def _with_hold(
    axis: Axis, runs: Runs, nominal: Mapping[str, float] | None, recorded: Recorded, library: Sequence[Effect]
) -> Diagnosis:
    """The same where the force is held from sample to sample: that is not an effect of the machine."""
    found = _diagnosed(axis, runs, nominal, replace(recorded, held=True), library)
    held = tuple(HELD.format(drive.signal) for drive in axis.drives)
    return replace(found, faults=(*held, *found.faults))


def fits_of(base: Fit, steps: Sequence[SelectionStep]) -> list[Fit]:
    """The re-identified model, and those with effects accepted one by one."""
    return [base, *(step.confirmed[0].fit for step in steps if step.accepts)]
