"""The steps of a diagnosis, from logs to the verdict."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from threadpoolctl import threadpool_limits

from symid.axis import AnyAxis, Axis, axis_of
from symid.data import Log, require_times_within
from symid.diagnosis.effects import ACTUATOR, LIBRARY, Effect, effects_named, with_alike
from symid.diagnosis.findings.comparison import Comparison, compared
from symid.diagnosis.findings.conclusion import concluded
from symid.diagnosis.findings.diagnosis_result import Diagnosis
from symid.diagnosis.findings.faults import Damage, damage
from symid.diagnosis.findings.feedback import driven_backwards, feedback_law
from symid.diagnosis.findings.fit_faults import changed_span, steady_force, wrong_gain
from symid.diagnosis.findings.held_out import shows_in_validation, strongest_first, without_worsening
from symid.diagnosis.findings.location import momentary
from symid.diagnosis.findings.wording import rejection, sentence
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.start import fitted_axis, starting_parameters
from symid.diagnosis.fitting.state import first_state
from symid.diagnosis.in_motion.corrected import with_corrected_values
from symid.diagnosis.in_motion.motion import is_contradicted, with_motion
from symid.diagnosis.late_reading import READ_BEFORE_STEPS, before_steps, lateness, with_late_reading
from symid.diagnosis.prediction.data import Data, Recorded, Runs, as_runs, data_of, goes_elsewhere, one_run
from symid.diagnosis.prediction.integrated_speed import with_positions
from symid.diagnosis.prediction.one_way import alike_in_one_way
from symid.diagnosis.prediction.recorder import recovered
from symid.diagnosis.prediction.scaled_sensors import with_quantities
from symid.diagnosis.selection.backward import backward_elimination, most_probable
from symid.diagnosis.selection.forward import forward_selection
from symid.diagnosis.selection.held import HELD, is_held, nominal_shows_hold, shows_hold
from symid.diagnosis.selection.step import SelectionStep, accepted_of, fits_of
from symid.identification import Preparation
from symid.identification.signals.axis_logs import LogLike, logs_of, require_changing
from symid.simulation import Cascade

_FAR_LESS = 0.5
"""Share of the error left unexplained below which the answer of the validation log takes the place of the other."""
_MOST_READINGS = 3  # steps to the time by which a reading is late: its errors hide a part of it
_MOST_REJECTED = 3  # causes that are left out one after another: each costs a search
_ONLY_IN_VALIDATION = (
    "What the model lacks shows in the validation log, and in part hardly in the other one. It was identified from two "
    "thirds of the former, and the gap measured on the rest."
)
_ONLY_TOGETHER = (
    "The validation log goes a way that the other one does not: what depends on the direction shows only in both. They "
    "were identified from two thirds of all logs, and the gap measured on the rest."
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
    library: Sequence[Effect | str] = LIBRARY,
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
        one, which then takes no part in the identification; of all logs if the last one alone goes one of two ways.
    nominal : mapping of str to float, optional
        Parameter values of the simulation, SI.
    measured : sequence of str, optional
        Sensors to read from files and frames; all of them by default.
    late : mapping of str to float, optional
        Time by which signals were recorded late, s; negative for a force that acts later than recorded.
    held : bool, optional
        Whether the force is held from sample to sample, so that it acts half a sample later than it is recorded. If it
        is not given and the axis does not declare it, the log is tested for it.
    library : sequence of Effect or str
        Effects that are considered, or their names.
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
        If there are no nominal values and none can be identified to begin with, or no effect has a name of `library`.

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
    axis, effects = axis_of(axis), effects_named(library)
    logs = logs_of(axis, log, measured, **columns)
    others = logs_of(axis, () if validation is None else validation, measured, **columns)
    for each in (*logs, *others):
        require_changing(each, [*(d.signal for d in axis.drives), *(s.signal for s in axis.sensors)])
        require_times_within(each.source, late or {}, each.n_samples * each.sampling_period)
    whole = recovered(axis, [*logs, *others])
    prepared = Preparation(late=dict(late or {}), held=held)
    plain = with_quantities(axis, whole.logs, nominal, prepared)
    moved, every, notes = with_positions(plain.axis, plain.logs)
    constants, alike = alike_in_one_way(moved, every, nominal)
    moved, declared = (each.with_known(constants) for each in (moved, plain.declared))
    runs = as_runs(moved, every, None if validation is None else len(others))
    with threadpool_limits(1):  # matrices are small: threads of the linear algebra would wait for each other
        recorded = Recorded(dict(late or {}), held, controller, whole.thinned)
        found = _Task(moved, runs, nominal, recorded, effects).either_way()
    faults = (*whole.notes, *found.faults)
    read = [note for each in (*logs, *others) for note in each.notes if note not in faults]
    assumed = (*found.assumptions, *plain.notes, *notes, *alike, *dict.fromkeys(read))
    return replace(found, axis=declared, faults=faults, assumptions=assumed)


@dataclass(frozen=True, eq=False)
class _Task:
    """The subject of a diagnosis: the axis, its logs and their recording, and what the user gave."""

    axis: Axis
    runs: Runs
    nominal: Mapping[str, float] | None
    recorded: Recorded
    library: Sequence[Effect]
    n_rejected: int = 0  # effects that are left out because the simulated motion contradicts them

    def either_way(self) -> Diagnosis:
        """Identified from the logs, or where these do not show the effect, from the validation logs or from all."""
        found = self.physically_read()
        run, validation = self.runs
        if validation is None or not shows_in_validation(found):
            return found
        together = goes_elsewhere(self.axis, run.parts, validation.parts)
        tried = one_run(self.axis, self._parts) if together else validation
        other = replace(self, runs=(tried, None)).diagnosed()
        if other.verdict not in ("effect", "partly") or other.named <= found.named:
            return found
        if not other.gap.unexplained_share < _FAR_LESS * found.gap.unexplained_share:
            return found
        said = _ONLY_TOGETHER if together else _ONLY_IN_VALIDATION
        return replace(other, assumptions=(said, *other.assumptions))

    def physically_read(self) -> Diagnosis:
        """Diagnosed with the reading of a load taken as late where friction would be negative without."""
        found = late = self._read_before_steps()
        times: dict[str, float] = {}
        for _ in range(_MOST_READINGS):
            if not (further := lateness(self.axis, late)):
                break
            delays = {s.signal: s.delay for s in self.axis.sensors} | dict(self.recorded.late) | times
            times = {signal: delays[signal] + time for signal, time in further.items()}
            read = replace(self.recorded, late={**self.recorded.late, **times})
            late = replace(self, recorded=read).diagnosed()
        return with_late_reading(found, late, times) if times else found

    def _read_before_steps(self) -> Diagnosis:
        """Diagnosed with accelerometers taken as read before the steps of a held force where they are late by that."""
        found, recorded = self.diagnosed(), self.recorded
        if any(text in found.faults for text in self._hold_texts):
            recorded = replace(recorded, held=True)
        holds = recorded.holds(self.axis, self.runs[0].log.sampling_period)
        times = before_steps(self.axis, found, max(holds.values())) if holds else {}
        if not times:
            return found
        delays = {s.signal: s.delay for s in self.axis.sensors} | dict(recorded.late)
        late = {**recorded.late, **{signal: delays[signal] + time for signal, time in times.items()}}
        other = replace(self, recorded=replace(recorded, late=late)).diagnosed()
        texts = (*map(READ_BEFORE_STEPS.format, times), *(t for t in found.faults if t in self._hold_texts))
        return replace(other, faults=(*texts, *other.faults))

    def diagnosed(self) -> Diagnosis:
        """The diagnosis of the logs as they are recorded."""
        # 1. The declared axis, first at its initial values, then re-identified.
        data = data_of(self.axis, self.runs, self.recorded)
        start = self._initial_values(data)
        state, weighting = first_state(data.record, start, data.training)
        base = replace(fitted_axis(state, weighting), nominal=dict(self.nominal or {}))
        if base.state.prediction.follows:
            state, weighting = first_state(data.record, start, data.training, follows=True)
        begun = Fit(state, weighting)
        # A hold of the force from sample to sample would look like a delay: it is sought before effects, and after.
        unknown = self.recorded.may_be_held(self.axis)
        if unknown and (shows_hold(base) or (self.nominal and nominal_shows_hold(begun, base))):
            return self._with_hold()
        # 2. Effects are added one at a time, then each is judged beside all others.
        before = begun if len(data.record.dynamics.bodies) > 1 else None
        selected = forward_selection(base, self.library, before)
        steps: Sequence[SelectionStep] = backward_elimination(selected, self.library)
        base = steps[0].before
        if unknown and any(is_held(step.best.fit) for step in steps if step.accepts):
            return self._with_hold()
        if accepted := accepted_of(steps):
            steps = tuple(step.fitted_on() for step in most_probable(accepted))

        # 3. The models are compared on data that took no part in any choice.
        def on_held_out(chosen: Sequence[SelectionStep]) -> Comparison:
            declared = state if self.nominal else None
            return compared(data.validation, declared, fits_of(base, chosen), data.held_out)

        steps, comparison = without_worsening(steps, on_held_out)
        steps, comparison = strongest_first(steps, comparison, on_held_out)
        # 4. Verdict and values, unless the recording is at fault or the simulated motion contradicts them.
        damaged = self._damage(begun, base, fits_of(base, steps)[-1])
        return self._concluded(steps, base, comparison, data, damaged)

    def _initial_values(self, data: Data) -> Mapping[str, float]:
        """Nominal values in the order of the declaration, as their deviations are; else roughly identified ones."""
        if not self.nominal:
            return starting_parameters(self.axis, data.record)
        return {name: self.nominal[name] for name in self.axis.physical_parameters if name in self.nominal}

    def _with_hold(self) -> Diagnosis:
        """The same where the force is held from sample to sample: that is not an effect of the machine."""
        found = replace(self, recorded=replace(self.recorded, held=True)).diagnosed()
        return replace(found, faults=(*self._hold_texts, *found.faults))

    @property
    def _hold_texts(self) -> tuple[str, ...]:
        """Sentences on a hold of every force."""
        return tuple(HELD.format(drive.signal) for drive in self.axis.drives)

    @property
    def _parts(self) -> list[Log]:
        """All logs, those for the validation last."""
        return [part for run in self.runs if run is not None for part in run.parts]

    def _damage(self, begun: Fit, base: Fit, last: Fit) -> Damage:
        """Faults of the recording, the one that explains most in front."""
        damaged = damage(self._parts, begun, base, last).led_by(feedback_law(last))
        if not damaged.fatal:
            damaged = damaged.led_by(driven_backwards(last, base))
        return damaged.led_by(wrong_gain(base), silent=True).led_by(steady_force(base), silent=True)

    def _concluded(
        self, steps: Sequence[SelectionStep], base: Fit, comparison: Comparison, data: Data, damaged: Damage
    ) -> Diagnosis:
        """The conclusion; without effects where the simulated motion contradicts them."""
        run, validation = self.runs
        fits, logs = fits_of(base, steps), (run.log, validation.log if validation else None)

        def concluded_from(models: Comparison) -> Diagnosis:
            found = concluded(models, steps, fits, self.nominal, logs, damaged)
            if found.verdict in ("unexplained", "partly") and len(run.parts) == 1:
                last, alone = len(found.effects), validation is None
                moment = momentary(models.with_effects(last), fits[last]) if alone else ""
                moment = moment or changed_span(base, "the log" if alone else "the identification log")
                found = replace(found, next_experiment=moment or found.next_experiment)
            found, models = with_corrected_values(found, models, fits, run, self.recorded.controller)
            return with_motion(found, models, self.runs, data.held_out, controller=self.recorded.controller)

        found = concluded_from(comparison)
        if is_contradicted(found):  # by all effects together, and by the first alone: another cause is sought
            rejected = rejection(found)
            found = self._without(found.effects[0].effect) or concluded_from(comparison.with_effects(0))
            found = replace(found, assumptions=(*found.assumptions, rejected))
        return replace(found, sentence=sentence(found))

    def _without(self, effect: str) -> Diagnosis | None:
        """The diagnosis without an effect and those nearly equal to it; None if it finds none, or after several."""
        refused = {name for name, _ in with_alike([(effect, ACTUATOR)])}
        library = [other for other in self.library if other.name not in refused]
        if not library or self.n_rejected == _MOST_REJECTED:
            return None
        found = replace(self, library=library, n_rejected=self.n_rejected + 1).diagnosed()
        return found if found.verdict in ("effect", "partly") else None
