"""Whether forces are held from sample to sample: they then act half a sample after their record, without any delay."""

from __future__ import annotations

from symid.diagnosis.effects import LATE_FORCES, DelayEffect, Placed
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.hidden_starts import Start
from symid.diagnosis.selection.confirmation import confirmed_from
from symid.diagnosis.thresholds import THRESHOLDS

HELD = (
    "{} is held from each sample to the next: it acts half a sample after its record, which is accounted for."
)


def shows_hold(fit: Fit) -> bool:
    """Whether a delay of each force by half a sample explains a part of what a model leaves that has none declared."""
    if any(item.effect.name in LATE_FORCES for item in fit.state.placed):
        return False
    return all(_shows_hold(fit, place) for place in DelayEffect().places(fit.state.prediction))


def _shows_hold(fit: Fit, place: str) -> bool:
    """The same of one drive."""
    period = fit.state.prediction.record.log.sampling_period
    found = confirmed_from(fit, Start.of(fit, Placed(DelayEffect(), place, (period / 2,), (1.0,))))
    if (
        found is None
        or found.penalised_gain < THRESHOLDS.least_penalised_gain
        or found.certainty < THRESHOLDS.least_certainty
    ):
        return False
    return is_held(found.fit)


def is_held(fit: Fit) -> bool:
    """Whether the last effect of a model is a delay or a lag of the only force by half a sample."""
    item = fit.state.placed[-1]
    if item.effect.name not in LATE_FORCES or fit.state.prediction.record.n_drives > 1:
        return False
    (time,) = item.shape or item.amplitudes
    return abs(time / fit.state.prediction.record.log.sampling_period - 0.5) < THRESHOLDS.half_sample
