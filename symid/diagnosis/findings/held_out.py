"""Effects that also lower the error of held-out data, the strongest first."""

from collections.abc import Callable, Sequence

import numpy as np

from symid.diagnosis.effects import LATE_FORCES, time_of
from symid.diagnosis.findings.comparison import Comparison
from symid.diagnosis.findings.diagnosis_result import Diagnosis
from symid.diagnosis.fitting.applied import fitted_to_log
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.gauss_newton import ITERATIONS, fitted
from symid.diagnosis.selection.backward import brought_first, without
from symid.diagnosis.selection.step import LATE_READING, SelectionStep, accepted_of
from symid.diagnosis.thresholds import THRESHOLDS
from symid.errors import SymidError

_ELSEWHERE = 5.0
"""Mean square left of the validation log relative to that of the other log, both in multiples of the noise, from which
on something acts there that does not act here."""
OnHeldOut = Callable[[Sequence[SelectionStep]], Comparison]
"""Comparison of the models of selection steps on held-out data."""


def without_worsening(
    steps: Sequence[SelectionStep], on_held_out: OnHeldOut
) -> tuple[Sequence[SelectionStep], Comparison]:
    """Steps and their comparison on held-out data, without effects that increase the error there.

    A delay or lag of the force with another time there is dropped too.
    """
    comparison, found = on_held_out(steps), accepted_of(steps)
    unfit = _worsening(comparison)
    if unfit is None and found:
        unfit = _timing_that_varies(found[-1].best.fit, comparison)
    if unfit is None:
        return steps, comparison
    if len(found) == 1:
        return steps, comparison.with_effects(0)
    rest = without(found, unfit)
    return (steps, comparison) if len(rest) == len(found) else without_worsening(rest, on_held_out)


def _worsening(comparison: Comparison) -> int | None:
    """Index of the first of several effects that clearly increases the error, or cannot be judged on these data.

    It cannot be judged if the motion diverges, or if its values fitted to this log are not plausible, as of a
    disturbance with few cycles.
    """
    n_effects = len(comparison.states) - 2
    grows = (
        n
        for n in range(n_effects)
        if _is_unfit(comparison, n + 2) or comparison.removed(n + 1, n + 2).high < 0
    )
    return next(grows, None) if n_effects > 1 else None


def _is_unfit(comparison: Comparison, model: int) -> bool:
    """Whether a model diverges here, or its last effect is fitted to each log and not plausible in this one.

    An effect that has the same values when it is fitted to this log beside the others is kept.
    """
    state, whole = comparison.states[model], comparison.states[-1]
    if state is None:
        return True
    item = state.placed[-1]
    if not item.effect.per_log or item.effect.is_plausible(state.prediction, item):
        return False
    if whole is None:
        return True
    here = fitted_to_log(whole, comparison.weighting).placed[len(state.placed) - 1]
    return not item.effect.recurs(item, here)


def _timing_that_varies(found: Fit, comparison: Comparison) -> int | None:
    """Index of the first delay or lag of a fit that has clearly another time on the data of a comparison.

    The clock of a recorder and a current loop have one time. Where a controller counteracts a force that the model
    lacks, the recorded force follows the motion as behind a delay, and the apparent time depends on the motion. A delay
    that explains the other data counts whatever its time, as a recorder may be late by another time after each start.
    """
    state = comparison.states[-1]
    if state is None or not any(item.effect.name in LATE_FORCES for item in found.state.placed):
        return None
    try:
        own = fitted(state, comparison.weighting, ITERATIONS)
        deviations = [fit.standard_deviations for fit in (found, own)]
    except (SymidError, ArithmeticError, np.linalg.LinAlgError):
        return None
    if own.mean_square < THRESHOLDS.clear_gap:
        return None
    for i, (item, here) in enumerate(zip(found.state.placed, own.state.placed, strict=True)):
        if item.effect.name not in LATE_FORCES:
            continue
        time, other = time_of(item), time_of(here)
        at = found.state.values_of[i].stop - 1
        deviation = np.hypot(*(each[at] for each in deviations))
        if abs(other - time) > max(THRESHOLDS.other_time * deviation, THRESHOLDS.far_other_time * abs(time)):
            return i
    return None


def strongest_first(
    steps: Sequence[SelectionStep], comparison: Comparison, on_held_out: OnHeldOut
) -> tuple[Sequence[SelectionStep], Comparison]:
    """Steps with the effect first that alone would leave the largest error of the force, see `strengths`.

    Logs excite effects differently, and the effect that is found first absorbs the parts that others have in common
    with it. An effect that removes less than half of the largest share shows only beside the others and does not come
    first, unless it is clearly stronger: in a wandering record the gap hardly weights low frequencies.
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
        # A second fit leaves a little more or less of the noise, which is most of the error of a good model.
        most = comparison.relative_error**2
        as_good = other.relative_error**2 < max(THRESHOLDS.as_good * most, most + THRESHOLDS.hardly_more_left)
        clearly = strengths[at] > THRESHOLDS.clearly_stronger * strengths[0]
        if as_good and other.validated > 0 and (clearly or other.removed(1, 2).share >= least):
            return ordered, other
    return steps, comparison


def shows_in_validation(found: Diagnosis) -> bool:
    """Whether the validation log may show effects that the other log does not.

    The error of the model is then many times larger there, or without effects, only noise remains of the other log.
    """
    if not found.search or found.verdict not in ("unexplained", "partly", "effect"):
        return False
    steps = accepted_of(found.search)[: len(found.effects)]
    fit = steps[-1].best.fit if steps else found.search[0].before
    other = (found.gap.explained.rms / found.gap.noise_floor.rms) ** 2
    only_noise = found.verdict != "effect" and fit.mean_square < THRESHOLDS.fit_of_noise
    return only_noise or other > _ELSEWHERE * fit.mean_square
