"""Effects found one after the other, judged together.

What was found first stood in for what was found later. With the others in the model each is left out in turn, which
tells how well the rest predicts blocks that are left out. In this order they are fitted again, so that the steps of the
gap add up. Where one of them is then worth nothing, the order of what each took away when it was found is tried; and
else they stay in the order in which they were found.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from symid.diagnosis.fit import Fit, fitted
from symid.diagnosis.hidden_starts import Start
from symid.diagnosis.search import Confirmed, Turn, confirmed_from
from symid.diagnosis.state import with_effects

_ITERATIONS = 3
_AS_GOOD = 1.1
"""In another order the fit may end elsewhere: it must leave as little."""


def judged_together(turns: Sequence[Turn]) -> tuple[Turn, ...]:
    """Turns of the search in the order of what their effects take away.

    Parameters
    ----------
    turns : sequence of Turn
        As the search left them.
    """
    accepted = [turn for turn in turns if turn.accepts]
    if len(accepted) < 2:
        return tuple(turns)
    whole = accepted[-1].confirmed[0].fit
    n = len(accepted)
    lost = [_without(whole, n - i).predicted for i in range(n)]
    taken = [turn.before.mean_square - turn.confirmed[0].fit.mean_square for turn in accepted]
    for order in (sorted(range(n), key=lambda i: lost[i]), sorted(range(n), key=lambda i: -taken[i])):
        if order == sorted(order):
            break
        chain = _chain(accepted, order)
        if chain is not None:
            return chain
    return tuple(turns)


def _chain(accepted: Sequence[Turn], order: Sequence[int]) -> tuple[Turn, ...] | None:
    """The turns in another order, fitted again; None if one of them is then worth nothing, or more is left."""
    whole, first = accepted[-1].confirmed[0].fit, accepted[0].before
    own = whole.state.placed[-len(accepted) :]
    chain: list[Turn] = []
    before = first
    for i in order:
        found = confirmed_from(before, Start.of(before, own[i]))
        if found is None:
            return None
        turn = _in_place_of(accepted[i], before, found)
        if not turn.is_worth_another(first.mean_square):
            return None
        chain.append(turn)
        before = replace(found.fit, begun=before.begun)
    return tuple(chain) if before.mean_square < _AS_GOOD * whole.mean_square else None


def _without(whole: Fit, from_end: int) -> Fit:
    """The model without one of its effects, fitted again."""
    placed = list(whole.state.placed)
    del placed[-from_end]
    return fitted(with_effects(whole.state, whole.weighting, tuple(placed)), whole.weighting, _ITERATIONS)


def _in_place_of(turn: Turn, before: Fit, found: Confirmed) -> Turn:
    """A turn with another model before it; rivals stay as far behind as they were."""
    best, *rivals = turn.confirmed
    behind = [replace(rival, gain=found.gain + rival.gain - best.gain) for rival in rivals]
    screened = tuple(
        replace(candidate, gain=found.gain + candidate.gain - best.gain) for candidate in turn.screened
    )
    return Turn(before, (found, *behind), screened)
