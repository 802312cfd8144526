"""Effects found one after the other, judged together.

What was found first stood in for what was found later. With the others in the model each is left out in turn, which
tells how well the rest predicts blocks that are left out. In this order they are fitted again, so that the steps of the
gap add up, up to the first that the others make needless.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from symid.diagnosis.blocks import predicted
from symid.diagnosis.fit import Fit, fitted
from symid.diagnosis.hidden_starts import Start
from symid.diagnosis.search import Confirmed, Turn, confirmed_from
from symid.diagnosis.state import with_effects

_ITERATIONS = 3
_AS_GOOD = 1.1
"""In another order the fit may end elsewhere: it must leave as little."""


def judged_together(turns: Sequence[Turn]) -> tuple[Turn, ...]:
    """Turns of the search in the order of what their effects take away, without those that are needless.

    Parameters
    ----------
    turns : sequence of Turn
        As the search left them.
    """
    accepted = [turn for turn in turns if turn.accepts]
    if len(accepted) < 2:
        return tuple(turns)
    whole = accepted[-1].confirmed[0].fit
    own = whole.state.placed[-len(accepted) :]
    lost = [predicted(_without(whole, len(own) - i)) for i in range(len(own))]
    order = sorted(range(len(own)), key=lambda i: lost[i])
    if order == sorted(order):
        return tuple(turns)
    chain: list[Turn] = []
    before = accepted[0].before
    for i in order:
        found = confirmed_from(before, Start.of(before, own[i]))
        if found is None:
            return tuple(turns)
        turn = _in_place_of(accepted[i], before, found)
        if chain and not turn.is_worth_another(accepted[0].before.mean_square):
            break
        chain.append(turn)
        before = replace(found.fit, begun=before.begun)
    return tuple(chain) if before.mean_square < _AS_GOOD * whole.mean_square else tuple(turns)


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
