"""The conclusion from a selection: verdict, effects with their values, alternatives, parameters."""

import math
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from symid.axis import Axis
from symid.data import Log
from symid.diagnosis.effects import Placed, effects_of_element
from symid.diagnosis.findings.comparison import Comparison
from symid.diagnosis.findings.curves import signal_curves, spectrum_of, weighted_of
from symid.diagnosis.findings.diagnosis_result import Diagnosis, DriveError
from symid.diagnosis.findings.faults import NO_FAULTS, RecordingFaults, shifted_channels
from symid.diagnosis.findings.found_effects import Alternative, FoundEffect, ParameterChange
from symid.diagnosis.findings.gap import Gap, Level
from symid.diagnosis.findings.gap_of_comparison import gap_of
from symid.diagnosis.findings.location import is_stationary, joint_at, located, maps
from symid.diagnosis.findings.parameter_changes import effect_values, lost, parameter_changes
from symid.diagnosis.findings.wording import next_experiment
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.selection.evidence import (
    Errors,
    Outcome,
    Verdict,
    outcome,
    probabilities,
    probability_of_presence,
)
from symid.diagnosis.selection.lack_of_fit import LackOfFit, lack_of_fit
from symid.diagnosis.selection.step import SelectionStep, accepted_of
from symid.diagnosis.thresholds import THRESHOLDS

_LISTED = 20  # alternatives at most
_COGGING, _MODE = "cogging", "flexible_mode"


def concluded(
    comparison: Comparison,
    steps: Sequence[SelectionStep],
    fits: Sequence[Fit],
    nominal: Mapping[str, float] | None,
    logs: tuple[Log, Log | None],
    recording: RecordingFaults = NO_FAULTS,
) -> Diagnosis:
    """The diagnosis that follows from a selection, without its sentence and the gap in the motion.

    `fits` are the re-identified model and those with the accepted effects, one more in each; `comparison` has them and
    the nominal model on the validation data. `logs` are the identification log and the validation log, if there is one.
    """
    # Only effects that hold on the validation data count, on the force with the largest error.
    validated = comparison.validated
    comparison, fits = comparison.with_effects(validated).of_largest, fits[: 1 + validated]
    gaps, found = _gaps(comparison), maps(comparison)
    # The probabilities of the outcomes follow from the errors before and after, and from the test for a lack of fit.
    share, nonparametric = comparison.unexplained_of_all, _nonparametric_fit(gaps, fits)
    errors = _errors(gaps, share, is_stationary(comparison), fits[0], nonparametric.share)
    chances = outcome(steps, validated, errors)
    verdict = _verdict(chances, gaps, share, recording)
    # Effects are reported where the verdict names them; otherwise the gap stays that of the re-identified model.
    accepted = accepted_of(steps)[:validated] if verdict in ("effect", "partly") else []
    if not accepted:
        comparison, fits = comparison.with_effects(0), fits[:1]
        gaps, found = _gaps(comparison), maps(comparison)
    axis = comparison.record.dynamics.axis
    parameters = parameter_changes(fits, nominal)
    chances = _beside(axis, parameters, accepted, chances)
    effects = _effects(comparison, accepted, fits, chances, nonparametric)
    if lost(axis, parameters):
        effects = tuple(e.at_most(THRESHOLDS.impossible) if e.effect == _MODE else e for e in effects)
    alternatives = _alternatives(comparison, steps[0], chances)
    undetermined = [change.name for change in parameters if not change.is_determined]
    added = fits[-1].state.placed[len(fits[0].state.placed) :]
    faults = (*recording.texts, *shifted_channels(logs[0], comparison.record.forces, added))
    return Diagnosis(
        axis=axis,
        measured=comparison.record.signals,
        logs=tuple(log.source for log in logs if log is not None),
        verdict=verdict,
        sentence="",
        gap=gaps[0],
        location=located(found, _shares(comparison, accepted, steps)),
        maps=found,
        effects=effects,
        alternatives=alternatives,
        probabilities={k: v for k, v in chances.as_mapping.items() if k != "effect"},
        parameters=parameters,
        faults=faults,
        assumptions=_assumptions(comparison, gaps[0], logs[1]),
        next_experiment=next_experiment(verdict, effects, alternatives, undetermined),
        signals=signal_curves(comparison),
        spectrum=spectrum_of(comparison),
        weighted=weighted_of(comparison),
        drives=_drives(comparison),
        search=tuple(steps),
    )


