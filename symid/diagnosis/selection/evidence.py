"""Probabilities of the candidates, and the verdict.

If the model were exact except for noise, the gain of a candidate in log-likelihood would be the logarithm of its odds.
The laws of a real axis, and of another simulator, differ a little from the model. Gains are therefore divided by a
temperature that grows with the largest gain (tempered likelihood): candidates that explain nearly the same are nearly
equally probable.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from symid.diagnosis.effects import Key, with_equivalents
from symid.diagnosis.fitting.cross_validation import deviation
from symid.diagnosis.selection.priors import is_of_new_friction, least_gain, temperature
from symid.diagnosis.selection.step import SelectionStep, accepted_of
from symid.diagnosis.thresholds import THRESHOLDS

_HALF = 0.5

Verdict = Literal["no_gap", "parameters", "effect", "partly", "unexplained", "recording"]


def probabilities(step: SelectionStep, beside: Collection[Key] = ()) -> dict[Key, float]:
    """Probability of each candidate of a step, given that one of them is right; the most probable first.

    Among indistinguishable places a driven body is a little more probable, and for an asymmetry of friction a body
    whose missing friction was found too. Candidates equal or equivalent to `beside`, the other effects of the whole
    model, are excluded.
    """
    chance = _of_candidates(step, beside)
    present = with_equivalents(beside)
    best = step.best.key if step.confirmed else None
    left = {key: p for key, p in chance.items() if key == best or key not in present}
    total = math.fsum(left.values())
    return {key: p / total for key, p in left.items()}


def _of_candidates(step: SelectionStep, beside: Collection[Key]) -> dict[Key, float]:
    """Probability of each candidate of a step, those of `beside` included."""
    prediction = step.before.state.prediction
    gains = _penalised_gains(step)
    least = min(gains.values(), default=0.0)
    for candidate in step.screened:
        put_aside = any(candidate.placed.refines(own.key) for own in step.confirmed)
        if not put_aside:  # a refinement that explains no more than the simpler effect is not a candidate
            gains.setdefault(candidate.placed.key, min(candidate.penalised_gain, least))
    if not gains:
        return {}
    best = max(gains.values())
    deviations = _gain_deviations(step)
    likelier = {c.key: c.log_prior_odds for c in step.confirmed}
    logits = {
        key: (value - best) / (temperature(best) + deviations.get(key, 0.0))
        + THRESHOLDS.driven_bonus * (key[1] in prediction.record.driven_bodies)
        + THRESHOLDS.friction_there * is_of_new_friction(prediction, key, beside)
        + likelier.get(key, 0.0)
        + THRESHOLDS.refused * (key in step.refused)
        for key, value in gains.items()
    }
    total = math.fsum(math.exp(x) for x in logits.values())
    return dict(sorted(((k, math.exp(x) / total) for k, x in logits.items()), key=lambda item: -item[1]))


def _penalised_gains(step: SelectionStep) -> dict[Key, float]:
    """Penalised gain of each candidate that was fitted.

    A linear candidate that contains a simpler one, as asymmetric friction contains a constant force, gains at least
    as much less the penalty of its further values: with these at 0 it is the simpler one.
    """
    gains = {c.key: c.penalised_gain for c in step.confirmed}
    for own in step.confirmed:
        for other in step.confirmed:
            if not own.placed.shape and own.placed.refines(other.key):
                further = own.placed.n_free - other.placed.n_free
                gains[own.key] = max(gains[own.key], other.penalised_gain - THRESHOLDS.penalty * further)
    return gains


def _gain_deviations(step: SelectionStep) -> dict[Key, float]:
    """Standard deviation of the gain of each fitted candidate relative to the best, by the scatter of blocks."""
    if not step.confirmed:
        return {}
    best = max(step.confirmed, key=lambda c: c.penalised_gain)
    n = step.before.n_rows
    return {c.key: THRESHOLDS.gain_deviations * deviation(best.squares, c.squares, n) for c in step.confirmed}


def probability_of_presence(step: SelectionStep) -> float:
    """Probability that the best candidate of a step is more than noise."""
    if not step.confirmed:
        return 0.0
    best = step.best
    return _logistic((best.penalised_gain - least_gain(best.effect.name, step.before.n_rows)) / 4)


@dataclass(frozen=True)
class Outcome:
    """Probabilities of the verdicts, adding up to 1."""

    # no_gap, parameters, effect, unexplained: probabilities
    no_gap: float
    parameters: float
    effect: float
    unexplained: float
    # whether the effects found are more than noise and remove a considerable share of the gap. They may still replace
    # an effect that the library lacks, the more probably the less they remove
    holds: bool = False

    def at_most(self, effect: float) -> Outcome:
        """The outcome with a limited probability of the effects found; the difference is unexplained."""
        least = min(self.effect, effect)
        return replace(self, effect=least, unexplained=self.unexplained + self.effect - least)

    @property
    def verdict(self) -> Verdict:
        """The most probable verdict; "effect" as soon as the effects found hold."""
        if self.holds:
            return "effect"
        found = {name: p for name, p in self.as_mapping.items() if name != "effect"}
        return max(found, key=lambda name: found[name])

    @property
    def as_mapping(self) -> Mapping[Verdict, float]:
        """Probabilities by verdict."""
        return {
            "no_gap": self.no_gap,
            "parameters": self.parameters,
            "effect": self.effect,
            "unexplained": self.unexplained,
        }


@dataclass(frozen=True)
class Errors:
    """Force errors on the validation data."""

    # nominal, reidentified, explained: in multiples of the noise; nominal is None without nominal values
    nominal: float | None
    reidentified: float
    explained: float
    left: float  # share of the re-identified model's excess that stays; nan if it has none
    stationary: bool = False  # whether the error of the re-identified model is independent of the motion
    # error of the re-identified model relative to the force; inf if it is not known
    relative: float = math.inf
    # largest error of the re-identified model in a reading that it predicts, in multiples of its noise
    others: float = 0.0
    # share of the error above the noise that a law of any shape leaves in the place of the first effect
    nonparametric: float = math.inf

    @property
    def largest(self) -> float:
        """Largest error of the re-identified model, in the force or in a reading."""
        return max(self.reidentified, self.others)


def outcome(steps: Sequence[SelectionStep], validated: int, errors: Errors) -> Outcome:
    """Probabilities of the verdicts; `validated` is the number of effects that hold on the validation data."""
    if not np.isfinite([errors.reidentified, errors.explained]).all():
        return Outcome(0.0, 0.0, 0.0, 1.0)
    there = probability_of_presence(steps[0]) if steps else 0.0
    if not validated or errors.largest <= THRESHOLDS.noise_alone or not _is_likeliest(steps, validated):
        there = min(there, THRESHOLDS.unlikely)
    if errors.largest < THRESHOLDS.white and errors.relative < THRESHOLDS.negligible:
        # the error is small relative to both the noise and the force
        there = min(there, THRESHOLDS.unlikely)
    if errors.largest < _most_of_noise(errors):
        there *= _chance_of_cause(
            errors
        )  # some effect always explains a part of noise, or of errors at reversals
    holds = there * (1 - _chance_of_too_little(errors))
    causes = holds * _chance_of_cause(errors) * (1 - _chance_of_another_law(errors))
    good = 1.0
    if errors.nominal is not None:
        worse = errors.nominal / min(errors.reidentified, errors.nominal)
        good = _logistic((math.log(THRESHOLDS.nominal_is_good) - math.log(worse)) / 0.03)
    excess = min(errors.reidentified / _most_of_noise(errors), errors.relative / THRESHOLDS.negligible)
    fits = _logistic(-math.log(max(excess, 1e-9)) / 0.08)
    # An effect that was found but does not hold is not evidence against a model that leaves hardly more than noise.
    plain = (1 - holds) * fits
    return Outcome(
        no_gap=plain * good,
        parameters=plain * (1 - good),
        effect=causes,
        unexplained=holds - causes + (1 - holds) * (1 - fits),
        holds=holds > _HALF,
    )


def _most_of_noise(errors: Errors) -> float:
    """Largest error that noise leaves, which may be coloured if it is independent of the motion."""
    coloured = errors.stationary and errors.relative < THRESHOLDS.coloured_share
    return THRESHOLDS.coloured if coloured else THRESHOLDS.white


def _is_likeliest(steps: Sequence[SelectionStep], validated: int) -> bool:
    """Whether the first effect found is the most probable candidate or indistinguishable from it."""
    first, *others = [step.best.key for step in accepted_of(steps)][:validated]
    return probabilities(steps[0], others)[first] >= THRESHOLDS.indistinguishable


def _chance_of_cause(errors: Errors) -> float:
    """Probability that an effect found is the true cause and does not stand in for another one."""
    if not np.isfinite(errors.left):
        return 1.0
    if errors.largest < THRESHOLDS.white:
        return _logistic((1 - errors.left - THRESHOLDS.nearly_all) / THRESHOLDS.nearly_width)
    if errors.explained <= THRESHOLDS.noise_alone:
        return 1.0
    return _logistic((1 - errors.left - THRESHOLDS.covered) / THRESHOLDS.covered_width)


def _chance_of_another_law(errors: Errors) -> float:
    """Probability that the true law has another shape than the first effect, and that the library lacks it."""
    share = max(errors.nonparametric, np.finfo(float).tiny)
    clearly = (math.log(THRESHOLDS.outdone) - math.log(share)) / THRESHOLDS.outdone_width
    return THRESHOLDS.outdone_at_most * _logistic(clearly)


def _chance_of_too_little(errors: Errors) -> float:
    """Probability that an effect found is only similar to a cause of the gap: it removes too little."""
    if errors.explained <= THRESHOLDS.noise_alone or not np.isfinite(errors.left):
        return 0.02
    return 0.02 + 0.96 * _logistic((THRESHOLDS.least_removed - (1 - errors.left)) / THRESHOLDS.removed_width)


def _logistic(x: float) -> float:
    return float(1 / (1 + np.exp(-np.clip(x, -40, 40))))
