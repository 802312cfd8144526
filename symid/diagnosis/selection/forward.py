"""Forward selection of the effects that explain the gap: candidates are screened and fitted, the best is accepted."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import islice

from symid.diagnosis.effects import LATE_FORCES, Effect, Key, Placed
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.gauss_newton import fitted, refitted, settled
from symid.diagnosis.fitting.hidden_starts import Start, from_other_places, of_grid
from symid.diagnosis.fitting.state import can_integrate, with_effects
from symid.diagnosis.prediction.weighting import Weighting
from symid.diagnosis.selection.confirmation import confirmed_from, prefer_coulomb, ranked
from symid.diagnosis.selection.late_forces import in_band_of_forces
from symid.diagnosis.selection.priors import least_gain
from symid.diagnosis.selection.screening import Candidate, screened
from symid.diagnosis.selection.step import LATE_READING, Confirmed, SelectionStep, is_more_than_noise
from symid.diagnosis.thresholds import THRESHOLDS

_INTEGRATED = 2
_OTHER_PLACES = 3
_AGAIN = 3
"""Candidates that are fitted from the nominal values too if they explain nearly all."""
_FAR_LESS = 0.5
"""Mean square of a fit relative to that of another of the same effect, below which it is better."""
_ALWAYS = 3
"""Candidates that are fitted where there is a gap, whatever their projected gain."""


def forward_selection(
    fit: Fit, library: Sequence[Effect], nominal: Fit | None = None
) -> tuple[SelectionStep, ...]:
    """Steps of the search: the first, and those that accept their best candidate after it.

    The model before re-identification, `nominal`, is another start where unmodelled effects led the parameters astray.
    """
    fit, nominal = _with_least_inertia(fit, nominal)
    first = _selection_step(fit, library, nominal).with_acceptable()
    if nominal is not None and (better := _restarted(first)) is not None:
        # Once only: each restart weights the errors again, and two solutions might replace each other for ever.
        fit, nominal = _with_least_inertia(better, nominal)
        first = _selection_step(fit, library, nominal).with_acceptable()
    # Greedy, except for two choices: a delay and a lag are nearly the same until further effects are in the model, and
    # presliding friction may be all friction or a part of it. Where one of them comes first, both searches are run to
    # their end, and the better prediction of blocks left out decides.
    timings = first.other_timing()
    branches = [_continued(fit, step, library) for step in (first, *timings, *first.whole_before_part())]
    weighting = in_band_of_forces(fit) if timings else fit.weighting
    return max(branches, key=lambda steps: _penalised_likelihood(steps, weighting))


def _with_least_inertia(fit: Fit, nominal: Fit | None) -> tuple[Fit, Fit | None]:
    """Both models with bounds that keep the axis from losing its inertia."""
    fit = replace(fit, state=fit.state.with_least(1 / THRESHOLDS.least_inertia, fit.nominal))
    return fit, nominal and replace(nominal, state=replace(nominal.state, bounds=fit.state.bounds))


def _restarted(step: SelectionStep) -> Fit | None:
    """The model of a step fitted from the values found with the best candidate; None if the error is hardly lower.

    If the first fit went astray, any effect that corrects its values would be taken for the cause.
    """
    if not step.accepts:
        return None
    fit = step.before
    state = with_effects(step.confirmed[0].fit.state, fit.weighting, fit.state.placed)
    again = fitted(replace(state, bounds=fit.state.bounds), fit.weighting)
    if not again.mean_square < THRESHOLDS.astray * fit.mean_square:
        return None
    return refitted(settled(again)).after(fit)


def _continued(fit: Fit, first: SelectionStep, library: Sequence[Effect]) -> tuple[SelectionStep, ...]:
    """A first step, and the steps after it that accept their best candidate."""
    steps, last = [first], first
    while last.accepts and len(steps) < THRESHOLDS.most_effects:
        current = refitted(settled(last.confirmed[0].fit)).after(fit)
        counts = max(THRESHOLDS.least_power, THRESHOLDS.least_of_first * float(fit.squares.min()))
        if current.mean_square - counts < THRESHOLDS.noise and not is_more_than_noise(current):
            break
        last = _selection_step(current, library, None)
        if not last.justifies_another(fit):
            break
        steps.append(last)
    return tuple(steps)


def _penalised_likelihood(steps: Sequence[SelectionStep], weighting: Weighting) -> float:
    """Cross-validated log-likelihood of the last model, less the penalties."""
    if not steps[-1].confirmed:
        return -math.inf
    state = steps[-1].confirmed[0].fit.state
    added = state.placed[len(steps[0].before.state.placed) :]
    return Fit(state.weighted(weighting), weighting).predicted - THRESHOLDS.penalty * sum(
        item.n_free for item in added
    )


def _selection_step(fit: Fit, library: Sequence[Effect], nominal: Fit | None) -> SelectionStep:
    """Fit the best candidates, and more of them at higher cost as long as none explains the error.

    Where every output errs less than its noise, none is fitted: there is nothing to explain.
    """
    found = screened(fit, library)
    if float(fit.squares.max()) < THRESHOLDS.noise:
        return SelectionStep(fit.released(), (), tuple(found))
    confirmed: dict[Key, Confirmed] = {}
    tried: dict[Key, Placed] = {}
    for stage in _stages(fit, found, library, nominal, confirmed, tried):
        tried |= _confirm(fit, stage, confirmed)
        best = max(confirmed.values(), key=lambda c: c.penalised_gain, default=None)
        if best is not None and best.fit.mean_square < THRESHOLDS.explained:
            break
    # A refinement may imitate its simpler effect, as presliding does Coulomb friction, and a lag is nearly a delay:
    # both are fitted and compared.
    alike = [c.placed for c in found if _is_alike(c.placed.key, tried)]
    tried |= _confirm(fit, [Start.of(fit, placed) for placed in alike], confirmed)
    _confirm(fit, [Start.of(fit, placed) for placed in _elsewhere(found, confirmed)], confirmed, math.inf)
    refused = frozenset(tried.keys() - confirmed.keys())
    prefer_coulomb(confirmed)
    return SelectionStep(fit.released(), tuple(ranked(confirmed.values(), fit)), tuple(found), refused)


def _confirm(
    fit: Fit, starts: Iterable[Start], confirmed: dict[Key, Confirmed], hopeless: float = THRESHOLDS.hopeless
) -> dict[Key, Placed]:
    """Fit candidates, keep the best fit of each in `confirmed`, and return the candidates.

    A fit is given up where it leaves `hopeless` times the least error. A simpler effect that a confirmed one refines is
    always fitted to the end, as the two are compared.
    """
    tried = {}
    for start in starts:
        tried[start.placed.key] = start.placed
        refined = any(other.placed.contains(start.placed.key) for other in confirmed.values())
        most = math.inf if refined else hopeless * _least_left(confirmed)
        own = confirmed_from(fit, start, most)
        if own is not None and (own.key not in confirmed or _is_better(own, confirmed[own.key])):
            confirmed[own.key] = own
    return tried


def _is_better(own: Confirmed, other: Confirmed) -> bool:
    """Whether one fit of an effect is better than another: it leaves far less, or predicts blocks left out better."""
    left, of_other = own.fit.mean_square, other.fit.mean_square
    return left < _FAR_LESS * of_other or (own.gain > other.gain and not of_other < _FAR_LESS * left)


def _is_alike(key: Key, tried: Mapping[Key, Placed]) -> bool:
    """Whether a candidate is a simpler effect than one that was tried, or the delay to a lag, or the reverse."""
    if key in tried:
        return False
    name, at = key
    late = name in LATE_FORCES and any((other, at) in tried for other in LATE_FORCES)
    return late or any(placed.contains(key) for placed in tried.values())


def _elsewhere(found: Sequence[Candidate], confirmed: Mapping[Key, Confirmed]) -> list[Placed]:
    """The best effect in the other joints where its fit was given up: there it may explain as much."""
    best = max(confirmed.values(), key=lambda c: c.penalised_gain, default=None)
    if best is None:
        return []
    most = THRESHOLDS.hopeless * _least_left(confirmed)
    given_up = {
        key for key, own in confirmed.items() if key[0] == best.key[0] and own.fit.mean_square >= most
    }
    return [c.placed for c in found if c.placed.key in given_up - {best.key}]


def _stages(
    fit: Fit,
    found: list[Candidate],
    library: Sequence[Effect],
    nominal: Fit | None,
    confirmed: Mapping[Key, Confirmed],
    tried: Mapping[Key, Placed],
) -> Iterator[Iterable[Start]]:
    """Starts of fits, the cheapest first."""
    # Screening is linear, confirmation is not. The likeliest candidates come first, from the values of their screening;
    # then starts for errors with several minima, each only while nothing explains the error: joints integrated with
    # their motion, the nominal model, effects carried over to other hidden places, a grid over the hidden spring.
    promising = _promising(found, fit)
    white = sorted(promising, key=lambda c: -c.white_penalised_gain)
    timing = [c for c in found if c.placed.effect.name == LATE_READING]
    yield [Start.of(fit, c.placed) for c in promising[:3]]
    yield [Start.of(fit, c.placed) for c in _distinct([*promising[3:6], *white[:3], *timing], promising[:3])]
    if not confirmed:  # the most promising candidates are not credible: others are tried
        yield [
            Start.of(fit, c.placed)
            for c in _promising([c for c in found if c.placed.key not in tried], fit)[:6]
        ]
    if _least_left(confirmed) < THRESHOLDS.hardly * fit.mean_square and nominal is not None:
        # values may still be far off
        yield [Start.of(nominal, c.placed) for c in _best_first(confirmed)[:_AGAIN]]
        # A body that sticks at times moves as no frequency response says, even where its motion is read.
        best, *others = _best_first(confirmed)
        alike = (best, *(c for c in others if best.placed.contains(c.key)))
        yield _integrated([Start.of(nominal, c.placed) for c in alike], nominal, read=True)
    if _explains(fit, confirmed):
        return
    if nominal is None:
        joints = (replace(c.placed, integrated=True) for c in promising if not c.placed.integrated)
        possible = (item for item in joints if can_integrate(fit.state.prediction, item))
        yield [Start.of(fit, item) for item in islice(possible, 1)]
        return
    other = [Start.of(nominal, c.placed) for c in screened(nominal, library)]
    yield [*other[:4], *(s for s in other[4:] if s.placed.effect.name == LATE_READING)]
    if _explains(fit, confirmed):
        return
    yield _integrated(other, nominal)[:_INTEGRATED]
    yield islice(from_other_places(fit, [c.fit for c in _best_first(confirmed)]), _OTHER_PLACES)
    if not _explains(fit, confirmed):
        yield of_grid(fit, nominal, library)


def _explains(fit: Fit, confirmed: Mapping[Key, Confirmed]) -> bool:
    """Whether a candidate takes away nearly all of the error.

    Where motion is hidden it must leave little more than noise too: many a law imitates a spring that stiffens near a
    resonance down to a tenth of its error.
    """
    prediction, left = fit.state.prediction, _least_left(confirmed)
    hidden = any(prediction.record.is_hidden(joint.direction) for joint in prediction.springs.values())
    return left < THRESHOLDS.hardly * fit.mean_square and (left < THRESHOLDS.clear_gap or not hidden)


def _integrated(starts: Sequence[Start], model: Fit, *, read: bool = False) -> list[Start]:
    """The starts with joints that are integrated with their motion, where that is possible."""
    hidden = (replace(s, placed=replace(s.placed, integrated=True)) for s in starts)
    return [s for s in hidden if can_integrate(model.state.prediction, s.placed, read=read)]


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


def _best_first(confirmed: Mapping[Key, Confirmed]) -> list[Confirmed]:
    """Confirmed candidates, the largest gain first."""
    return sorted(confirmed.values(), key=lambda c: -c.penalised_gain)


def _least_left(confirmed: Mapping[Key, Confirmed]) -> float:
    """Least mean square of the confirmed candidates."""
    return min((c.fit.mean_square for c in confirmed.values()), default=math.inf)


def _distinct(candidates: list[Candidate], others: list[Candidate]) -> list[Candidate]:
    kept: list[Candidate] = []
    for candidate in candidates:
        if not any(candidate is c for c in (*others, *kept)):
            kept.append(candidate)
    return kept
