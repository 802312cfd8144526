"""The gap as it is seen in the motion: each model simulated under the controller of the log, beside the machine."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symid.arrays import BoolArray, FloatArray
from symid.data import REFERENCE, Log
from symid.diagnosis.findings.comparison import Comparison
from symid.diagnosis.findings.gap import Motion, MotionError
from symid.diagnosis.findings.result import Diagnosis
from symid.diagnosis.findings.wording import sentence_of_motion
from symid.diagnosis.fitting.state import State
from symid.diagnosis.in_motion.declared import axis_of
from symid.diagnosis.in_motion.replayed import (
    Driver,
    Part,
    driver_of,
    parts_of,
    simulated_position,
    since_begin,
)
from symid.diagnosis.prediction.joined import Joined
from symid.errors import SymidError
from symid.simulation import Cascade

_SAME = 0.01
"""Difference of two references relative to the stroke, and of two durations, up to which both are the same."""
_NOT_SIMULATED = "The gap is that of the forces: the motion of an axis with several drives is not simulated."
_AWAY = 10.0
"""Distance from the measured position, in its ranges, from which on a simulated axis runs away."""


def with_motion(
    found: Diagnosis,
    comparison: Comparison,
    runs: tuple[Joined, Joined | None],
    allowed: BoolArray | None,
    *,
    controller: Cascade | None = None,
    simulated: Log | None = None,
) -> Diagnosis:
    """A diagnosis with its gap in the motion, which its sentence tells too; see `motion_of`.

    An axis with several drives is not simulated.
    """
    if comparison.record.n_drives > 1:
        return replace(found, assumptions=(*found.assumptions, _NOT_SIMULATED))
    models = comparison.with_effects(len(found.effects))
    motion = motion_of(models, runs, allowed, controller=controller, simulated=simulated)
    return replace(
        found,
        gap=replace(found.gap, motion=motion),
        sentence=f"{found.sentence}{sentence_of_motion(motion)}",
    )


def motion_of(
    comparison: Comparison,
    runs: tuple[Joined, Joined | None],
    allowed: BoolArray | None,
    *,
    controller: Cascade | None = None,
    simulated: Log | None = None,
) -> Motion:
    """How the simulated axis moves with each model of a comparison.

    Parameters
    ----------
    comparison : Comparison
        Nominal model or None, re-identified model, and those with effects.
    runs : tuple of Joined
        Logs for identification, from which a controller is read, and for validation if there are any.
    allowed : bool array of shape (n_fine,), optional
        Points of the fine grid of the comparison's record that took no part in any choice.
    controller : Cascade, optional
        That of the machine; read from the log if it is not given.
    simulated : Log, optional
        Run of the user's own simulator under the reference of the log: then that is the nominal model.
    """
    record = comparison.record
    parts = list(parts_of(record, runs[1] or runs[0], allowed))
    whole = [Part(log, np.ones(log.n_samples, dtype=bool), record) for log in runs[0].parts]
    driver = driver_of(record, whole, controller, comparison.states)
    found = [None if state is None else _error(state, parts, driver) for state in comparison.states]
    nominal, reidentified, *steps = found
    if simulated is not None and len(parts) == 1 and runs[1] is None and _is_like(simulated, parts[0]):
        nominal = _compared(parts, [_at_samples(simulated, parts[0])], "")
    effects = tuple(error for error in steps if error is not None)
    assert reidentified is not None
    errors = [part.reference[part.used] - part.position[part.used] for part in parts if part.has_reference]
    return Motion(
        signal=record.signals[0],
        unit=str(record.dynamics.axis.signal_units[record.signals[0]]),
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


def _error(state: State, parts: Sequence[Part], driver: Driver) -> MotionError:
    """How the axis of a model moves; what fails is a status."""
    try:
        with np.errstate(all="ignore"):
            explained = axis_of(state)
            simulated = [simulated_position(explained, part, driver) for part in parts]
    except (SymidError, np.linalg.LinAlgError, ArithmeticError, ValueError) as error:
        return MotionError("failed", message=str(error))
    if not all(map(_stays, parts, simulated)):
        return MotionError("failed", message="the simulated axis runs away")
    return _compared(parts, simulated, "; ".join(explained.left_out))


def _stays(part: Part, position: FloatArray) -> bool:
    """Whether a simulated axis stays near the range of the measured one."""
    away = np.abs(position - part.position).max()
    return bool(away < _AWAY * np.ptp(part.position))  # False for nan too


def _is_like(simulated: Log, part: Part) -> bool:
    """Whether a simulator's log has the duration of a log of the machine, and its reference where both have one."""
    durations = [log.n_samples * log.sampling_period for log in (simulated, part.log)]
    if abs(durations[0] - durations[1]) > _SAME * durations[1]:
        return False
    if not (part.has_reference and REFERENCE in simulated.signals):
        return True
    other = np.interp(since_begin(part.log), since_begin(simulated), simulated[REFERENCE])
    return bool(np.abs(other - part.reference).max() <= _SAME * np.ptp(part.reference))


def _at_samples(simulated: Log, part: Part) -> FloatArray:
    """Position of a simulator's log at the samples of another."""
    return np.asarray(
        np.interp(since_begin(part.log), since_begin(simulated), simulated[part.record.signals[0]])
    )


def _compared(parts: Sequence[Part], simulated: Sequence[FloatArray], message: str) -> MotionError:
    """Positions, velocities and tracking errors of all parts beside the simulated ones."""
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
    """Fit of the second of each pair to the first in per cent, nan where that is constant or there is none."""
    if not pairs:
        return math.nan
    measured, simulated = (np.concatenate(values) for values in zip(*pairs, strict=True))
    size = float(np.linalg.norm(measured - measured.mean()))
    return 100.0 * (1.0 - float(np.linalg.norm(measured - simulated)) / size) if size else math.nan


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2))) if values.size else math.nan