def _beside(
    axis: Axis, parameters: Sequence[ParameterChange], accepted: Sequence[SelectionStep], chances: Outcome
) -> Outcome:
    """Probabilities of the outcomes, lower if the values found are impossible.

    Effects beside values that no machine has are hardly causes. If masses or stiffnesses are lost, a mode may be one
    that the axis declares.
    """
    is_impossible = any(
        own.is_far_from_physical for own in parameters if own.name not in axis.signed_parameters
    )
    is_mode = bool(accepted) and accepted[0].best.effect.name == _MODE
    doubtful = is_impossible or (is_mode and lost(axis, parameters))
    return chances.at_most(THRESHOLDS.impossible) if doubtful else chances


def _gaps(comparison: Comparison) -> tuple[Gap, ...]:
    """Gap of the force of the comparison, then of the other forces."""
    others = (own for own in comparison.of_drives if own.drive != comparison.drive)
    return tuple(gap_of(own) for own in (comparison, *others))


def _drives(comparison: Comparison) -> tuple[DriveError, ...]:
    """The force error of each of several drives; empty for one."""
    several = comparison.of_drives if comparison.record.n_drives > 1 else ()
    return tuple(
        DriveError(gap_of(own), signal_curves(own), spectrum_of(own), weighted_of(own)) for own in several
    )


def _nonparametric_fit(gaps: Sequence[Gap], fits: Sequence[Fit]) -> LackOfFit:
    """The best nonparametric law in the place of the first effect; none without an effect.

    If the motion repeats, none is sought: any force that repeats with it is then a function of the position.
    """
    repeats = any(gap.not_repeated is not None for gap in gaps)
    return lack_of_fit(fits[0], fits[-1]) if len(fits) > 1 and not repeats else LackOfFit()


def _errors(gaps: Sequence[Gap], share: float, stationary: bool, plain: Fit, nonparametric: float) -> Errors:
    """Errors for the verdict: the largest multiples of the noise, lower than stated where effects leave less."""

    def largest(levels: Iterable[Level]) -> float:
        pairs = zip(levels, gaps, strict=True)
        return max(level.rms / min(gap.noise_floor.rms, gap.explained.rms) for level, gap in pairs)

    nominal = [gap.nominal for gap in gaps if gap.nominal is not None]
    return Errors(
        nominal=largest(nominal) if nominal else None,
        reidentified=largest(gap.reidentified for gap in gaps),
        explained=largest(gap.explained for gap in gaps),
        left=share,
        stationary=stationary,
        relative=gaps[0].reidentified.relative,
        others=float(np.sqrt(plain.squares[len(gaps) :].max(initial=0.0))),
        nonparametric=nonparametric,
    )


def _verdict(chances: Outcome, gaps: Sequence[Gap], share: float, recording: RecordingFaults) -> Verdict:
    """The most probable verdict; "partly" if effects leave more than noise and more than a small share of the gap.

    No effect is concluded from a faulty recording: it may be an image of the fault.
    """
    verdict = chances.verdict
    if recording.uninformative or (recording.fatal and verdict not in ("no_gap", "parameters")):
        return "recording"
    if (
        verdict == "effect"
        and any(gap.explained.rms > THRESHOLDS.noise_alone * gap.least for gap in gaps)
        and share > THRESHOLDS.all_of_it
    ):
        return "partly"
    return verdict


def _effects(
    comparison: Comparison,
    accepted: Sequence[SelectionStep],
    fits: Sequence[Fit],
    chances: Outcome,
    nonparametric: LackOfFit,
) -> tuple[FoundEffect, ...]:
    last, known, axis = fits[-1], len(fits[0].state.placed), comparison.record.dynamics.axis
    values = effect_values(last)[known:]
    named = {item.key for item in last.state.placed[known:]}
    # An effect that explains the gap alone has absorbed nothing of others.
    alone = len(accepted) == 1 and not comparison.unexplained_of_all > THRESHOLDS.hardly_left
    found = []
    for i, step in enumerate(accepted):
        item = last.state.placed[known + i]
        best = item.key
        chance = probabilities(step, named - {best})
        rivals = [k for k, p in chance.items() if p >= THRESHOLDS.indistinguishable and k != best]
        there = chances.effect if i == 0 else THRESHOLDS.further_effect * probability_of_presence(step)
        if _may_be_an_order(item, last.state.placed):
            there *= THRESHOLDS.other_order
        # In the joint of a first effect of the wrong shape, a further effect corrects that shape.
        if nonparametric.outdoes and joint_at(axis, item.at) == joint_at(axis, last.state.placed[known].at):
            there = min(there, chances.effect)
        felt = comparison.showing(i + 2)
        found.append(
            FoundEffect(
                effect=best[0],
                at=best[1],
                probability=there * chance[best],
                probability_with_ties=there * math.fsum(chance[key] for key in (best, *rivals)),
                parameters=values[i],
                gap_after=felt.level(i + 2),
                removes=comparison.removed(i + 1, i + 2) if alone else comparison.removed_in_any_model(i + 2),
                indistinguishable_from=tuple(rivals),
                signal=comparison.record.forces[felt.drive],
                shown_by=comparison.record.outputs[comparison.output_of(i + 2)],
                outdone_by=nonparametric.of if i == 0 and nonparametric.outdoes else "",
            )
        )
    return tuple(found)


