"""A step of the selection: its candidates, and the criteria by which the best is accepted."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symid.arrays import FloatArray
from symid.diagnosis.effects import LATE_FORCES, Effect, Key, Placed, is_presliding_part
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.gauss_newton import fitted_on
from symid.diagnosis.fitting.start import from_other_moments
from symid.diagnosis.fitting.state import State
from symid.diagnosis.prediction.weighting import Weighting
from symid.diagnosis.selection.priors import least_gain
from symid.diagnosis.selection.screening import Candidate
from symid.diagnosis.thresholds import THRESHOLDS

LATE_READING = "sensor_delay"


@dataclass(frozen=True, eq=False)
class Confirmed:
    """A candidate fitted with all parameters free."""

    fit: Fit  # the model with it
    gain: float  # of the cross-validated log-likelihood over the model without it
    certainty: float  # probability that it predicts blocks left out better than the model without it
    squares: FloatArray  # shape (n_outputs, n_blocks): sum of squared errors of each block when left out
    log_prior_odds: float = 0.0
    spoils: bool = False  # whether it greatly increases the error of another output

    @property
    def penalised_gain(self) -> float:
        """The gain less the penalty of the free values."""
        return self.gain - THRESHOLDS.penalty * self.placed.n_free

    def beside(self, best: Confirmed, found: Confirmed) -> Confirmed:
        """A rival of `best` at the same distance, block by block, from `found`, which replaces `best`."""
        share = found.squares.sum(axis=1) / best.squares.sum(axis=1)
        squares = found.squares + (self.squares - best.squares) * share[:, None]
        return replace(self, gain=found.gain + self.gain - best.gain, squares=squares)

    @property
    def placed(self) -> Placed:
        """The effect added, with its place and values."""
        return self.fit.state.placed[-1]

    @property
    def effect(self) -> Effect:
        """The effect that this candidate adds to the model."""
        return self.placed.effect

    @property
    def key(self) -> Key:
        """Names of effect and place."""
        return self.placed.key


@dataclass(frozen=True, eq=False)
class SelectionStep:
    """One step of the selection."""

    before: Fit  # the model without the effect of this step
    confirmed: tuple[Confirmed, ...]  # candidates that were fitted, the largest gain first
    screened: tuple[Candidate, ...]  # all candidates
    # effects and places that were fitted but not confirmed, mostly because the values found are not credible
    refused: frozenset[Key] = frozenset()
    # whether gains are relative to the model with all other effects, not to the model before
    beside_others: bool = False

    @property
    def best(self) -> Confirmed:
        """The candidate of the largest gain; there must be one."""
        return self.confirmed[0]

    @property
    def accepts(self) -> bool:
        """Whether the best candidate is accepted."""
        return bool(self.confirmed) and (self.beside_others or self._accepts(self.best))

    def _accepts(self, own: Confirmed) -> bool:
        closed = _taken(self.before, own.fit, self.before)
        least = least_gain(own.effect.name, self.before.n_rows)
        gains = own.penalised_gain > least and closed > THRESHOLDS.least_share
        # A model with a lower gain from the encoder's noise to the force has a lower error for that alone. If the model
        # before leaves noise only, the error must fall relative to the noise of each model too.
        explains = is_more_than_noise(self.before) or own.fit.mean_square < self.before.mean_square
        return gains and explains and own.certainty > THRESHOLDS.least_certainty

    def with_acceptable(self) -> SelectionStep:
        """The step led by its best acceptable candidate, if that gains enough.

        The best candidate may be uncertain because few blocks show it, such as a mass that changes once; it becomes
        certain when other effects are in the model.
        """
        if self.accepts or not self.confirmed:
            return self
        least = THRESHOLDS.beside_best * self.best.penalised_gain
        found = [own for own in self.confirmed if own.penalised_gain > least and self._accepts(own)]
        if not found:
            return self
        return self.led_by(found[0])

    def whole_before_part(self) -> tuple[SelectionStep, ...]:
        """The step led by Coulomb friction in place of presliding friction that leaves more than noise; else empty.

        Where only a part of the friction builds up over a displacement, presliding friction alone finds a wrong reach;
        beside Coulomb friction all reaches are tried. Rivals keep their distance.
        """
        if not self.accepts or self.best.fit.mean_square < THRESHOLDS.explained:
            return ()
        return self._with_first(
            own for own in self.confirmed if is_presliding_part(self.best.placed, own.placed)
        )

    def plain_before_refined(self) -> tuple[SelectionStep, ...]:
        """The step led by Coulomb friction in place of a friction that refines it and leaves a clear gap; else empty.

        The refinement may explain the error of another law: Stribeck friction falls with speed, drag rises with it.
        Rivals keep their distance.
        """
        if not (self.accepts and is_clear(self.best.fit)):
            return ()
        plain = ("coulomb_friction", self.best.placed.at)
        refines = self.best.placed.refines(plain)
        return self._with_first(own for own in self.confirmed if refines and own.key == plain)

    def _with_first(self, others: Iterable[Confirmed]) -> tuple[SelectionStep, ...]:
        """The step led by the first of some candidates, if it is acceptable; rivals keep their distance to the best."""
        first = next(iter(others), None)
        if first is None or not self._accepts(first):
            return ()
        best, *rivals = self.confirmed
        behind = (own.beside(best, first) for own in rivals if own is not first)
        return (replace(self, confirmed=(first, best, *behind)),)

    def led_by(self, own: Confirmed) -> SelectionStep:
        """The step with another of its candidates first."""
        return replace(self, confirmed=(own, *(other for other in self.confirmed if other is not own)))

    def fitted_on(self) -> SelectionStep:
        """The step with its best model fitted until the error hardly falls."""
        best, *others = self.confirmed
        return replace(self, confirmed=(replace(best, fit=fitted_on(from_other_moments(best.fit))), *others))

    def other_timing(self) -> tuple[SelectionStep, ...]:
        """Steps led by the lag in place of the delay, or the other way round, if its gain is comparable.

        The two differ at high frequencies, where effects that are not yet in the model may decide wrongly: a lag
        explains more of an encoder ripple than a delay does.
        """
        if not self.accepts or self.best.effect.name not in LATE_FORCES:
            return ()
        least = THRESHOLDS.other_timing * self.best.penalised_gain
        at = self.best.placed.at
        others = [own for own in self.confirmed[1:] if own.effect.name in LATE_FORCES and own.placed.at == at]
        return tuple(self.led_by(own) for own in others if own.penalised_gain > least and self._accepts(own))

    def justifies_another(self, first: Fit) -> bool:
        """Whether the best candidate is justified besides others; `first` is the model that all effects explain."""
        if not self.accepts:
            return False
        return takes(self.before, self.best.fit, first)


def accepted_of(steps: Sequence[SelectionStep]) -> list[SelectionStep]:
    """The steps whose best candidate is accepted."""
    return [step for step in steps if step.accepts]


def fits_of(base: Fit, steps: Sequence[SelectionStep]) -> list[Fit]:
    """The re-identified model, and those with effects accepted one by one."""
    return [base, *(step.best.fit for step in accepted_of(steps))]


def takes(before: Fit, after: Fit, first: Fit) -> bool:
    """Whether an effect besides others removes enough error; `first` is the model that all effects explain."""
    most = float(np.max(before.squares - after.squares_as_weighted_by(before))) / before.squares.size
    of_first, of_rest = _taken(before, after, first), _taken(before, after, before)
    if is_clear(before):
        counts = of_rest > THRESHOLDS.least_of_rest
    else:
        counts = is_more_than_noise(before) and _excess(after) < (1 - THRESHOLDS.nearly_all) * _excess(before)
    return most > THRESHOLDS.least_power and (counts or of_first > THRESHOLDS.least_of_first)


def penalised_likelihood(steps: Sequence[SelectionStep], state: State, weighting: Weighting) -> float:
    """Cross-validated log-likelihood of a model after some steps, less the penalties of the effects added."""
    added = state.placed[len(steps[0].before.state.placed) :]
    return Fit(state.weighted(weighting), weighting).predicted - THRESHOLDS.penalty * sum(
        item.n_free for item in added
    )


def is_clear(left: Fit) -> bool:
    """Whether a model leaves much more than noise."""
    return left.mean_square > THRESHOLDS.clear_gap


def is_more_than_noise(left: Fit) -> bool:
    """Whether a model leaves more than noise, but perhaps little more."""
    return left.mean_square > THRESHOLDS.fit_of_noise


def _excess(fit: Fit) -> float:
    """Mean square above that of noise."""
    return max(fit.mean_square - 1, 0.0)


def _taken(before: Fit, after: Fit, first: Fit) -> float:
    """Share of a first model's error that an effect removes: of the mean over outputs, or the mean of the shares.

    In multiples of the noise, the error of one output may be thousands of times that of another and would hide it.
    """
    taken = before.squares - after.squares_as_weighted_by(before)
    return float(max(np.mean(taken / first.squares), np.mean(taken) / first.mean_square))
