"""Confirmation of screened candidates: fits with all parameters free, their cross-validated gains and their ranking."""

import math
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace

import numpy as np

from symid.diagnosis.effects import Key, LawEffect, Placed
from symid.diagnosis.fitting.acting_forces import law_to_integrate
from symid.diagnosis.fitting.cross_validation import certainty, deviation, log_likelihood
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.gauss_newton import continued, fitted, refitted
from symid.diagnosis.fitting.hidden_starts import Start
from symid.diagnosis.prediction.prediction import Prediction
from symid.diagnosis.selection.credibility import is_credible
from symid.diagnosis.selection.late_forces import compared_in_band
from symid.diagnosis.selection.priors import prior, temperature
from symid.diagnosis.selection.step import LATE_READING, Confirmed
from symid.diagnosis.thresholds import THRESHOLDS
from symid.errors import SettingError

_COULOMB = "coulomb_friction"
_USUAL_OF = {"periodic_disturbance": "cogging", "load_dependent_friction": _COULOMB}
"""Effects that most machines have, by those that look like them in some motions."""
_DIRECT = (4, 4, 3)
_INTEGRATION = (4, 8, 8)
"""Most iterations: until a fit may be given up, after that, and with the weights of the values found."""
_FURTHER = 12
"""Most further iterations of the leading candidates."""


def confirmed_from(
    fit: Fit, start: Start, most: float = math.inf, beside: Sequence[Placed] = ()
) -> Confirmed | None:
    """A candidate fitted from a start, and its gain over the model without it; None if it is not credible.

    The fit stops early if the mean square is still `most` or more, as others leave much less. Effects `beside` are
    known to be present but not yet in the model.
    """
    with _without_impossible_models():
        start = _solved_in_steps(start)
        state = start.best_state()
        if state is None:
            return None
        many = start.placed.integrated or start.to_the_end
        first, further, then = _INTEGRATION if many else _DIRECT
        found = fitted(state, start.weighting, first)
        if found.mean_square < most:
            found = refitted(continued(found, further), then)
        return _judged(fit, found, beside)
    return None


@contextmanager
def _without_impossible_models() -> Iterator[None]:
    """Leave a fit whose steps end in values that no machine has, or in motion that diverges."""
    refused = (SettingError, np.linalg.LinAlgError, OverflowError)
    with suppress(*refused), np.errstate(over="ignore", invalid="ignore"):
        yield


def _solved_in_steps(start: Start) -> Start:
    """The start with an implicit force on predicted motion integrated with it.

    Iterated over a whole log, such a force grows near the resonance of a body and ends in another motion on every log.
    """
    if start.placed.effect.implicit and law_to_integrate(start.state.prediction, start.placed, read=True):
        return replace(start, placed=replace(start.placed, integrated=True))
    return start


def converged_from(fit: Fit, own: Confirmed) -> Confirmed | None:
    """A candidate after further steps, until its error hardly falls; None if it is not credible then."""
    with _without_impossible_models():
        return _judged(fit, refitted(continued(own.fit.released(), _FURTHER), _FURTHER), ())
    return None


def _judged(fit: Fit, found: Fit, beside: Sequence[Placed]) -> Confirmed | None:
    """Cross-validated gain of a model over the model without its last effect, in the weights of the latter.

    A fit that began elsewhere has other weights; errors in these would not compare.
    """
    if not (np.isfinite(found.mean_square) and np.isfinite(found.columns).all()):
        return None
    compared = found
    if not np.array_equal(found.weighting.density, fit.weighting.density):
        weighting = replace(found.weighting, density=fit.weighting.density)
        compared = found.with_weights(found.state.weighted(weighting), weighting)
    blocks = compared.blocks
    if not is_credible(fit, found, blocks, beside):
        return None
    n = found.n_rows
    own, before = blocks.squares, fit.blocks.squares
    grown = (own.sum(axis=1) > THRESHOLDS.spoiled * before.sum(axis=1)) & (found.squares > THRESHOLDS.spoiled)
    gain = log_likelihood(own, n) - log_likelihood(before, n)
    certain, log_prior_odds = certainty(before, own, n), prior(found.state, fit.nominal)
    return Confirmed(found.released(), gain, certain, own, log_prior_odds, spoils=bool(grown.any()))


