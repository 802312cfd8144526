"""Faults of the recording, which are looked for before physics."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from symid.arrays import FloatArray
from symid.data import Log
from symid.diagnosis.comparison import Comparison
from symid.diagnosis.search import Turn

_CLIPPED_RUN = 5
_CLIPPED_SHARE = 0.002
_WHOLE_SAMPLE = 0.15


def recording_faults(comparison: Comparison, log: Log, accepted: Sequence[Turn]) -> tuple[str, ...]:
    """What is wrong with the recording rather than with the model.

    Parameters
    ----------
    comparison : Comparison
        Models on the validation data.
    log : Log
        What was identified from.
    accepted : sequence of Turn
        Effects that were accepted.
    """
    drive = comparison.record.dynamics.axis.drive.signal
    found = [text for name in (drive, *comparison.record.signals) if (text := _clipped(log, name))]
    if accepted:
        base = accepted[0].before
        found += _wrong_signs(base.parameters, comparison)
    for turn in accepted:
        item = turn.confirmed[0].fit.state.placed[-1]
        if item.effect.name == "delay":
            samples = item.shape[0] / log.sampling_period
            whole = abs(samples - round(samples)) < _WHOLE_SAMPLE and round(samples) != 0
            side = "after" if samples > 0 else "before"
            text = f"{drive} acts {abs(samples):.2f} samples {side} its record"
            found.append(text + (": a whole number, so channels may be shifted." if whole else "."))
    return tuple(found)


def _clipped(log: Log, name: str) -> str:
    """A signal that stays at its largest or smallest value."""
    values = log[name]
    for bound, side in ((values.max(), "largest"), (values.min(), "smallest")):
        at = values == bound
        runs = np.diff(np.flatnonzero(np.diff(np.concatenate([[0], at.astype(int), [0]]))))[::2]
        if runs.max(initial=0) >= _CLIPPED_RUN and at.mean() > _CLIPPED_SHARE and not _rests(values):
            return f"{name} stays at its {side} value {bound:.4g} for up to {runs.max()} samples: it may be clipped."
    return ""


def _rests(values: FloatArray) -> bool:
    """Whether the signal repeats values everywhere, as a coarse encoder at rest does."""
    return bool(np.mean(np.diff(values) == 0) > 0.1)


def _wrong_signs(parameters: Mapping[str, float], comparison: Comparison) -> list[str]:
    """Masses that came out negative."""
    plant = comparison.record.dynamics
    masses = plant.parameters_of("mass")
    wrong = [name for name in masses if parameters[name] < 0]
    drive = plant.axis.drive.signal
    return (
        [f"{', '.join(wrong)} came out negative: the sign of {drive} or of a position may be wrong."]
        if wrong
        else []
    )
