"""Effects found one after the other, judged together.

What was found first stood in for what was found later, and forward selection does not take it back. With all others in
the model, the effect found first is therefore sought again among all candidates, and one that then explains nothing is
dropped (stepwise regression with replacement and backward elimination). What is left is put into the order of what the
model loses without each, and fitted again in this order, so that the steps of the gap add up. Where one of them is
worth nothing at its place, the order of what each took away when it was found is tried; and else they stay as they are.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from symid.diagnosis.effects import Effect, Key, Placed, is_part
from symid.diagnosis.fitting.cross_validation import deviation
from symid.diagnosis.fitting.fit import Fit, fitted
from symid.diagnosis.fitting.hidden_starts import Start
from symid.diagnosis.fitting.state import with_effects
from symid.diagnosis.selection.confirmation import confirmed_from, prefer_coulomb, ranked
from symid.diagnosis.selection.evidence import probabilities
from symid.diagnosis.selection.screening import screened
from symid.diagnosis.selection.step import LATE_READING, Confirmed, SelectionStep, takes
from symid.diagnosis.thresholds import THRESHOLDS

_ITERATIONS = 3
_RIVALS = 3
"""Candidates found in a new screening that are fitted beside those that were, in place of the effect found first."""


@dataclass(frozen=True, eq=False)
class Member:
    """An effect of the whole model."""

    placed: Placed  # with its values in the whole model
    step: SelectionStep  # in which it was chosen, with its rivals
    lost: float  # sum of squares of the force errors on blocks left out, of the model without it

    @property
    def is_timing(self) -> bool:
        """A reading that is late: the others are measured with readings that belong together."""
        return self.placed.effect.name == LATE_READING

    @property
    def taken(self) -> float:
        """Mean square that it took away when it was chosen."""
        return self.step.before.mean_square - self.step.confirmed[0].fit.mean_square


def backward_elimination(
    steps: Sequence[SelectionStep], library: Sequence[Effect]
) -> tuple[SelectionStep, ...]:
    """Steps in the order of what their effects take away; those that take nothing are left out."""
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
    most = THRESHOLDS.as_good * whole.mean_square
    chains = (_chain(_whole_before_part(order), first, most) for order in orders)
    return next((chain for chain in chains if chain is not None), _beside_others(accepted, members))


def _whole_before_part(order: Sequence[Member]) -> list[Member]:
    """The same order, except for Coulomb friction behind its presliding part: it goes before that."""
    found: list[Member] = []
    for member in order:
        behind = (i for i, other in enumerate(found) if is_part(other.placed, member.placed))
        found.insert(next(behind, len(found)), member)
    return found


def _beside_others(accepted: Sequence[SelectionStep], members: Sequence[Member]) -> tuple[SelectionStep, ...]:
    """Steps as they were, with the lead over rivals that their effects have beside all others."""
    chosen = {member.placed.key: member.step for member in members}
    return tuple(
        _in_place_of(chosen.get(step.confirmed[0].key, step), step.before, step.confirmed[0])
        for step in accepted
    )


def without(steps: Sequence[SelectionStep], at: int) -> tuple[SelectionStep, ...]:
    """Steps without the effect of one of them, the others fitted again; the same if one then explains nothing."""
    members = _members(steps)
    return _chain([*members[:at], *members[at + 1 :]], steps[0].before, math.inf) or tuple(steps)


def brought_first(steps: Sequence[SelectionStep], at: int) -> tuple[SelectionStep, ...]:
    """Steps with the effect of one of them as the first, fitted again; the same if one then explains nothing."""
    members, whole = _members(steps), steps[-1].confirmed[0].fit
    order = [members[at], *members[:at], *members[at + 1 :]]
    chain = _chain(order, steps[0].before, math.inf, justified=True) or ()
    other = tuple(step.fitted_on() for step in chain)
    as_good = other and other[-1].confirmed[0].fit.mean_square < THRESHOLDS.as_good * whole.mean_square
    return other if as_good else tuple(steps)


def most_probable(steps: Sequence[SelectionStep]) -> tuple[SelectionStep, ...]:
    """Steps in which each effect gives way to the rival that is more probable beside the others, fitted again.

    What was found first was chosen by its gain; what else is known, as the level of a friction, speaks in the end.

    Parameters
    ----------
    steps : sequence of SelectionStep
        That accept their effects.
    """
    for at in range(len(steps)):
        step = steps[at]
        named = {own.confirmed[0].key for own in steps if own is not step}
        likeliest = next(iter(probabilities(step, named)))
        rival = next((own for own in step.confirmed if own.key == likeliest), step.confirmed[0])
        if rival is step.confirmed[0]:
            continue
        members, whole = _members(steps), steps[-1].confirmed[0].fit
        members[at] = Member(rival.placed, step.led_by(rival), 0.0)
        steps = _chain(members, steps[0].before, THRESHOLDS.as_good * whole.mean_square) or steps
    return tuple(steps)


def _members(steps: Sequence[SelectionStep]) -> list[Member]:
    """Effects of steps that accept them, with their values beside all others."""
    placed = steps[-1].confirmed[0].fit.state.placed[-len(steps) :]
    return [Member(item, step, 0.0) for item, step in zip(placed, steps, strict=True)]


def _reselected(accepted: Sequence[SelectionStep], library: Sequence[Effect]) -> list[Member]:
    """The effects, each beside all others: the first one sought again, those left out that explain nothing.

    None where one matters whose values are then not credible, and nothing can stand in its place.
    """
    first = accepted[0].before
    whole = accepted[-1].confirmed[0].fit.after(first)
    n, members, dropped = len(accepted), list[Member](), list[Member]()
    for i, step in enumerate(accepted):
        at = (
            len(whole.state.placed) - n
        )  # an effect done with goes to the end: the next one is the first of the last n
        begun = _without(whole, at)
        own, before = begun.placed, fitted(begun.state, begun.weighting, _ITERATIONS).after(whole)
        simpler = [member for member in dropped if own.contains(member.placed.key)]
        sought = library if not any(is_part(item, own) for item in before.state.placed) else ()
        found = _chosen(first, before, begun, step, sought if i == 0 else (), simpler)
        matters = takes(before, whole, first)
        if found is None and matters and i > 0:
            found = _chosen(first, before, begun, step, sought)
        if found is not None and not _stands_in(found, before, whole):
            found = None
        if found is None and matters:
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
    """Whether an effect takes away most of what the one at its place does."""
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
    """The step of an effect beside all others; None if nothing is worth its place.

    It begins with all values of the whole model: where a large effect is missing, small ones are led astray. What is
    `simpler`, and was dropped as the effect contains it, is a rival again.
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
    if best and own.key in found and not _clearly(best[0], found[own.key], first):
        best = [found[own.key], *(c for c in best if c.key != own.key)]
    chosen = SelectionStep(before, tuple(best), step.screened, refused)
    if not chosen.justifies_another(first):
        return None
    if len(best) > 1:
        return chosen
    steps = {member.placed.key: member.step for member in simpler}
    return _in_place_of(steps.get(best[0].key, step), before, best[0])