def ranked(confirmed: Iterable[Confirmed], before: Fit) -> list[Confirmed]:
    """Candidates, the best first, which must have values that the log determines.

    A candidate that spoils another output goes last. A delay of a reading goes before effects that imitate it, which
    leave more than noise. Among indistinguishable places a driven body goes first.
    """
    candidates = compared_in_band(list(confirmed), before)
    driven = before.state.prediction.record.driven_bodies
    best = max(candidates, key=lambda c: c.penalised_gain, default=None)
    clean = best is not None and best.fit.mean_square < THRESHOLDS.explained
    least = (1.0 if clean else THRESHOLDS.timing_first) * (best.penalised_gain if best else 0.0)

    def order(own: Confirmed) -> tuple[bool, bool, float]:
        timing = own.key[0] == LATE_READING and own.penalised_gain > least
        return own.spoils, not timing, -own.penalised_gain - THRESHOLDS.tie * (own.key[1] in driven)

    found = sorted(candidates, key=order)
    while found and not _is_certain(found[0].fit):
        found.pop(0)
    return sorted(found, key=lambda own: not _likelier(own, found[0], before))


def _likelier(own: Confirmed, best: Confirmed, before: Fit) -> bool:
    """Whether a refinement or the usual form of the best candidate that explains as much is likelier beforehand."""
    is_usual = own.key == (_USUAL_OF.get(best.key[0]), best.key[1])
    if not (own.placed.refines(best.key) or is_usual):
        return False
    width = temperature(best.penalised_gain) + THRESHOLDS.gain_deviations * deviation(
        best.squares, own.squares, before.n_rows
    )
    return own.log_prior_odds - best.log_prior_odds + (own.penalised_gain - best.penalised_gain) / width > 0


def _is_certain(fit: Fit) -> bool:
    """Whether each shape of the last effect exceeds its standard deviation."""
    item = fit.state.placed[-1]
    shapes = range(-len(item.shape), 0)
    deviations = fit.released().standard_deviations  # their arrays are not kept
    names = item.effect.shape_names
    return all(
        deviations[i] < abs(item.shape[i]) for i in shapes if names[i] not in item.effect.may_be_undetermined
    )


def prefer_coulomb(confirmed: dict[Key, Confirmed]) -> None:
    """Drop refinements that explain hardly more than the Coulomb friction in them: the next step finds the rest.

    Refinements with a size that the log cannot show are dropped too, such as a reach below the steps of the encoder.
    """
    for name, place in list(confirmed):
        plain, more = confirmed.get((_COULOMB, place)), confirmed[name, place]
        if plain is None or not more.placed.refines(plain.key):
            continue
        spread = deviation(plain.squares, more.squares, plain.fit.n_rows)
        least = THRESHOLDS.deviations * spread
        if plain.fit.mean_square > THRESHOLDS.explained:  # further missing effects may favour it
            least = max(THRESHOLDS.hardly_more * plain.penalised_gain, spread)
        clearly = more.penalised_gain - plain.penalised_gain > least
        clearly = clearly and more.fit.mean_square < plain.fit.mean_square
        prediction = more.fit.state.prediction
        # In integrated motion the instants of jumps are exact: a reach within a sample may explain most of the rest.
        far_less = more.fit.mean_square < THRESHOLDS.far_less * plain.fit.mean_square
        shown = (more.placed.integrated and far_less) or more.effect.is_plausible(prediction, more.placed)
        # A level that explains hardly anything by itself is not the mean of one that varies.
        explains = plain.penalised_gain > THRESHOLDS.level_first * more.penalised_gain
        if not (clearly and shown) or (explains and _is_nearly_constant(prediction, more.placed)):
            del confirmed[name, place]


def _is_nearly_constant(prediction: Prediction, item: Placed) -> bool:
    """Whether a friction level that varies along the stroke varies by less than some tens of percent."""
    effect = item.effect
    if not (isinstance(effect, LawEffect) and effect.varies_along_stroke):
        return False
    level = effect.level(prediction.joints[item.at], item.shape, item.amplitudes)
    course = level[prediction.record.in_log]
    low, high = float(course.min()), float(course.max())  # a mean would count where the axis rests
    return high - low < THRESHOLDS.varies * abs(high + low)
