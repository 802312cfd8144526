"""The gap of a comparison: the force error of its models before and after, near reversals, and in each repetition."""

from __future__ import annotations

import numpy as np

from symid.diagnosis.findings.comparison import Comparison
from symid.diagnosis.findings.gap import Gap, NotRepeated, Reversal
from symid.diagnosis.findings.repetition import repetition
from symid.diagnosis.findings.shares import closed_fraction, closed_interval
from symid.diagnosis.prediction.reversal import near

_FEW = 8
"""Least number of rows near reversals that show the level of their errors."""


def gap_of(comparison: Comparison) -> Gap:
    """The force error of the models of a comparison."""
    axis, signal = comparison.record.dynamics.axis, comparison.record.forces[comparison.drive]
    re, explained = comparison.squares(1), comparison.squares(len(comparison.errors) - 1)
    return Gap(
        signal=signal,
        unit=str(axis.signal_units[signal]),
        band_hz=_half_power_hz(comparison),
        nominal=None if comparison.errors[0] is None else comparison.level(0),
        reidentified=comparison.level(1),
        explained=comparison.level(len(comparison.errors) - 1),
        noise_floor=comparison.level_of(comparison.floor),
        steps=tuple(comparison.level(i) for i in range(2, len(comparison.errors))),
        closed_fraction=closed_fraction(re, explained, comparison.floor),
        closed_interval=closed_interval(re, explained, comparison.floor),
        unexplained_share=comparison.unexplained_share,
        reversal=_reversal(comparison),
        not_repeated=_not_repeated(comparison),
    )


def _reversal(comparison: Comparison) -> Reversal | None:
    """Force error near reversals; None where the log has none."""
    turning = near(comparison.turns, comparison.row_rate)[comparison.weighting.kept]
    if turning.sum() < _FEW:
        return None
    re, explained = (
        comparison.level_of(float(np.sqrt(np.mean(comparison.squares(i)[turning]))))
        for i in (1, len(comparison.errors) - 1)
    )
    return Reversal(re, explained)


def _not_repeated(comparison: Comparison) -> NotRepeated | None:
    """Part of the last model's force error that differs in each repetition; None if the motion does not repeat."""
    record, inside = comparison.record, comparison.record.rows_in_log
    errors = comparison.errors[-1]
    if errors is None:
        return None
    motion, error = record.rows(comparison.motion)[inside], np.nan_to_num(errors[comparison.drive])[inside]
    found = repetition(motion, error, comparison.weighting.kept[inside])
    if found is None:
        return None
    return NotRepeated(found.rows / comparison.row_rate, comparison.level_of(found.rms))


def _half_power_hz(comparison: Comparison) -> float:
    """Frequency at which the weight of the force error has fallen by 3 dB."""
    fallen = np.flatnonzero(comparison.relative_density < np.sqrt(0.5))
    bins = fallen[fallen > 8]
    return float(comparison.record.omega[bins[0]] / (2 * np.pi)) if bins.size else comparison.record.band_hz
