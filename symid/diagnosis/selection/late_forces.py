"""Comparison of a delay with a lag of the same drive, in the band in which noise does not decide.

A lag amplifies the noise of the position in the predicted force at high frequencies, a lag of the recorder attenuates
it, and a delay changes no amplitude. Frequencies at which this noise exceeds that of the force are left out.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from symid.diagnosis.effects import LATE_FORCES
from symid.diagnosis.fitting.cross_validation import log_likelihood
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.gauss_newton import fitted
from symid.diagnosis.fitting.state import with_effects
from symid.diagnosis.prediction.weighting import Weighting
from symid.diagnosis.selection.step import Confirmed, SelectionStep, penalised_likelihood
from symid.errors import SymidError

_BAND = 0.5
"""Power of the weight of a force at the end of its band: noise of the position is then as large as its own."""

_ITERATIONS = 3
"""Iterations from the values of the whole band, in which noise that a lag increases makes it too short."""


def in_band_of_forces(fit: Fit) -> Weighting:
    """The weighting of a fit without the frequencies at which noise of the position exceeds that of a force."""
    density, of_noise = fit.weighting.density.copy(), fit.state.prediction.noise_density
    for i in range(fit.state.prediction.record.n_drives):
        density[i, of_noise[i] ** 2 < _BAND * of_noise[i].max() ** 2] = 0.0
    return replace(fit.weighting, density=density)


def other_predicts_better(step: SelectionStep, steps: Sequence[SelectionStep], weighting: Weighting) -> bool:
    """Whether the timing that leads a step predicts better than the selected one beside the same further effects."""
    last = steps[-1].best.fit
    placed = [step.best.placed if item.key == steps[0].best.key else item for item in last.state.placed]
    try:
        other = fitted(with_effects(last.state, last.weighting, tuple(placed)), last.weighting).state
    except (SymidError, ArithmeticError, np.linalg.LinAlgError):
        return True
    own = penalised_likelihood(steps, last.state, weighting)
    return penalised_likelihood(steps, other, weighting) > own


def compared_in_band(candidates: Sequence[Confirmed], before: Fit) -> list[Confirmed]:
    """Candidates in which the gains of delay and lag of a drive differ by their errors in its band."""
    found = list(candidates)
    late = [own for own in found if own.effect.name in LATE_FORCES]
    for place in {own.placed.at for own in late}:
        pair = [own for own in late if own.placed.at == place]
        if len(pair) > 1:
            found = [own for own in found if own not in pair] + _in_band(pair, before)
    return found


def _in_band(pair: Iterable[Confirmed], before: Fit) -> list[Confirmed]:
    """The better one in the band with the larger gain of both, and the other one with their difference in the band."""
    weighting, n = in_band_of_forces(before), before.n_rows
    squares = {
        own: fitted(own.fit.state.weighted(weighting), weighting, _ITERATIONS).blocks.squares for own in pair
    }
    first, *others = sorted(squares, key=lambda own: -log_likelihood(squares[own], n))
    most = max(squares, key=lambda own: own.gain)
    best = replace(first, gain=most.gain, certainty=most.certainty, squares=most.squares)
    behind = (
        replace(
            own,
            gain=most.gain + log_likelihood(squares[own], n) - log_likelihood(squares[first], n),
            squares=most.squares * (squares[own] / squares[first]),
        )
        for own in others
    )
    return [best, *behind]
