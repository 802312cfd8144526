"""Reselection: each effect of a model is selected again beside all others.

Forward selection never reconsiders an effect, although the first one also took over the error of those found later.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from symid.diagnosis.effects import Effect, Key, Placed, is_presliding_part, with_equivalents
from symid.diagnosis.fitting.cross_validation import deviation
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.gauss_newton import fitted
from symid.diagnosis.fitting.hidden_starts import Start
from symid.diagnosis.fitting.state import stable_with_effects
from symid.diagnosis.selection.confirmation import confirmed_from, prefer_coulomb, ranked
from symid.diagnosis.selection.screening import screened
from symid.diagnosis.selection.stages import least_left
from symid.diagnosis.selection.step import LATE_READING, Confirmed, SelectionStep, is_clear, takes
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
        return self.step.before.mean_square - self.step.best.fit.mean_square


def reselected(accepted: Sequence[SelectionStep], library: Sequence[Effect]) -> list[Member]:
    """The effects, each selected again beside all others; effects that explain nothing are dropped.

    Empty if an effect matters but is not credible beside the others, and no rival can replace it.
    """
    first = accepted[0].before
    whole = accepted[-1].best.fit.after(first)
    n, members, dropped = len(accepted), list[Member](), list[Member]()
    for i, step in enumerate(accepted):
        # A reselected effect moves to the end, so the next one is the first of the last n.
        at = len(whole.state.placed) - n
        begun = _without(whole, at)
        if begun is None:
            return []
        own, before = begun.placed, fitted(begun.state, begun.weighting, _ITERATIONS).after(whole)
        simpler = [member for member in dropped if own.refines(member.placed.key)]
        sought = library if not any(is_presliding_part(item, own) for item in before.state.placed) else ()
        found = _chosen(
            first, before, whole, begun, step, sought if i == 0 or is_clear(whole) else (), simpler
        )
        matters = takes(before, whole, first)
        needed = matters and not before.mean_square < THRESHOLDS.as_good * whole.mean_square
        if found is None and matters and i > 0:
            found = _chosen(first, before, whole, begun, step, sought)
        if found is not None and not _stands_in(found, before, whole):
            found = None
        if found is None and needed:
            return []
        if found is None:
            whole, n = before, n - 1
            dropped.append(Member(own, step, 0.0))
            continue
        whole = found.best.fit.after(first)
        n_drives = first.state.prediction.record.n_drives
        lost = float(before.blocks.squares[:n_drives].sum())
        members.append(Member(whole.state.placed[-1], found, lost))
    return members


def _stands_in(found: SelectionStep, before: Fit, whole: Fit) -> bool:
    """Whether an effect removes most of the error that the effect in its place removes."""
    taken = before.mean_square - found.best.fit.mean_square
    return taken > THRESHOLDS.stands_in * (before.mean_square - whole.mean_square)


def _chosen(
    first: Fit,
    before: Fit,
    whole: Fit,
    begun: Start,
    step: SelectionStep,
    library: Sequence[Effect],
    simpler: Sequence[Member] = (),
) -> SelectionStep | None:
    """The step of an effect beside all others; None if no candidate is justified.

    A `simpler` effect that was dropped because this one refines it competes again.
    """
    own, starts = begun.placed, _starts(before, whole, begun, step, library, simpler)
    found = _best_fits(before, starts)
    refused = (step.refused | {start.placed.key for start in starts}) - found.keys()
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
    alone = in_place_of(steps.get(best[0].key, step), before, best[0])
    return replace(alone, refused=alone.refused | refused)


def _starts(
    before: Fit,
    whole: Fit,
    begun: Start,
    step: SelectionStep,
    library: Sequence[Effect],
    simpler: Sequence[Member],
) -> list[Start]:
    """Starts of the candidates that compete with an effect beside all others.

    Fits begin with the values of the whole model: without a large effect, small ones would go astray. Effects that this
    one refines compete, and a lag with a delay: only beside all other effects it may show which of them is enough.
    """
    own, present = begun.placed, {item.key for item in before.state.placed}
    # the effect itself, and simpler ones that it replaced
    starts = [begun, *(Start.of(before, member.placed) for member in simpler)]
    # its relatives: equivalents, simpler effects, and where a clear gap stays, refinements; fitted values come last
    near = [*(c.placed for c in step.screened), *(c.placed for c in step.confirmed)]
    equivalents = with_equivalents([own.key])
    others = {item.key: item for item in near if item.key in equivalents or own.refines(item.key)}
    if is_clear(whole):
        refined = (item for item in near if item.refines(own.key))
        others |= {item.key: replace(item, integrated=own.integrated) for item in refined}
    tried = {own.key, *present, *(member.placed.key for member in simpler)}
    starts += [replace(begun, placed=item) for key, item in others.items() if key not in tried]
    # other laws of the same effect
    laws = (item for c in step.screened if c.placed.key == own.key for item in (c.placed, *c.others))
    starts += [replace(begun, placed=item) for item in laws if item.effect is not own.effect]
    # rivals when it was found, also the same effect elsewhere from the values of the whole model; and new ones
    if library:
        rivals = {c.key: c.placed for c in step.confirmed[1 : 1 + _RIVALS] if c.key not in present}
        starts += [replace(begun, placed=item) for (name, _), item in rivals.items() if name == own.key[0]]
        rivals |= {c.placed.key: c.placed for c in screened(before, library)[:_RIVALS]}
        starts += [Start.of(before, item) for item in rivals.values()]
    return starts


def _best_fits(before: Fit, starts: Sequence[Start]) -> dict[Key, Confirmed]:
    """The best credible fit of each candidate."""
    found: dict[Key, Confirmed] = {}
    for start in starts:
        item = start.placed
        same = item.key in found and found[item.key].effect is item.effect
        if same and not (item.shape or item.integrated):
            continue  # the error is linear in its values: it has one minimum
        is_simpler = any(other.placed.refines(item.key) for other in found.values())
        most = math.inf if is_simpler else THRESHOLDS.give_up * least_left(found)
        one = confirmed_from(before, start, most)
        if one is not None and (one.key not in found or one.gain > found[one.key].gain):
            found[one.key] = one
    return found


def _is_clearly_better(best: Confirmed, own: Confirmed) -> bool:
    """Whether a rival predicts blocks better than the effect that was found, by more than their scatter.

    A refinement of the effect, such as presliding of Coulomb friction, replaces it only if its prior odds are higher or
    it gains much more.
    """
    least = max(THRESHOLDS.least_penalised_gain, deviation(own.squares, best.squares, own.fit.n_rows))
    if best.placed.refines(own.key):
        if best.log_prior_odds > own.log_prior_odds:
            return True
        least = max(least, THRESHOLDS.refined * own.penalised_gain)
    return best.penalised_gain - own.penalised_gain > least


def _without(whole: Fit, at: int) -> Start | None:
    """The model without one of its effects, all other values unchanged, and that effect; None if it is unstable."""
    placed = list(whole.state.placed)
    own = placed.pop(at)
    state = stable_with_effects(whole.state, whole.weighting, tuple(placed))
    return None if state is None else Start(state, whole.weighting, own)


def in_place_of(step: SelectionStep, before: Fit, found: Confirmed) -> SelectionStep:
    """A step after another model; its rivals keep their distance from the best candidate, and are not ahead of it.

    A rival may have explained more alone, as Stribeck friction in the place of Coulomb friction and of a drag.
    """
    best, *rivals = step.confirmed
    moved = [rival.beside(best, found) for rival in rivals]
    behind = [replace(rival, gain=min(rival.gain, found.gain)) for rival in moved]
    screened = tuple(
        replace(candidate, gain=found.gain + candidate.gain - best.gain) for candidate in step.screened
    )
    return SelectionStep(
        before.released(),
        (replace(found, log_prior_odds=best.log_prior_odds), *behind),
        screened,
        step.refused,
    )
