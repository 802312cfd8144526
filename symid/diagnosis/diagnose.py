"""The steps of a diagnosis, from logs to the verdict.

`diagnose` reads and prepares the logs. `_Task.diagnosed` is the sequence of fit, selection, comparison and conclusion.
The other methods of `_Task` repeat it where its result shows that the logs were taken wrongly.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from threadpoolctl import threadpool_limits

from symid.axis import AnyAxis, Axis, axis_of
from symid.data import require_times_within
from symid.diagnosis.effects import ACTUATOR, LIBRARY, Effect, effects_named, with_equivalents
from symid.diagnosis.findings.comparison import Comparison, compared
from symid.diagnosis.findings.conclusion import concluded
from symid.diagnosis.findings.diagnosis_result import Diagnosis
from symid.diagnosis.findings.faults import RecordingFaults, recording_faults
from symid.diagnosis.findings.feedback import feedback_law, negative_friction
from symid.diagnosis.findings.fit_faults import changed_span, steady_force, wrong_gain
from symid.diagnosis.findings.held_out import shows_in_validation, strongest_first, without_worsening
from symid.diagnosis.findings.location import momentary
from symid.diagnosis.findings.wording import rejection, sentence
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.start import fitted_axis, starting_parameters
from symid.diagnosis.fitting.state import first_state
from symid.diagnosis.in_motion.corrected import with_corrected_values
from symid.diagnosis.in_motion.motion import is_contradicted, with_motion
from symid.diagnosis.late_reading import (
    READ_BEFORE_STEPS,
    delay_of_load_reading,
    delays_of_accelerometers,
    with_delayed_reading,
)
from symid.diagnosis.prediction.data import Data, LogsByPurpose, Recording, data_of, goes_elsewhere, one_run
from symid.diagnosis.prediction.preparation import prepared
from symid.diagnosis.selection.backward import backward_elimination, most_probable
from symid.diagnosis.selection.forward import forward_selection
from symid.diagnosis.selection.held import HELD, is_held, nominal_shows_hold, shows_hold
from symid.diagnosis.selection.step import SelectionStep, accepted_of, fits_of
from symid.identification import Preparation
from symid.identification.signals import LogLike, logs_of, require_changing
from symid.simulation import Cascade

_FAR_LESS = 0.5
"""Ratio of the unexplained shares below which the diagnosis from the validation log replaces the other one."""
_MOST_READINGS = 3  # iterations of the delay of a reading, of which its errors hide a part
_MOST_REJECTED = 3  # causes that are rejected one after another: each costs a selection
_ONLY_IN_VALIDATION = (
    "The missing effect shows in the validation log, and hardly in the other one. It was identified from two thirds of "
    "the validation log, and the gap measured on the rest."
)
_ONLY_TOGETHER = (
    "The validation log moves in a direction in which the other one does not: an effect of the direction shows only in "
    "both. It was identified from two thirds of all logs, and the gap measured on the rest."
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
    """Diagnose why simulation and machine differ.

    Parameters
    ----------
    axis : Axis, str, path-like or model
        The simulation: a declaration, the name or path of its file, or a model of it.
    log : Log, path-like, data frame or mapping, or a list of them
        Logs of the machine for the identification. Values and effects are common to them.
    validation : the same, optional
        Other logs, on which the gap is measured. By default the last of several logs, or every third part of a single
        one, which then takes no part in the identification; parts of all logs if only the last one moves in one of the
        directions.
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
        Controller of the machine, or one for each drive, with which the axis is simulated for `Gap.motion`; by default
        it is identified from the log.
    **columns
        ``columns``, ``units``, ``gains``, ``layout`` and ``sampling_period`` of files and frames, as in
        `symid.read_axis_log`.

    Raises
    ------
    LogError
        If a log cannot be read, is too short or holds neither position nor speed, or sampling periods of logs differ.
    SettingError
        If no initial values are given and none can be identified, or if `library` contains an unknown name.

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
    n_validation = None if validation is None else len(others)
    preparation = Preparation(late=dict(late or {}), held=held)
    ready = prepared(axis, [*logs, *others], n_validation, nominal, preparation)
    recording = Recording(dict(late or {}), held, controller, ready.decimation)
    with threadpool_limits(1):  # matrices are small: threads of the linear algebra would wait for each other
        found = _Task(ready.axis, ready.logs, nominal, recording, effects).from_informative_logs()
    faults = (*ready.faults, *found.faults)
    read = [note for each in (*logs, *others) for note in each.notes if note not in faults]
    assumptions = (*found.assumptions, *ready.notes, *dict.fromkeys(read))
    return replace(found, axis=ready.declared, faults=faults, assumptions=assumptions)