def _may_be_an_order(item: Placed, placed: Sequence[Placed]) -> bool:
    """Whether an effect repeats several times in a pitch of the cogging: it may stand in for a higher order of that."""
    if item.effect.name == _COGGING or "pitch" not in item.effect.shape_names:
        return False
    pitches = [other.shape[0] for other in placed if other.effect.name == _COGGING]
    orders = [pitch / item.shape[0] for pitch in pitches]
    return any(n > 1.5 and abs(n - round(n)) < THRESHOLDS.order_off * n for n in orders)


def _alternatives(comparison: Comparison, step: SelectionStep, chances: Outcome) -> tuple[Alternative, ...]:
    chance = probabilities(step)
    confirmed = {c.key: c for c in step.confirmed}
    gains = {c.placed.key: c.gain for c in step.screened}
    found = []
    for key, probability in list(chance.items())[:_LISTED]:
        own = confirmed.get(key)
        level: Level | None = None
        if own is not None:
            fit = own.fit
            level = Comparison(fit.weighting, (fit.state,), (fit.left,), comparison.drive).level(0)
        gain = gains[key] if own is None else own.gain
        found.append(Alternative(key[0], key[1], chances.effect * probability, gain, level))
    # Practically excluded candidates are sorted by gain.
    return tuple(
        sorted(found, key=lambda a: (-a.probability if a.probability >= 0.005 else 0.0, -a.log_likelihood))
    )


def _shares(
    comparison: Comparison, accepted: Sequence[SelectionStep], steps: Sequence[SelectionStep]
) -> dict[str, float]:
    """Share of the excess error by place: removed by its effects; without any, the probability of its candidates."""
    shares: dict[str, float] = {}
    if not accepted:
        chance = probabilities(steps[0]) if steps else {}
        for (_, place), probability in chance.items():
            shares[place] = shares.get(place, 0.0) + probability
        return shares
    powers = [comparison.whole_excess(i) for i in range(1, len(comparison.errors))]
    for step, before, after in zip(accepted, powers[:-1], powers[1:], strict=True):
        place = step.best.key[1]
        shares[place] = shares.get(place, 0.0) + max(before - after, 0.0) / max(powers[0], 1e-12)
    return shares


def _assumptions(comparison: Comparison, gap: Gap, validation: Log | None) -> tuple[str, ...]:
    record = comparison.record
    new = "not of the error between repetitions of the log"
    if gap.not_repeated is not None:
        new = (
            f"while {gap.not_repeated.level.rms:.3g} {gap.unit} of the error are new each time that the motion "
            f"repeats, every {gap.not_repeated.period:.3g} s"
        )
    return (
        "Each sample is the value at its time; the force is compared as it is recorded.",
        f"Noise is white, at the level of the readings beyond their motion, which ends at {record.motion_hz:.0f} Hz; "
        f"it is the floor of the error that sensors alone leave, {new}.",
        "Rests and some milliseconds around them are left out: no model determines friction at rest. Reversals count.",
        "The gap is measured on "
        + (
            "parts of the log that took no part in the identification."
            if validation is None
            else f"{validation.source}, which took no part in the identification."
        )
        + " Values that belong to a log (phases of disturbances in time, moments of changes) are fitted to it.",
        *_declared(comparison),
    )


def _declared(comparison: Comparison) -> tuple[str, ...]:
    """Identified values of declared imperfections."""
    state = comparison.states[1]
    assert state is not None
    elements = [
        effects_of_element(state.prediction, e) for e in comparison.record.dynamics.axis.imperfections
    ]
    known = [f"{item.effect.name} at {item.at}" for effects in elements for item in effects]
    passed_over = sum(not effects for effects in elements)
    identified = f"Declared, and identified with the parameters: {', '.join(known)}."
    left_out = f"{passed_over} declared imperfections are passed over, as the log cannot show them."
    return (identified,) * bool(known) + (left_out,) * bool(passed_over)
