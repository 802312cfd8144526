"""Forward selection of the effects that explain the gap: candidates are screened and fitted, the best is accepted."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain

from symid.diagnosis.effects import LATE_FORCES, Effect, Key, Placed
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.gauss_newton import fitted, refitted, settled
from symid.diagnosis.fitting.hidden_starts import Start
from symid.diagnosis.fitting.state import stable_with_effects
from symid.diagnosis.selection.confirmation import confirmed_from, converged_from, prefer_coulomb, ranked
from symid.diagnosis.selection.evidence import probabilities
from symid.diagnosis.selection.late_forces import in_band_of_forces, other_predicts_better
from symid.diagnosis.selection.screening import Candidate, screened
from symid.diagnosis.selection.stages import (
    best_first,
    elsewhere,
    from_nominal,
    has_predicted_joint,
    integrated,
    least_left,
    refinements,
    simpler_effects,
    stages_of_starts,
)
from symid.diagnosis.selection.step import (
    Confirmed,
    SelectionStep,
    is_clear,
    is_more_than_noise,
    penalised_likelihood,
)
from symid.diagnosis.thresholds import THRESHOLDS

_LEADING = 2
"""Candidates that are fitted until their errors hardly fall, and those of earlier steps that are fitted again."""


def forward_selection(
    fit: Fit, library: Sequence[Effect], nominal: Fit | None = None
) -> tuple[SelectionStep, ...]:
    """Steps of the selection: the first, and the further ones that accept their best candidate.

    Fits also begin at the model before re-identification, `nominal`, if unmodelled effects distorted the parameters.
    """
    fit, nominal = _with_least_inertia(fit, nominal)
    first = _selection_step(fit, library, nominal).with_acceptable()
    if nominal is not None and (better := _restarted(first)) is not None:
        # Only once: each restart changes the weights, and two solutions might alternate for ever.
        fit, nominal = _with_least_inertia(better, nominal)
        first = _selection_step(fit, library, nominal).with_acceptable()
    # The selection is greedy, except where the first choice cannot be decided alone. Branches are then continued to
    # their ends, and the best prediction of blocks left out decides:
    # - a delay and a lag are nearly the same until further effects are in the model (the other one is first fitted in
    #   the place of the first in the final model, and its branch dropped if it predicts worse there);
    # - presliding friction may be all of the friction or a part of it;
    # - if a clear gap stays, Coulomb friction in the place of its refinement.
    # If a clear gap still stays, branches of equally probable candidates count if they leave hardly anything.
    if not first.accepts:
        return _together(fit, first, library, nominal)
    timings = first.other_timing()
    weighting = in_band_of_forces(fit) if timings else fit.weighting
    found = _continued(fit, first, library, nominal)
    others = [step for step in timings if other_predicts_better(step, found, weighting)]
    others += first.whole_before_part()

    def best_of(steps: Sequence[SelectionStep], *others: SelectionStep) -> tuple[SelectionStep, ...]:
        branches = [tuple(steps), *(_continued(fit, step, library, nominal) for step in others)]
        return max(branches, key=lambda own: penalised_likelihood(own, own[-1].best.fit.state, weighting))

    best = best_of(found, *others)
    if is_clear(best[-1].best.fit):
        best = best_of(best, *first.plain_before_refined())
    left = best[-1].best.fit
    tied = (_continued(fit, step, library, nominal) for step in _tied(first) if is_clear(left))
    return next((steps for steps in tied if _leaves_noise(steps, left)), best)


def _tied(step: SelectionStep) -> list[SelectionStep]:
    """The step led by other effects that are as probable as the best one."""
    likely = {key for key, chance in probabilities(step).items() if chance >= THRESHOLDS.indistinguishable}
    return [step.led_by(c) for c in step.confirmed if c.key in likely and c.effect.name != step.best.key[0]]


def _together(
    fit: Fit, first: SelectionStep, library: Sequence[Effect], nominal: Fit | None
) -> tuple[SelectionStep, ...]:
    """An uncertain first effect and those found beside it, if together they leave hardly anything; else the first step.

    Where two effects are as large, hardly a block of the log shows one of them alone.
    """
    begun = _tentative(first)
    steps = _continued(fit, begun, library, nominal) if begun.accepts else (begun,)
    return steps if len(steps) > 1 and _leaves_noise(steps, fit) else (first,)


def _tentative(step: SelectionStep) -> SelectionStep:
    """The step with an uncertain best candidate accepted for now, where a clear gap is left before it."""
    uncertain = step.confirmed and step.best.certainty > THRESHOLDS.least_tentative
    return replace(step, beside_others=True) if uncertain and is_clear(step.before) else step


def _without_tentative(steps: Sequence[SelectionStep]) -> tuple[SelectionStep, ...]:
    """Steps up to an uncertain effect after the first, unless with those found beside it hardly anything is left."""
    at = next((i for i, step in enumerate(steps) if i and step.beside_others), None)
    if at is None or _leaves_hardly_anything(steps[-1].best.fit, steps[at].before):
        return tuple(steps)
    return tuple(steps[:at])


def _leaves_noise(steps: Sequence[SelectionStep], before: Fit) -> bool:
    """Whether the effects of some steps leave hardly anything of the error of another model."""
    last = steps[-1].best.fit if steps[-1].accepts else before
    return _leaves_hardly_anything(last, before) and not is_clear(last)


def _leaves_hardly_anything(left: Fit, before: Fit) -> bool:
    """Whether a model leaves a small share of the error of another one."""
    return left.mean_square < THRESHOLDS.hardly * before.mean_square


def _with_least_inertia(fit: Fit, nominal: Fit | None) -> tuple[Fit, Fit | None]:
    """Both models with bounds that keep the axis from losing its inertia."""
    fit = replace(fit, state=fit.state.with_least(1 / THRESHOLDS.least_inertia, fit.nominal))
    return fit, nominal and replace(nominal, state=replace(nominal.state, bounds=fit.state.bounds))


def _restarted(step: SelectionStep) -> Fit | None:
    """The model of a step fitted from the values found with the best candidate; None if the error is hardly lower.

    If the first fit ended in a wrong minimum, any effect that leads out of it would look like the cause.
    """
    if not step.accepts:
        return None
    fit = step.before
    state = stable_with_effects(step.best.fit.state, fit.weighting, fit.state.placed)
    if state is None:
        return None
    again = fitted(replace(state, bounds=fit.state.bounds), fit.weighting)
    if not again.mean_square < THRESHOLDS.astray * fit.mean_square:
        return None
    return refitted(settled(again)).after(fit)


def _continued(
    fit: Fit, first: SelectionStep, library: Sequence[Effect], nominal: Fit | None
) -> tuple[SelectionStep, ...]:
    """A first step, and the steps after it that accept their best candidate.

    A law in a joint whose motion is predicted may be found from the nominal values only, as the fitted ones have taken
    over a part of it. They are tried, with the effects found, before the selection ends with a gap or accepts a law
    that imitates another.
    """
    steps, last = [first], first
    while last.accepts and len(steps) < THRESHOLDS.most_effects:
        current = refitted(settled(last.best.fit)).after(fit)
        counts = max(THRESHOLDS.least_power, THRESHOLDS.least_of_first * float(fit.squares.min()))
        if current.mean_square - counts < THRESHOLDS.noise and not is_more_than_noise(current):
            break
        last = _selection_step(current, library, None, steps)
        resumes = has_predicted_joint(current) and current.mean_square > THRESHOLDS.resumed
        if nominal and resumes and not _is_settled(last, fit):
            last = _resumed(last, fit, current, library, nominal)
        last = last if last.accepts else _tentative(last)
        if not last.justifies_another(fit):
            break
        steps.append(last)
    return _without_tentative(steps)


def _is_settled(step: SelectionStep, first: Fit) -> bool:
    """Whether the best candidate is justified and no law of hidden motion that leaves a clear gap."""
    best = step.best if step.confirmed else None
    imitates = best is not None and best.placed.integrated and is_clear(best.fit)
    return step.justifies_another(first) and not imitates


def _selection_step(
    fit: Fit, library: Sequence[Effect], nominal: Fit | None, earlier: Sequence[SelectionStep] = ()
) -> SelectionStep:
    """Fit the best candidates, then more of them at higher cost as long as none explains the error.

    None is fitted if the error of every output is below its noise.
    """
    found = screened(fit, library)
    if float(fit.squares.max()) < THRESHOLDS.noise:
        return SelectionStep(fit.released(), (), tuple(found))
    confirmed: dict[Key, Confirmed] = {}
    tried: dict[Key, Placed] = {}
    starts = chain(
        stages_of_starts(fit, found, library, nominal, confirmed, tried),
        [_rivals_of_earlier_steps(earlier, fit)],
    )
    return _completed(fit, found, starts, confirmed, tried)


def _resumed(
    step: SelectionStep, first: Fit, fit: Fit, library: Sequence[Effect], nominal: Fit
) -> SelectionStep:
    """A step continued with starts from the nominal values, unless it is justified without these and not with them."""
    state = stable_with_effects(nominal.state, nominal.weighting, fit.state.placed)
    if state is None:
        return step
    confirmed, nominal = {own.key: own for own in step.confirmed}, replace(nominal, state=state)
    found = _completed(fit, step.screened, from_nominal(fit, nominal, library, confirmed), confirmed, {})
    if step.justifies_another(first) and not found.justifies_another(first):
        return step
    return replace(found, refused=(found.refused | step.refused) - confirmed.keys())


def _rivals_of_earlier_steps(steps: Sequence[SelectionStep], fit: Fit) -> Iterator[Start]:
    """Integrated laws that were rivals in earlier steps, from the values found there."""
    present = {item.key for item in fit.state.placed}
    hidden = (own for step in steps for own in step.confirmed if own.placed.integrated)
    found = {own.key: own for own in hidden if own.penalised_gain > 0 and own.key not in present}
    yield from (Start.with_values_of(own.fit, fit, own.placed) for own in best_first(found)[:_LEADING])


def _completed(
    fit: Fit,
    found: Sequence[Candidate],
    starts: Iterable[Iterable[Start]],
    confirmed: dict[Key, Confirmed],
    tried: dict[Key, Placed],
) -> SelectionStep:
    """A step after fits from the starts of some stages, as long as none explains the error."""
    for stage in starts:
        tried |= _confirm(fit, stage, confirmed)
        best = max(confirmed.values(), key=lambda c: c.penalised_gain, default=None)
        if best is not None and best.fit.mean_square < THRESHOLDS.explained:
            break
    # A law of a hidden joint that was evaluated at a motion without it is accurate near its values only.
    best_found = [Start.of(fit, own.placed) for own in best_first(confirmed)[:1] if not own.placed.integrated]
    tried |= _confirm(fit, integrated(best_found, fit), confirmed)
    # A refinement may imitate its simpler effect, as presliding does Coulomb friction, and a lag is nearly a delay:
    # both are fitted and compared.
    late = [c.placed for c in found if _is_other_timing(c.placed.key, tried)]
    tried |= _confirm(fit, [Start.of(fit, placed) for placed in late], confirmed)
    tried |= _confirm(fit, list(simpler_effects(fit, found, confirmed)), confirmed)
    tried |= _confirm(fit, list(refinements(fit, found, confirmed)), confirmed)
    _confirm(fit, list(elsewhere(fit, found, confirmed)), confirmed, math.inf)
    _converge(fit, confirmed)
    refused = frozenset(tried.keys() - confirmed.keys())
    prefer_coulomb(confirmed)
    return SelectionStep(fit.released(), tuple(ranked(confirmed.values(), fit)), tuple(found), refused)


def _confirm(
    fit: Fit, starts: Iterable[Start], confirmed: dict[Key, Confirmed], give_up: float = THRESHOLDS.give_up
) -> dict[Key, Placed]:
    """Fit candidates, keep the best fit of each in `confirmed`, and return the candidates.

    A fit is given up where it leaves `give_up` times the least error. A simpler effect that a confirmed one refines is
    always fitted to the end, as the two are compared.
    """
    tried = {}
    for start in starts:
        tried[start.placed.key] = start.placed
        refined = any(other.placed.refines(start.placed.key) for other in confirmed.values())
        most = math.inf if refined or start.to_the_end else give_up * least_left(confirmed)
        own = confirmed_from(fit, start, most)
        # Motion that follows the force is freer than one that is predicted: it must explain far more.
        freed = start.state.prediction.follows and not fit.state.prediction.follows
        least = THRESHOLDS.follows * least_left(confirmed) if freed else math.inf
        if own is None or own.fit.mean_square > least:
            continue
        if own.key not in confirmed or _is_better(own, confirmed[own.key]):
            confirmed[own.key] = own
    return tried


def _converge(fit: Fit, confirmed: dict[Key, Confirmed]) -> None:
    """Fit the leading candidates on where they leave a clear gap: the slower one may lead in the end."""
    for own in best_first(confirmed)[:_LEADING]:
        after = converged_from(fit, own) if is_clear(own.fit) else None
        if after is not None and _is_better(after, own):
            confirmed[own.key] = after


def _is_better(own: Confirmed, other: Confirmed) -> bool:
    """Whether one fit of an effect is better than another: far less error, or better prediction of blocks left out."""
    left, of_other = own.fit.mean_square, other.fit.mean_square
    return left < THRESHOLDS.far_less * of_other or (
        own.gain > other.gain and not of_other < THRESHOLDS.far_less * left
    )


def _is_other_timing(key: Key, tried: Mapping[Key, Placed]) -> bool:
    """Whether a candidate is the delay to a lag that was tried, or the reverse."""
    name, at = key
    return key not in tried and name in LATE_FORCES and any((other, at) in tried for other in LATE_FORCES)
