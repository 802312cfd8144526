"""Backward elimination: effects found one at a time are judged together.

Forward selection never reconsiders an effect, but the first one also stood in for those found later. With all others in
the model, the first effect is therefore selected again among all candidates, and an effect that then explains nothing
is dropped (stepwise regression with replacement and backward elimination). The remaining effects are sorted by the
error that the model has without each, and fitted again in this order, so that the steps of the gap add up. If an effect
explains nothing at its position, the order of their gains when found is tried, then the order in which they were found.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from symid.diagnosis.effects import Effect, Key, Placed, is_part
from symid.diagnosis.fitting.cross_validation import deviation
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.gauss_newton import fitted
from symid.diagnosis.fitting.hidden_starts import Start
from symid.diagnosis.fitting.state import with_effects
from symid.diagnosis.selection.confirmation import confirmed_from, prefer_coulomb, ranked
from symid.diagnosis.selection.evidence import probabilities
from symid.diagnosis.selection.screening import screened
from symid.diagnosis.selection.step import LATE_READING, Confirmed, SelectionStep, takes
from symid.diagnosis.thresholds import THRESHOLDS

_ITERATIONS = 3
_RIVALS = 3
"""Candidates from earlier and from new screening that compete with an effect when it is selected again."""


@dataclass(frozen=True, eq=False)
class Member:
    """An effect of the model with all effects."""

    placed: Placed  # with its values beside all others
    step: SelectionStep  # in which it was chosen, with its rivals
    lost: float  # cross-validated sum of squared force errors of the model without it

    @property
    def is_timing(self) -> bool:
        """Whether it is the delay of a reading, which goes first: other effects need readings of one instant."""
        return self.placed.effect.name == LATE_READING

    @property
    def taken(self) -> float:
        """Decrease of the mean square when it was chosen."""
        return self.step.before.mean_square - self.step.confirmed[0].fit.mean_square


def backward_elimination(
    steps: Sequence[SelectionStep], library: Sequence[Effect]
) -> tuple[SelectionStep, ...]:
    """Steps sorted by the error that their effects remove; effects that remove nothing are dropped."""
    accepted = [step for step in steps if step.accepts]
    if len(accepted) < 2:
        return tuple(steps)
    members = _reselected(accepted, library)
    if not members:
        return tuple(steps)
    first, whole = accepted[0].before, members[-1].step.confirmed[0].fit
    orders = (
        sorted(members, key=lambda member: (not member.is_timing, -member.lost)),
        sorted(members, key=lambda member: -member.taken),
        members,
    )
    # Effects are fitted one by one in each order. The first order counts in which each is justified at its position and
    # the last model is as good as the whole one. Fits from the model without effects may end in other minima: at last
    # the values of the whole model are tried.
    most = THRESHOLDS.as_good * whole.mean_square
    tried = (*((order, None) for order in orders), (orders[0], whole))
    chains = (_chain(_whole_before_part(order), first, most, whole=begun) for order, begun in tried)
    return next((chain for chain in chains if chain is not None), _beside_others(accepted, members))


def _whole_before_part(order: Sequence[Member]) -> list[Member]:
    """The order with Coulomb friction moved before its presliding part."""
    found: list[Member] = []
    for member in order:
        behind = (i for i, other in enumerate(found) if is_part(other.placed, member.placed))
        found.insert(next(behind, len(found)), member)
    return found


def _beside_others(accepted: Sequence[SelectionStep], members: Sequence[Member]) -> tuple[SelectionStep, ...]:
    """The steps in their old order, with the lead over rivals that their effects have beside all others."""
    chosen = {member.placed.key: member.step for member in members}
    return tuple(
        _in_place_of(chosen.get(step.confirmed[0].key, step), step.before, step.confirmed[0])
        for step in accepted
    )


def without(steps: Sequence[SelectionStep], at: int) -> tuple[SelectionStep, ...]:
    """Steps without one effect, the others fitted again, as far as each then explains something.

    Unchanged if the first of the others explains nothing.
    """
    members = _members(steps)
    rest = [*members[:at], *members[at + 1 :]]
    chains = (_chain(rest[:n], steps[0].before, math.inf) for n in range(len(rest), 0, -1))
    return next((chain for chain in chains if chain is not None), tuple(steps))


def brought_first(steps: Sequence[SelectionStep], at: int) -> tuple[SelectionStep, ...]:
    """Steps with one effect moved to the front, fitted again; unchanged if one of them then explains nothing."""
    members, whole = _members(steps), steps[-1].confirmed[0].fit
    order = [members[at], *members[:at], *members[at + 1 :]]
    for _ in range(2):
        chain = _chain(order, steps[0].before, math.inf, justified=True, whole=whole) or ()
        kept = {step.confirmed[0].key for step in chain}
        # An effect that is not credible at its position may be so beside all others.
        order.sort(key=lambda member: member.placed.key not in kept)
        if len(kept) in (0, len(order)):
            break
    other = tuple(step.fitted_on() for step in chain)
    as_good = other and other[-1].confirmed[0].fit.mean_square < THRESHOLDS.as_good * whole.mean_square
    return other if as_good else tuple(steps)


def most_probable(steps: Sequence[SelectionStep]) -> tuple[SelectionStep, ...]:
    """Steps in which each effect is replaced by its rival if that is more probable beside all others, fitted again.

    An effect is chosen by its gain. Prior knowledge, such as the level of a friction, decides only now, when the other
    effects are known. All steps accept their effects.
    """
    for at in range(len(steps)):
        step = steps[at]
        named = {own.confirmed[0].key for own in steps if own is not step}
        # A more probable rival takes the place only if the fit in the same order stays as good.
        likeliest = next(iter(probabilities(step, named)))
        rival = next((own for own in step.confirmed if own.key == likeliest), step.confirmed[0])
        if rival is step.confirmed[0]:
            continue
        members, whole = _members(steps), steps[-1].confirmed[0].fit
        members[at] = Member(rival.placed, step.led_by(rival), 0.0)
        steps = _chain(members, steps[0].before, THRESHOLDS.as_good * whole.mean_square) or steps
    return tuple(steps)


def _members(steps: Sequence[SelectionStep]) -> list[Member]:
    """Effects of accepting steps, with their values beside all others."""
    placed = steps[-1].confirmed[0].fit.state.placed[-len(steps) :]
    return [Member(item, step, 0.0) for item, step in zip(placed, steps, strict=True)]


def _reselected(accepted: Sequence[SelectionStep], library: Sequence[Effect]) -> list[Member]:
    """The effects, each selected again beside all others; effects that explain nothing are dropped.

    Empty if an effect matters but is not credible beside the others, and no rival can replace it.
    """
    first = accepted[0].before
    whole = accepted[-1].confirmed[0].fit.after(first)
    n, members, dropped = len(accepted), list[Member](), list[Member]()
    for i, step in enumerate(accepted):
        # A reselected effect moves to the end, so the next one is the first of the last n.
        at = len(whole.state.placed) - n
        begun = _without(whole, at)
        own, before = begun.placed, fitted(begun.state, begun.weighting, _ITERATIONS).after(whole)
        simpler = [member for member in dropped if own.contains(member.placed.key)]
        sought = library if not any(is_part(item, own) for item in before.state.placed) else ()
        found = _chosen(first, before, begun, step, sought if i == 0 else (), simpler)
        matters = takes(before, whole, first)
        needed = matters and not before.mean_square < THRESHOLDS.as_good * whole.mean_square
        if found is None and matters and i > 0:
            found = _chosen(first, before, begun, step, sought)
        if found is not None and not _stands_in(found, before, whole):
            found = None
        if found is None and needed:
            return []
        if found is None:
            whole, n = before, n - 1
            dropped.append(Member(own, step, 0.0))
            continue
        whole = found.confirmed[0].fit.after(first)
        n_drives = first.state.prediction.record.n_drives
        lost = float(before.blocks.squares[:n_drives].sum())
        members.append(Member(whole.state.placed[-1], found, lost))
    return members


def _stands_in(found: SelectionStep, before: Fit, whole: Fit) -> bool:
    """Whether an effect removes most of the error that the effect in its place removes."""
    taken = before.mean_square - found.confirmed[0].fit.mean_square
    return taken > THRESHOLDS.stands_in * (before.mean_square - whole.mean_square)


def _chosen(
    first: Fit,
    before: Fit,
    begun: Start,
    step: SelectionStep,
    library: Sequence[Effect],
    simpler: Sequence[Member] = (),
) -> SelectionStep | None:
    """The step of an effect beside all others; None if no candidate is justified.

    Fits begin with the values of the whole model: without a large effect, small ones would go astray. A `simpler`
    effect that was dropped because this one contains it competes again.
    """
    own = begun.placed
    starts = [begun, *(Start.of(before, member.placed) for member in simpler)]
    if library:
        present = {item.key for item in before.state.placed}
        rivals = {c.key: c.placed for c in step.confirmed[1 : 1 + _RIVALS] if c.key not in present}
        rivals |= {c.placed.key: c.placed for c in screened(before, library)[:_RIVALS]}
        starts += [Start.of(before, item) for item in rivals.values()]
    found: dict[Key, Confirmed] = {}
    for start in starts:
        one = confirmed_from(before, start)
        if one is not None and (one.key not in found or one.gain > found[one.key].gain):
            found[one.key] = one
    refused = step.refused | {start.placed.key for start in starts}
    refused -= found.keys()
    prefer_coulomb(found)
    best = ranked(found.values(), before)
    kept = next((c for c in best if c.key == own.key), found.get(own.key))
    if best and kept is not None and not _is_clearly_better(best[0], kept):
        best = [kept, *(c for c in best if c is not kept)]
    chosen = SelectionStep(before.released(), tuple(best), step.screened, refused)
    if not chosen.justifies_another(first):
        return None
    if len(best) > 1:
        return chosen
    steps = {member.placed.key: member.step for member in simpler}
    return _in_place_of(steps.get(best[0].key, step), before, best[0])


def _is_clearly_better(best: Confirmed, own: Confirmed) -> bool:
    """Whether a rival predicts blocks better than the effect that was found, by more than their scatter.

    A refinement of the effect, such as presliding of Coulomb friction, replaces it only if its prior odds are higher or
    it gains much more.
    """
    least = max(THRESHOLDS.least_penalised_gain, deviation(own.squares, best.squares, own.fit.n_rows))
    if best.placed.contains(own.key):
        if best.log_prior_odds > own.log_prior_odds:
            return True
        least = max(least, THRESHOLDS.refined * own.penalised_gain)
    return best.penalised_gain - own.penalised_gain > least


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
            starts.append(_with_values_of(whole, first, members[: i + 1]))
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
            step = _in_place_of(member.step, before, found)
            if not step.justifies_another(first):
                return None
        chain.append(step)
        before = found.fit.after(before)
    return tuple(chain) if chain and before.mean_square < most else None


def _with_values_of(whole: Fit, first: Fit, members: Sequence[Member]) -> Start:
    """The last of some effects beside the others, with the values of the whole model."""
    *others, last = (member.placed for member in members)
    placed = (*first.state.placed, *others)
    return Start(with_effects(whole.state, whole.weighting, placed), whole.weighting, last)


def _without(whole: Fit, at: int) -> Start:
    """The model without one of its effects, all other values unchanged, and that effect."""
    placed = list(whole.state.placed)
    own = placed.pop(at)
    return Start(with_effects(whole.state, whole.weighting, tuple(placed)), whole.weighting, own)


def _in_place_of(step: SelectionStep, before: Fit, found: Confirmed) -> SelectionStep:
    """A step after another model; its rivals keep their distance from the best candidate."""
    best, *rivals = step.confirmed
    behind = [rival.beside(best, found) for rival in rivals]
    screened = tuple(
        replace(candidate, gain=found.gain + candidate.gain - best.gain) for candidate in step.screened
    )
    return SelectionStep(
        before.released(),
        (replace(found, log_prior_odds=best.log_prior_odds), *behind),
        screened,
        step.refused,
    )
