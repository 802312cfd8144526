"""The gap in the motion: each model is simulated under the controller of the log and compared with the machine."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain

import numpy as np

from symid.arrays import BoolArray, FloatArray
from symid.data import Log
from symid.diagnosis.effects import FlexibleModeEffect
from symid.diagnosis.findings.comparison import Comparison
from symid.diagnosis.findings.diagnosis_result import Diagnosis
from symid.diagnosis.findings.gap import MotionError, SimulatedMotion
from symid.diagnosis.fitting.state import State
from symid.diagnosis.in_motion.declared import ExplainedAxis, axis_with_effects
from symid.diagnosis.in_motion.replayed import (
    Driver,
    Part,
    driver_of,
    falling_stiffness,
    parts_of,
    simulated_positions,
    since_begin,
)
from symid.diagnosis.prediction.data import Controllers, LogsByPurpose
from symid.diagnosis.prediction.record import Record
from symid.diagnosis.thresholds import THRESHOLDS
from symid.errors import LogError, SettingError, SymidError
from symid.estimation import fit_percent
from symid.simulation import Cascade

_SAME = 0.01
"""Relative difference of two references or durations below which they count as equal."""
_PHASE = 0.25
"""Distance from the measured position, in pitches, from which on a force that repeats along the stroke is another."""
_AWAY = 10.0
"""Distance from the measured position, in multiples of its range, at which a simulated axis counts as running away."""


def with_motion(
    found: Diagnosis,
    comparison: Comparison,
    runs: LogsByPurpose,
    allowed: BoolArray | None,
    *,
    controller: Controllers = None,
    simulated: Log | None = None,
) -> Diagnosis:
    """A diagnosis with the gap in the motion next to each drive.

    An effect becomes unlikely if the simulated motion with it is farther from that of the machine.
    """
    models = comparison.with_effects(len(found.effects))
    if runs.validation is not None:  # phases and moments differ in the validation log
        models = models.fitted_to_log()
    motions = motions_of(models, runs, allowed, controller=controller, simulated=simulated)
    of_force = dict(zip(comparison.record.forces, motions, strict=True))
    drives = (replace(own, gap=replace(own.gap, motion=of_force[own.gap.signal])) for own in found.drives)
    motion = of_force[found.gap.signal]
    found = replace(
        found, gap=replace(found.gap, motion=motion), drives=tuple(drives), model=models.states[-1]
    )
    return _contradicted(found, motion) if found.effects else found


def _contradicted(found: Diagnosis, motion: SimulatedMotion) -> Diagnosis:
    """A diagnosis with the probabilities corrected by the simulated motion."""
    against = _against(found, motion)
    effects = tuple(
        effect.at_most(THRESHOLDS.unlikely) if contradicted else effect
        for effect, contradicted in zip(found.effects, against, strict=True)
    )
    share = effects[0].probability / max(found.effects[0].probability, np.finfo(float).tiny)
    rivals = tuple(replace(own, probability=share * own.probability) for own in found.alternatives)
    rest = 1 - math.fsum(found.probabilities.values())
    unexplained = found.probabilities["unexplained"] + (1 - share) * rest
    probabilities = {**found.probabilities, "unexplained": unexplained}
    return replace(found, effects=effects, alternatives=rivals, probabilities=probabilities)


def is_contradicted(found: Diagnosis) -> bool:
    """Whether the simulated motion speaks against the first effect of a diagnosis."""
    motion = found.gap.motion
    return bool(found.effects) and motion is not None and _against(found, motion)[0]


def _against(found: Diagnosis, motion: SimulatedMotion) -> list[bool]:
    """Whether the simulated motion speaks against each effect found.

    A model that cannot be simulated is judged by the last one. A force that repeats along the stroke is not judged if
    the axis without it is off by a quarter of the pitch: it acts with another phase there than on the machine. A mode
    is judged more strictly, as its additional motion can explain any force in a swing or two.
    """
    errors = [error.position_rms for error in (motion.reidentified, *motion.steps)]
    numbers = (effect.parameters for effect in found.effects)
    farthest = (_PHASE * abs(own["pitch"].value) if "pitch" in own else math.inf for own in numbers)
    worst = (
        THRESHOLDS.worse_with_mode if own.effect == FlexibleModeEffect.name else THRESHOLDS.worse_motion
        for own in found.effects
    )
    return [
        before <= far and bool(np.fmin(after, errors[-1]) > most * before)
        for most, before, after, far in zip(worst, errors[:-1], errors[1:], farthest, strict=True)
    ]


def motions_of(
    comparison: Comparison,
    runs: LogsByPurpose,
    allowed: BoolArray | None,
    *,
    controller: Controllers = None,
    simulated: Log | None = None,
) -> tuple[SimulatedMotion, ...]:
    """Motion of the simulated axis with each model of a comparison, at the position next to each drive.

    `runs` are the logs for identification, from which controllers are read, and for validation. `allowed`, of shape
    (n_fine,), are points that took no part in any choice. `simulated` is a log of the user's own simulator under the
    same reference; it then replaces the nominal model.
    """
    record, states = comparison.record, comparison.states
    seen = list(parts_of(record, runs.validation or runs.identification, allowed))
    logs = [[replace(part, drive=d) for d in range(record.n_drives)] for part in seen]
    whole = [Part(log, np.ones(log.n_samples, dtype=bool), record) for log in runs.identification.parts]
    models = [state for state in states[1:] if state is not None]
    drivers = drivers_of(record, whole, models, controller)
    found = [
        None if state is None else errors_of_axis(partial(axis_with_effects, state), logs, drivers)
        for state in states
    ]
    if simulated is not None and len(logs) == 1 and runs.validation is None and _is_like(simulated, logs[0]):
        times = since_begin(simulated)
        found[0] = [
            _compared([part], [np.interp(since_begin(part.log), times, simulated[part.signal])], "")
            for part in logs[0]
        ]
    return tuple(
        motion_next_to(
            drivers[d], [log[d] for log in logs], [None if errors is None else errors[d] for errors in found]
        )
        for d in range(record.n_drives)
    )


def drivers_of(
    record: Record, whole: Sequence[Part], models: Sequence[State], controller: Controllers = None
) -> list[Driver]:
    """The controller or observer of each drive, as given, or identified from whole logs."""
    given: Sequence[Cascade | None] = [None] * record.n_drives
    if controller is not None:
        given = (controller,) * record.n_drives if isinstance(controller, Cascade) else tuple(controller)
    if len(given) != record.n_drives:
        raise SettingError(
            f"there are {len(given)} controllers and {record.n_drives} drives: give one controller for each drive"
        )
    inertia = max(state.inertia for state in models)  # a model without an effect may have lost it
    return [
        driver_of(
            record,
            [replace(part, drive=d) for part in whole],
            given[d],
            inertia,
            max(_falling_stiffness(state, replace(whole[0], drive=d)) for state in models),
        )
        for d in range(record.n_drives)
    ]


def _falling_stiffness(state: State, part: Part) -> float:
    """`falling_stiffness` of a model; 0 where the axis with its values cannot be simulated."""
    try:
        with np.errstate(all="ignore"):
            found = falling_stiffness(axis_with_effects(state), part)
    except (SymidError, np.linalg.LinAlgError, ArithmeticError, ValueError):
        return 0.0
    return found if math.isfinite(found) else 0.0


def motion_next_to(
    driver: Driver, parts: Sequence[Part], found: Sequence[MotionError | None]
) -> SimulatedMotion:
    """The motion next to one drive; errors of the nominal and the re-identified model, and of those with effects."""
    nominal, reidentified, *steps = found
    assert reidentified is not None
    effects = tuple(error for error in steps if error is not None)
    errors = [part.reference[part.used] - part.position[part.used] for part in parts if part.has_reference]
    return SimulatedMotion(
        signal=parts[0].signal,
        unit=str(parts[0].record.dynamics.axis.signal_units[parts[0].signal]),
        driver=driver.kind,
        gains={
            "Kpp": driver.cascade.position_gain,
            "Kpv": driver.cascade.velocity_gain,
            "Kiv": driver.cascade.integral_gain,
        },
        share=driver.share,
        tracking_rms=_rms(np.concatenate(errors)) if errors else math.nan,
        nominal=nominal,
        reidentified=reidentified,
        explained=effects[-1] if effects else reidentified,
        steps=effects,
    )


def errors_of_axis(
    axis: Callable[[], ExplainedAxis], logs: Sequence[Sequence[Part]], drivers: Sequence[Driver]
) -> list[MotionError]:
    """Motion errors next to each drive, in logs that have a part for each; a failed simulation is a status."""
    away = [MotionError("failed", message="the simulated axis runs away")] * len(drivers)
    try:
        with np.errstate(all="ignore"):
            explained = axis()
            simulated = [simulated_positions(explained, parts, drivers) for parts in logs]
    except LogError:  # no log holds such positions
        return away
    except (SymidError, np.linalg.LinAlgError, ArithmeticError, ValueError) as error:
        return [MotionError("failed", message=str(error))] * len(drivers)
    if not all(map(_stays_near, chain(*logs), chain(*simulated))):
        return away
    message = "; ".join(explained.left_out)
    return [
        _compared([parts[d] for parts in logs], [positions[d] for positions in simulated], message)
        for d in range(len(drivers))
    ]


def _stays_near(part: Part, position: FloatArray) -> bool:
    """Whether a simulated axis stays near the range of the measured one."""
    away = np.abs(position - part.position).max()
    return bool(away < _AWAY * np.ptp(part.position))  # False for nan too


def _is_like(simulated: Log, parts: Sequence[Part]) -> bool:
    """Whether a simulator's log has the duration of a machine's log, and equal references as far as both have them."""
    log = parts[0].log
    durations = [one.n_samples * one.sampling_period for one in (simulated, log)]
    if abs(durations[0] - durations[1]) > _SAME * durations[1]:
        return False
    for part in (part for part in parts if part.has_reference and part.reference_column in simulated.signals):
        other = np.interp(since_begin(log), since_begin(simulated), simulated[part.reference_column])
        if np.abs(other - part.reference).max() > _SAME * np.ptp(part.reference):
            return False
    return True


def _compared(parts: Sequence[Part], simulated: Sequence[FloatArray], message: str) -> MotionError:
    """Errors of simulated positions, velocities and tracking errors over all parts."""
    pairs = list(zip(parts, simulated, strict=True))
    positions = [(part.position[part.used], found[part.used]) for part, found in pairs]
    speeds = [(part.speed[part.used], part.speed_of(found)[part.used]) for part, found in pairs]
    turns = [(part.position - found)[part.used & part.near_reversal] for part, found in pairs]
    tracking = [
        (part.reference[part.used] - position, part.reference[part.used] - found)
        for (part, _), (position, found) in zip(pairs, positions, strict=True)
        if part.has_reference
    ]
    return MotionError(
        status="ok",
        position_fit=_fit(positions),
        velocity_fit=_fit(speeds),
        tracking_fit=_fit(tracking),
        position_rms=_rms(np.concatenate([one - other for one, other in positions])),
        velocity_rms=_rms(np.concatenate([one - other for one, other in speeds])),
        reversal_rms=_rms(np.concatenate(turns)),
        message=message,
    )


def _fit(pairs: Sequence[tuple[FloatArray, FloatArray]]) -> float:
    """Fit of simulated to measured values in per cent; nan if these are constant or missing."""
    if not pairs:
        return math.nan
    measured, simulated = (np.concatenate(values) for values in zip(*pairs, strict=True))
    return fit_percent(measured, simulated)


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2))) if values.size else math.nan