def _clearly(best: Confirmed, own: Confirmed, first: Fit) -> bool:
    """Whether a rival predicts blocks better than the effect that was found, by more than they scatter.

    A refinement of it, as presliding is one of Coulomb friction, takes its place only where more than errors speaks
    for it, or where it gains much more.
    """
    least = max(THRESHOLDS.least_penalised_gain, deviation(own.squares, best.squares, own.fit.n_rows))
    if best.placed.contains(own.key):
        if best.odds > own.odds:
            return True
        least = max(least, THRESHOLDS.refined * own.penalised_gain)
    return best.penalised_gain - own.penalised_gain > least


def _chain(
    members: Sequence[Member], first: Fit, most: float, *, justified: bool = False
) -> tuple[SelectionStep, ...] | None:
    """Steps in an order, fitted again; None if one of them is then worth nothing, or `most` or more is left.

    Of effects that are `justified` beside each other, what each takes away at its place does not count, but what spoke
    for it beside the others. Those are left out that no machine has behind the first.
    """
    chain: list[SelectionStep] = []
    before = first
    for i, member in enumerate(members):
        later = [other.placed for other in members[i + 1 :]]
        found = confirmed_from(before, Start.of(before, member.placed), beside=later)
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


def _without(whole: Fit, at: int) -> Start:
    """The model without one of its effects, all else as it is, and that effect."""
    placed = list(whole.state.placed)
    own = placed.pop(at)
    return Start(with_effects(whole.state, whole.weighting, tuple(placed)), whole.weighting, own)


def _in_place_of(step: SelectionStep, before: Fit, found: Confirmed) -> SelectionStep:
    """A step with another model before it; rivals, and what speaks for them, stay as far behind as they were."""
    best, *rivals = step.confirmed
    behind = [rival.beside(best, found) for rival in rivals]
    screened = tuple(
        replace(candidate, gain=found.gain + candidate.gain - best.gain) for candidate in step.screened
    )
    return SelectionStep(before, (replace(found, odds=best.odds), *behind), screened, step.refused)
