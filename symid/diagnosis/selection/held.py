"""Detection of a held force, which acts half a sample after its record without any delay."""

from symid.diagnosis.effects import LATE_FORCES, DelayEffect, Placed, time_of
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.hidden_starts import Start
from symid.diagnosis.fitting.state import with_effects
from symid.diagnosis.selection.confirmation import confirmed_from
from symid.diagnosis.thresholds import THRESHOLDS

HELD = (
    "{} is held from each sample to the next: it acts half a sample after its record, which is accounted for."
)


def shows_hold(fit: Fit) -> bool:
    """Whether a delay of every force by half a sample explains a part of the error; False if a delay is declared."""
    if any(item.effect.name in LATE_FORCES for item in fit.state.placed):
        return False
    period, places = (
        fit.state.prediction.record.log.sampling_period,
        DelayEffect().places(fit.state.prediction),
    )
    n_before = len(fit.state.placed)
    for place in places:
        found = confirmed_from(fit, Start.of(fit, Placed(DelayEffect(), place, (period / 2,), (1.0,))))
        if (
            found is None
            or found.penalised_gain < THRESHOLDS.least_penalised_gain
            or found.certainty < THRESHOLDS.least_certainty
        ):
            return False
        fit = found.fit
    return all(_is_half_a_sample(item, period) for item in fit.state.placed[n_before:])


def nominal_shows_hold(initial: Fit, reidentified: Fit) -> bool:
    """Whether nominal values leave as little error as re-identified ones once every force acts half a sample late.

    Re-identified values may absorb half a sample, such as the damping of a spring. The nominal values are not fitted:
    if they need only the hold, the force is held. If the hold removes little of their error, another effect is missing.
    """
    if any(item.effect.name in LATE_FORCES for item in initial.state.placed):
        return False
    prediction = initial.state.prediction
    half = prediction.record.log.sampling_period / 2
    holds = (Placed(DelayEffect(), place, (half,), (1.0,)) for place in DelayEffect().places(prediction))
    state = with_effects(initial.state, initial.weighting, (*initial.state.placed, *holds))
    good = (
        THRESHOLDS.nominal_is_good**2
        * Fit(reidentified.state.weighted(initial.weighting), initial.weighting).mean_square
    )
    left = Fit(state, initial.weighting).mean_square
    explains = left - 1 < THRESHOLDS.far_less * (initial.mean_square - 1)
    return explains and left < good < initial.mean_square


def is_held(fit: Fit) -> bool:
    """Whether the last effect of a model is a delay or a lag of the only force by half a sample."""
    record = fit.state.prediction.record
    return record.n_drives == 1 and _is_half_a_sample(fit.state.placed[-1], record.log.sampling_period)


def _is_half_a_sample(item: Placed, period: float) -> bool:
    if item.effect.name not in LATE_FORCES:
        return False
    return abs(time_of(item) / period - 0.5) < THRESHOLDS.half_sample
