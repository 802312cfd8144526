"""Backward elimination: effects that were found one at a time are judged together.

Forward selection never reconsiders an effect, although the first one also took over the error of those found later. The
first effect is therefore selected again beside all others, and each effect where a clear gap stays. An effect that then
explains nothing is dropped (stepwise regression with replacement and backward elimination). The remaining effects are
sorted by the error of the model without each, and fitted again in this order, so that the steps of the gap add up. If
an effect explains nothing at its position, they are sorted by their gains when found, then in the order of selection.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

from symid.diagnosis.effects import Effect, is_presliding_part
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.hidden_starts import Start
from symid.diagnosis.fitting.state import stable_with_effects
from symid.diagnosis.selection.confirmation import confirmed_from
from symid.diagnosis.selection.credibility import exceeds_deviations
from symid.diagnosis.selection.evidence import probabilities
from symid.diagnosis.selection.reselection import Member, in_place_of, reselected
from symid.diagnosis.selection.step import SelectionStep, accepted_of
from symid.diagnosis.thresholds import THRESHOLDS


def backward_elimination(
    steps: Sequence[SelectionStep], library: Sequence[Effect]
) -> tuple[SelectionStep, ...]:
    """Steps sorted by the error that their effects remove; effects that remove nothing are dropped."""
    if len(accepted_of(steps)) < 2:
        return tuple(steps)
    steps = accepted = _determined(accepted_of(steps))
    members = reselected(accepted, library)
    if not members:
        tentative = accepted[0].beside_others  # uncertain both alone and beside the others
        return (replace(accepted[0], beside_others=False),) if tentative else tuple(steps)
    first, whole = accepted[0].before, members[-1].step.best.fit
    by_loss = sorted(members, key=lambda member: (not member.is_timing, -member.lost))
    by_gain = sorted(members, key=lambda member: -member.taken)
    orders = tuple(dict.fromkeys(map(tuple, (by_loss, by_gain, members))))  # two of them are often the same
    # Effects are fitted one by one in each order. The first order counts in which each is justified at its position and
    # the last model is as good as the whole one. Fits that begin without effects may end in other minima: the last
    # attempt begins with the values of the whole model.
    most = THRESHOLDS.as_good * whole.mean_square
    tried = (*((order, None) for order in orders), (orders[0], whole))
    chains = (_chain(_whole_before_part(order), first, most, whole=begun) for order, begun in tried)
    found = next((chain for chain in chains if chain is not None), None)
    if found is None and whole.mean_square < THRESHOLDS.far_less * accepted[-1].best.fit.mean_square:
        # Without the others each effect is distorted and not justified: they are judged beside each other.
        found = _chain(orders[0], first, most, justified=True, whole=whole)
    return found or _beside_others(accepted, members)


def _determined(steps: Sequence[SelectionStep]) -> Sequence[SelectionStep]:
    """Steps without effects whose values are within their deviations beside all others, if the rest explains as much.

    Such an effect took the place of one that was found later. It is kept if the others, fitted again, need it.
    """
    first, whole = steps[0].before, steps[-1].best.fit
    covariance, end = whole.blocks.covariance, len(whole.columns)
    shown: list[Member] = []
    for member in reversed(_members(steps)):
        begin = end - member.placed.n_free
        if exceeds_deviations(member.placed, covariance[begin:end, begin:end]):
            shown.insert(0, member)
        end = begin
    if len(shown) in (0, len(steps)):
        return steps
    return _chain(shown, first, THRESHOLDS.as_good * whole.mean_square) or steps


def _whole_before_part(order: Sequence[Member]) -> list[Member]:
    """The order with Coulomb friction moved before its presliding part."""
    found: list[Member] = []
    for member in order:
        behind = (i for i, other in enumerate(found) if is_presliding_part(other.placed, member.placed))
        found.insert(next(behind, len(found)), member)
    return found


def _beside_others(accepted: Sequence[SelectionStep], members: Sequence[Member]) -> tuple[SelectionStep, ...]:
    """The steps in their old order, with the gains over rivals that their effects have beside all others.

    If an effect is not accepted beside the others, these are fitted again without it; it is kept if they then explain
    less.
    """
    chosen = {member.placed.key: member.step for member in members}
    own = ((step, chosen.get(step.best.key, step)) for step in accepted)
    placed = (in_place_of(beside, step.before, step.best) for step, beside in own)
    found = tuple(replace(step, beside_others=step.best.key in chosen) for step in placed)
    kept = [member for member in _members(found) if member.step.accepts]
    if len(kept) in (0, len(found)):
        return found
    whole = found[-1].best.fit
    most = THRESHOLDS.as_good * whole.mean_square
    again = _chain(kept, found[0].before, most, justified=True, whole=whole)
    return again or tuple(replace(step, beside_others=True) for step in found)


def without(steps: Sequence[SelectionStep], at: int) -> tuple[SelectionStep, ...]:
    """Steps without one effect, the others fitted again, as far as each then explains something.

    The steps are returned unchanged if the first of the others explains nothing.
    """
    members = _members(steps)
    rest = [*members[:at], *members[at + 1 :]]
    chains = (_chain(rest[:n], steps[0].before, math.inf) for n in range(len(rest), 0, -1))
    return next((chain for chain in chains if chain is not None), tuple(steps))


def brought_first(steps: Sequence[SelectionStep], at: int) -> tuple[SelectionStep, ...]:
    """Steps with one effect moved to the front, fitted again; unchanged if one of them then explains nothing."""
    members, whole = _members(steps), steps[-1].best.fit
    order = [members[at], *members[:at], *members[at + 1 :]]
    for _ in range(2):
        chain = _chain(order, steps[0].before, math.inf, justified=True, whole=whole) or ()
        kept = {step.best.key for step in chain}
        # An effect that is not credible at its position may be so beside all others.
        order.sort(key=lambda member: member.placed.key not in kept)
        if len(kept) in (0, len(order)):
            break
    other = tuple(step.fitted_on() for step in chain)
    as_good = other and other[-1].best.fit.mean_square < THRESHOLDS.as_good * whole.mean_square
    return other if as_good else tuple(steps)


def most_probable(steps: Sequence[SelectionStep]) -> tuple[SelectionStep, ...]:
    """Steps in which each effect is replaced by its rival if that is more probable beside all others, fitted again.

    Effects are selected by gain. Prior knowledge, such as the level of a friction, counts only here, where the other
    effects are known. All steps accept their effects.
    """
    for at in range(len(steps)):
        step = steps[at]
        named = {own.best.key for own in steps if own is not step}
        # A more probable rival takes the place only if the fit in the same order stays as good.
        likeliest = next(iter(probabilities(step, named)))
        rival = next((own for own in step.confirmed if own.key == likeliest), step.best)
        if rival is step.best:
            continue
        members, whole = _members(steps), steps[-1].best.fit
        members[at] = Member(rival.placed, step.led_by(rival), 0.0)
        steps = _chain(members, steps[0].before, THRESHOLDS.as_good * whole.mean_square) or steps
    return tuple(steps)


def _members(steps: Sequence[SelectionStep]) -> list[Member]:
    """Effects of accepting steps, with their values beside all others."""
    placed = steps[-1].best.fit.state.placed[-len(steps) :]
    return [Member(item, step, 0.0) for item, step in zip(placed, steps, strict=True)]


def _chain(
    members: Sequence[Member], first: Fit, most: float, *, justified: bool = False, whole: Fit | None = None
) -> tuple[SelectionStep, ...] | None:
    """Steps fitted again in an order; None if one is then not justified, or the error reaches `most`.

    Effects that are `justified` beside each other keep their evidence, whatever each removes at its position; those
    that are not credible after the first are left out. The last one is also fitted from the values of the `whole`
    model, as effects on hidden motion have many minima.
    """
    chain: list[SelectionStep] = []
    before = first
    for i, member in enumerate(members):
        later = [other.placed for other in members[i + 1 :]]
        starts = [Start.of(before, member.placed)]
        if whole is not None and (not later or member.placed.integrated) and len(chain) == i:
            starts.extend(_with_values_of(whole, first, members[: i + 1]))
        tried = (confirmed_from(before, start, beside=later) for start in starts)
        # starts of one model: the lowest error is its fit, whichever start predicts blocks better
        fits = (own for own in tried if own is not None)
        found = min(fits, key=lambda own: own.fit.mean_square, default=None)
        if found is None and justified and i:
            continue
        if found is None:
            return None
        if justified:
            best, *rivals = member.step.confirmed
            confirmed = (replace(best, fit=found.fit), *rivals)
            step = replace(member.step, before=before, confirmed=confirmed, beside_others=True)
        else:
            step = in_place_of(member.step, before, found)
            if not step.justifies_another(first):
                return None
        chain.append(step)
        before = found.fit.after(before)
    return tuple(chain) if chain and before.mean_square < most else None


def _with_values_of(whole: Fit, first: Fit, members: Sequence[Member]) -> Iterator[Start]:
    """The last of some effects beside the others, with the values of the whole model, unless it is unstable without."""
    *others, last = (member.placed for member in members)
    state = stable_with_effects(whole.state, whole.weighting, (*first.state.placed, *others))
    if state is not None:
        yield Start(state, whole.weighting, last)
