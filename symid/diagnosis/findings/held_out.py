"""The effects that hold on data that took no part in any choice, the strongest first."""

from collections.abc import Callable, Sequence

import numpy as np

from symid.diagnosis.findings.comparison import Comparison
from symid.diagnosis.selection.backward import brought_first, without
from symid.diagnosis.selection.step import LATE_READING, SelectionStep, accepted_of
from symid.diagnosis.thresholds import THRESHOLDS

OnHeldOut = Callable[[Sequence[SelectionStep]], Comparison]
"""Comparison of the models of selection steps on held-out data."""


def without_worsening(
    steps: Sequence[SelectionStep], on_held_out: OnHeldOut
) -> tuple[Sequence[SelectionStep], Comparison]:
    """Models on the validation data, without effects beside others that make their error grow there."""
    comparison = on_held_out(steps)
    if comparison.worsened is None:
        return steps, comparison
    found = accepted_of(steps)
    rest = without(found, comparison.worsened)
    return (steps, comparison) if len(rest) == len(found) else without_worsening(rest, on_held_out)


def strongest_first(
    steps: Sequence[SelectionStep], comparison: Comparison, on_held_out: OnHeldOut
) -> tuple[Sequence[SelectionStep], Comparison]:
    """The effect that alone would leave the largest error of the force as the first, see `strengths`.

    Logs excite effects differently, and an effect that is found first takes over what it has in common with others. One
    that removes less than half of the largest share shows only beside the others and is not the first, unless it is
    clearly stronger: where the record wanders, the gap hardly counts low frequencies.
    """
    found = accepted_of(steps)[: comparison.validated]
    if len(found) < 2:
        return steps, comparison
    shares = [comparison.removed(i + 1, i + 2).share for i in range(len(found))]
    least = THRESHOLDS.stands_in * max(shares)
    if found[0].best.effect.name == LATE_READING and shares[0] >= least:
        return steps, comparison
    strengths = comparison.with_effects(len(found)).strengths
    for at in np.argsort(-strengths, kind="stable"):
        if at == 0 and shares[0] >= least:
            break
        ordered = brought_first(found, int(at))
        other = on_held_out(ordered)
        # A second fit leaves a little more or less of the noise, which is most of what a good model leaves.
        most = comparison.relative_error**2
        as_good = other.relative_error**2 < max(THRESHOLDS.as_good * most, most + THRESHOLDS.hardly_more_left)
        clearly = strengths[at] > THRESHOLDS.clearly_stronger * strengths[0]
        if as_good and other.validated > 0 and (clearly or other.removed(1, 2).share >= least):
            return ordered, other
    return steps, comparison
