"""Starts of the fits of a selection step in stages, the cheapest first.

The likeliest candidates of the screening come first. Costlier starts follow only as long as none explains the error.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import islice

from symid.diagnosis.effects import Effect, Key, Placed
from symid.diagnosis.fitting.acting_forces import law_to_integrate
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.hidden_starts import Start, from_other_places, of_changes, of_grid, of_play
from symid.diagnosis.fitting.state import evaluated
from symid.diagnosis.selection.priors import least_gain
from symid.diagnosis.selection.screening import Candidate, screened
from symid.diagnosis.selection.step import LATE_READING, Confirmed, is_clear
from symid.diagnosis.thresholds import THRESHOLDS

_INTEGRATED = 2
_OTHER_PLACES = 3
_FOLLOWING = 3
_AGAIN = 3
"""Candidates that are fitted from the nominal values too if they explain nearly all."""
_ALWAYS = 3
"""Candidates that are fitted where there is a gap, whatever their projected gain."""


def stages_of_starts(
    fit: Fit,
    found: list[Candidate],
    library: Sequence[Effect],
    nominal: Fit | None,
    confirmed: Mapping[Key, Confirmed],
    tried: Mapping[Key, Placed],
) -> Iterator[Iterable[Start]]:
    """Starts of fits, the cheapest first."""
    # Screening is linear, and the error of a fit may have several minima. After the likeliest candidates with their
    # screened values come starts for other minima: joints integrated with their motion, the nominal model, effects
    # moved to other hidden places, and a grid over the hidden spring.
    promising = _promising(found, fit)
    white = sorted(promising, key=lambda c: -c.white_penalised_gain)
    timing = [c for c in found if c.placed.effect.name == LATE_READING]
    yield [*_of_all_laws(fit, promising[:3]), *of_changes(fit, library)]
    further = _distinct([*promising[3:6], *white[:3], *timing], promising[:3])
    yield _of_all_laws(fit, [*further, *ties(promising, [*promising[:3], *further])])
    if not confirmed:  # the most promising candidates are not credible
        yield [
            Start.of(fit, c.placed)
            for c in _promising([c for c in found if c.placed.key not in tried], fit)[:6]
        ]
    if least_left(confirmed) < THRESHOLDS.hardly * fit.mean_square and nominal is not None:
        # values may still be far off
        yield [Start.of(nominal, c.placed) for c in best_first(confirmed)[:_AGAIN]]
        # No frequency response describes a body that sticks at times, even where its motion is read.
        best, *others = best_first(confirmed)
        alike = (best, *(c for c in others if best.placed.refines(c.key)))
        yield integrated([Start.of(nominal, c.placed) for c in alike], nominal, read=True)
    if _explains(fit, confirmed):
        return
    if nominal is None:
        yield integrated([Start.of(fit, c.placed) for c in promising], fit)[:1]
    else:
        yield from from_nominal(fit, nominal, library, confirmed)
        if not _explains(fit, confirmed):
            yield [*_following(found, fit, confirmed), *of_play(fit, nominal, library)]
        if not _explains(fit, confirmed):
            yield of_grid(fit, nominal, library)


def _of_all_laws(fit: Fit, candidates: Iterable[Candidate]) -> list[Start]:
    """Starts of candidates and of the other laws of their effects."""
    return [Start.of(fit, placed) for c in candidates for placed in (c.placed, *c.others)]


def from_nominal(
    fit: Fit, nominal: Fit, library: Sequence[Effect], confirmed: Mapping[Key, Confirmed]
) -> Iterator[Iterable[Start]]:
    """Starts from the nominal values, the cheapest first."""
    found = screened(nominal, library)
    yield _of_all_laws(nominal, [*found[:4], *(c for c in found[4:] if c.placed.effect.name == LATE_READING)])
    if _explains(fit, confirmed):
        return
    other = [Start.of(nominal, c.placed) for c in found]
    yield integrated(other, nominal, read=True)[:_INTEGRATED]
    yield islice(from_other_places(fit, [c.fit for c in best_first(confirmed)]), _OTHER_PLACES)
    if not _explains(fit, confirmed):
        yield integrated(_relatives(other, confirmed), nominal, read=True)


def _relatives(starts: Sequence[Start], confirmed: Mapping[Key, Confirmed]) -> list[Start]:
    """Starts of relatives of the best candidate that leave more than it, or were not fitted.

    Relatives refine the same simpler effect: one that leaves more may be at a wrong minimum.
    """
    best = next(iter(best_first(confirmed)), None)
    if best is None:
        return []
    plain = {best.key, *(s.placed.key for s in starts if best.placed.refines(s.placed.key))}
    close = {key for key, own in confirmed.items() if own.fit.mean_square <= best.fit.mean_square}
    related = (s for s in starts if s.placed.key not in close and any(map(s.placed.refines, plain)))
    return [replace(s, to_the_end=True) for s in related]


def _explains(fit: Fit, confirmed: Mapping[Key, Confirmed]) -> bool:
    """Whether a candidate takes away nearly all of the error.

    Where motion is predicted it must leave little more than noise too: many a law imitates a spring that stiffens near
    a resonance down to a tenth of its error.
    """
    left = least_left(confirmed)
    clearly_left = left >= THRESHOLDS.clear_gap and has_predicted_joint(fit)
    return left < THRESHOLDS.hardly * fit.mean_square and not clearly_left


def has_predicted_joint(fit: Fit) -> bool:
    """Whether the model determines the deflection of a spring, be it compared with a reading or not."""
    prediction = fit.state.prediction
    return any(prediction.record.is_predicted(joint.direction) for joint in prediction.springs.values())


def integrated(starts: Sequence[Start], model: Fit, *, read: bool = False) -> list[Start]:
    """The starts with joints that are integrated with their motion, where that is possible."""
    hidden = (replace(s, placed=replace(s.placed, integrated=True)) for s in starts)
    return [s for s in hidden if law_to_integrate(model.state.prediction, s.placed, read=read)]


def _following(found: Sequence[Candidate], fit: Fit, confirmed: Mapping[Key, Confirmed]) -> list[Start]:
    """Starts of dry friction whose motion follows the measured force; the law of the best candidate comes first."""
    best = next(iter(best_first(confirmed)), None)
    likely = sorted(found, key=lambda c: best is None or c.placed.effect.name != best.effect.name)
    laws = ((c.placed, law_to_integrate(fit.state.prediction, c.placed, read=True)) for c in likely)
    dry = (replace(placed, integrated=True) for placed, law in laws if law and law.dry)
    state = fit.state.following()
    return [Start(state, fit.weighting, placed) for placed in islice(dry, _FOLLOWING)]


def _promising(found: Sequence[Candidate], fit: Fit) -> list[Candidate]:
    """Candidates with enough gain to be fitted, relative to the best one.

    Where a model leaves much more than noise, the first few are fitted whatever their gain: with few rows, a projection
    whose shapes are only near the right one gains little.
    """
    gains = [max(c.penalised_gain, c.white_penalised_gain) for c in found]
    best = THRESHOLDS.promising * max(gains, default=0.0)
    gap = fit.mean_square > THRESHOLDS.clear_gap
    enough = [
        own
        for own, gain in zip(found, gains, strict=True)
        if gain > max(least_gain(own.placed.effect.name, fit.n_rows) / 2, best)
    ]
    always = list(found[:_ALWAYS]) if gap and len(enough) < _ALWAYS else []
    return [*always, *_distinct(enough, always)]


def best_first(confirmed: Mapping[Key, Confirmed]) -> list[Confirmed]:
    """Confirmed candidates, the largest gain first."""
    return sorted(confirmed.values(), key=lambda c: -c.penalised_gain)


def least_left(confirmed: Mapping[Key, Confirmed]) -> float:
    """Least mean square of the confirmed candidates."""
    return min((c.fit.mean_square for c in confirmed.values()), default=math.inf)


def ties(candidates: Sequence[Candidate], chosen: list[Candidate]) -> list[Candidate]:
    """Candidates that the log hardly distinguishes from chosen ones, such as friction and a constant force one way."""
    alike = [c for c in candidates if any(abs(c.gain - own.gain) < THRESHOLDS.alike for own in chosen)]
    return _distinct(alike, chosen)


def _distinct(candidates: list[Candidate], others: list[Candidate]) -> list[Candidate]:
    kept: list[Candidate] = []
    for candidate in candidates:
        if not any(candidate is c for c in (*others, *kept)):
            kept.append(candidate)
    return kept


def simpler_effects(
    fit: Fit, found: Sequence[Candidate], confirmed: Mapping[Key, Confirmed]
) -> Iterator[Start]:
    """Simpler effects that confirmed ones refine, from the values of these, where their own fits are far worse.

    In hidden motion the refinement may have begun where the simpler effect did not.
    """
    for own in confirmed.values():
        item = own.placed
        for placed in (c.placed for c in found if item.refines(c.placed.key)):
            plain = confirmed.get(placed.key)
            if plain is None or own.fit.mean_square < THRESHOLDS.far_less * plain.fit.mean_square:
                amplitudes = item.amplitudes[: len(placed.amplitudes)]
                simpler = Start.with_values_of(own.fit, fit, replace(placed, amplitudes=amplitudes))
                yield next(iter(integrated([simpler], fit)), simpler)


def refinements(fit: Fit, found: Sequence[Candidate], confirmed: Mapping[Key, Confirmed]) -> Iterator[Start]:
    """Refinements of the best candidate on hidden motion that leaves a clear gap, from its values."""
    best = next(iter(best_first(confirmed)), None)
    if best is None or not (best.placed.integrated and is_clear(best.fit)):
        return
    begun = Start.with_values_of(best.fit, fit, best.placed)
    for placed in (c.placed for c in found if c.placed.refines(best.key)):
        own = confirmed.get(placed.key)
        if own is None or best.fit.mean_square < THRESHOLDS.far_less * own.fit.mean_square:
            amplitudes = best.placed.amplitudes + placed.amplitudes[len(best.placed.amplitudes) :]
            yield replace(begun, placed=replace(placed, amplitudes=amplitudes, integrated=True))


def elsewhere(fit: Fit, found: Sequence[Candidate], confirmed: Mapping[Key, Confirmed]) -> Iterator[Start]:
    """The best effect at other places, where it may explain as much.

    These are places where its fit was given up, and those where it is far from its screening: from the nominal values.
    """
    best = max(confirmed.values(), key=lambda c: c.penalised_gain, default=None)
    if best is None:
        return
    most = THRESHOLDS.give_up * least_left(confirmed)
    given_up = {
        key for key, own in confirmed.items() if key[0] == best.key[0] and own.fit.mean_square >= most
    }
    yield from (Start.of(fit, c.placed) for c in found if c.placed.key in given_up - {best.key})
    moved = list(best.effect.elsewhere(fit.state.prediction, best.placed))
    if moved:
        nominal = {**fit.parameters, **fit.nominal}
        state = evaluated(fit.state, fit.weighting, nominal, fit.state.placed)
        yield from (Start(state, fit.weighting, placed, to_the_end=True) for placed in moved)