@dataclass(frozen=True, eq=False)
class _Task:
    """A diagnosis to be made: the axis, its logs, and the arguments of `diagnose`."""

    axis: Axis
    logs: LogsByPurpose
    nominal: Mapping[str, float] | None
    recording: Recording
    library: Sequence[Effect]
    n_rejected: int = 0  # effects that are left out because the simulated motion contradicts them

    def from_informative_logs(self) -> Diagnosis:
        """Diagnose from the identification logs, or if they do not excite the effect, from the validation logs or all.

        The other logs count if they show more effects and leave far less unexplained.
        """
        found = self.with_delayed_readings()
        identification, validation = self.logs
        if validation is None or not shows_in_validation(found):
            return found
        together = goes_elsewhere(self.axis, identification.parts, validation.parts)
        other_logs = one_run(self.axis, self.logs.every) if together else validation
        other = replace(self, logs=LogsByPurpose(other_logs, None)).diagnosed()
        if other.verdict not in ("effect", "partly") or other.named <= found.named:
            return found
        if not other.gap.unexplained_share < _FAR_LESS * found.gap.unexplained_share:
            return found
        return replace(
            other, assumptions=(_ONLY_TOGETHER if together else _ONLY_IN_VALIDATION, *other.assumptions)
        )

    def with_delayed_readings(self) -> Diagnosis:
        """Diagnose; if a friction comes out negative as by a late reading of the load, repeat with that delay."""
        found = late = self._with_delayed_accelerometers()
        delays: dict[str, float] = {}
        for _ in range(_MOST_READINGS):
            if not (further := delay_of_load_reading(self.axis, late)):
                break
            delays = self.recording.later(self.axis, further, delays)
            late = replace(self, recording=self.recording.with_late(delays)).diagnosed()
        return with_delayed_reading(found, late, delays) if delays else found

    def _with_delayed_accelerometers(self) -> Diagnosis:
        """Diagnose; if accelerometers are late by half the hold of a force, repeat with that delay."""
        found, recording = self.diagnosed(), self.recording
        holds_found = [text for text in self._hold_texts if text in found.faults]
        if holds_found:
            recording = replace(recording, held=True)
        holds = recording.holds(self.axis, self.logs.identification.log.sampling_period)
        further = delays_of_accelerometers(self.axis, found, max(holds.values())) if holds else {}
        if not further:
            return found
        delays = recording.later(self.axis, further)
        other = replace(self, recording=recording.with_late(delays)).diagnosed()
        return replace(other, faults=(*map(READ_BEFORE_STEPS.format, further), *holds_found, *other.faults))

    def diagnosed(self) -> Diagnosis:
        """Diagnose the logs as they are recorded."""
        # 1. The declared axis is fitted: at its initial values, then re-identified.
        data = data_of(self.axis, self.logs, self.recording)
        values = self._initial_values(data)
        state, weighting = first_state(data.record, values, data.training)
        reidentified = replace(fitted_axis(state, weighting), nominal=dict(self.nominal or {}))
        if reidentified.state.prediction.follows:
            state, weighting = first_state(data.record, values, data.training, follows=True)
        initial = Fit(state, weighting)
        # A hold of the force from sample to sample would look like a delay: test for it before effects, and after.
        unknown = self.recording.may_be_held(self.axis)
        if unknown and (
            shows_hold(reidentified) or (self.nominal and nominal_shows_hold(initial, reidentified))
        ):
            return self._with_hold()
        # 2. Effects are added one at a time, then each is judged beside all others.
        several_bodies = len(data.record.dynamics.bodies) > 1
        selected = forward_selection(reidentified, self.library, initial if several_bodies else None)
        steps: Sequence[SelectionStep] = backward_elimination(selected, self.library)
        reidentified = steps[0].before
        if unknown and any(is_held(step.best.fit) for step in steps if step.accepts):
            return self._with_hold()
        if accepted := accepted_of(steps):
            steps = tuple(step.fitted_on() for step in most_probable(accepted))

        # 3. The models are compared on data that took no part in any choice.
        def on_held_out(chosen: Sequence[SelectionStep]) -> Comparison:
            declared = state if self.nominal else None
            return compared(data.validation, declared, fits_of(reidentified, chosen), data.held_out)

        steps, comparison = without_worsening(steps, on_held_out)
        steps, comparison = strongest_first(steps, comparison, on_held_out)
        # 4. Verdict and values, unless the recording is at fault or the simulated motion contradicts them.
        fits = fits_of(reidentified, steps)
        faults = self._faults(initial, reidentified, fits[-1])
        return self._concluded(steps, fits, comparison, data, faults)

    def _initial_values(self, data: Data) -> Mapping[str, float]:
        """Nominal values in the order of the declaration, or roughly identified ones."""
        if not self.nominal:
            return starting_parameters(self.axis, data.record)
        return {name: self.nominal[name] for name in self.axis.physical_parameters if name in self.nominal}

    def _with_hold(self) -> Diagnosis:
        """Diagnose with the force held from sample to sample, which is not an effect of the machine."""
        found = replace(self, recording=replace(self.recording, held=True)).diagnosed()
        return replace(found, faults=(*self._hold_texts, *found.faults))

    @property
    def _hold_texts(self) -> tuple[str, ...]:
        """Sentences on a hold of every force."""
        return tuple(HELD.format(drive.signal) for drive in self.axis.drives)

    def _faults(self, initial: Fit, reidentified: Fit, last: Fit) -> RecordingFaults:
        """Faults of the recording, the one that explains most first."""
        faults = recording_faults(self.logs.every, initial, reidentified, last).led_by(feedback_law(last))
        if not faults.fatal:
            faults = faults.led_by(negative_friction(last, reidentified))
        for text in (wrong_gain(reidentified), steady_force(reidentified)):
            faults = faults.led_by(text, uninformative=True)
        return faults

    def _concluded(
        self,
        steps: Sequence[SelectionStep],
        fits: Sequence[Fit],
        comparison: Comparison,
        data: Data,
        faults: RecordingFaults,
    ) -> Diagnosis:
        """The conclusion; if the simulated motion contradicts its first effect, that of a selection without it."""
        identification, validation = self.logs
        sources = identification.log, validation.log if validation else None

        def concluded_from(models: Comparison) -> Diagnosis:
            found = concluded(models, steps, fits, self.nominal, sources, faults)
            if found.verdict in ("unexplained", "partly") and len(identification.parts) == 1:
                last, alone = len(found.effects), validation is None
                moment = momentary(models.with_effects(last), fits[last]) if alone else ""
                moment = moment or changed_span(fits[0], "the log" if alone else "the identification log")
                found = replace(found, next_experiment=moment or found.next_experiment)
            controller = self.recording.controller
            found, models = with_corrected_values(found, models, fits, identification, controller)
            return with_motion(found, models, self.logs, data.held_out, controller=controller)

        found = concluded_from(comparison)
        if is_contradicted(found):  # by all effects together, and by the first alone: another cause is sought
            rejected = rejection(found)
            found = self._without(found.effects[0].effect) or concluded_from(comparison.with_effects(0))
            found = replace(found, assumptions=(*found.assumptions, rejected))
        return replace(found, sentence=sentence(found))

    def _without(self, effect: str) -> Diagnosis | None:
        """The diagnosis without an effect and its equivalents; None if it finds none, or after several rejections."""
        refused = {name for name, _ in with_equivalents([(effect, ACTUATOR)])}
        library = [other for other in self.library if other.name not in refused]
        if not library or self.n_rejected == _MOST_REJECTED:
            return None
        found = replace(self, library=library, n_rejected=self.n_rejected + 1).diagnosed()
        return found if found.verdict in ("effect", "partly") else None
