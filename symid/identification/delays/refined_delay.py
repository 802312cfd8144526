"""Delay of some signals near a start, by Gauss-Newton iterations; of a force, without the part that noise causes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from symid.arrays import FloatArray
from symid.estimation import LeastSquares, corrected_covariance_of_blocks
from symid.identification.rows.excerpts import Excerpt, blocks_of, estimate_of
from symid.identification.rows.observation import Observation, observe

_SETTLED = 0.01
"""Last step, in samples, below which the iterations end."""
_MOST_ROUNDS = 8
_FARTHEST = 0.25
"""Periods of the cutoff frequency, beyond which a delay of filtered signals is not unique."""
_LOWER_CUTOFFS = (0.5, 0.25)
"""Parts of the cutoff at which a delay of a force is sought again."""
_ROWS_A_PARAMETER = 50
"""Fewest rows per parameter at a lower cutoff."""


@dataclass(frozen=True, eq=False)
class Delay:
    """Delay of signals, its deviation, and residual and parameters with it, as in `Timing`."""

    late: float
    deviation: float
    remaining: float
    parameters: FloatArray


def refined(
    parts: Sequence[Excerpt], shifting: Sequence[Shifting], fit: LeastSquares, start: float
) -> Delay | None:
    """The delay near a start, by Gauss-Newton iterations; None if they diverge."""
    period = parts[0].log.sampling_period
    cutoff = parts[0].observation.preparation.cutoff_hz
    assert cutoff is not None
    late, X = start, fit.solution
    for _ in range(_MOST_ROUNDS):
        # The derivative of the residual by the delay is one more column: its parameter is the Gauss-Newton step.
        extended = [shifted.with_tangent(late, X) for shifted in shifting]
        blocks = blocks_of(extended)
        found = estimate_of(extended)
        if found.status != "ok":
            return None
        X, step = found.solution[:-1], float(found.solution[-1])
        late += step
        if abs(late - start) > max(_FARTHEST / cutoff, 5 * period):
            return None
        if abs(step) < _SETTLED * period:
            break
    else:
        return None
    correlated = corrected_covariance_of_blocks(lambda: blocks, found)
    equations = len(parts[0].observation.y)
    before = np.sum([part.observation.squares(fit.solution) for part in parts], axis=0)
    after = np.sum(np.reshape(found.residual_norm**2, (-1, equations)), axis=0)
    # each equation has its own unit: the mean of what is left of each
    remaining = float(np.sqrt(np.mean(after / np.maximum(before, np.finfo(float).tiny))))
    return Delay(late, float(correlated.standard_deviations[-1]), remaining, X)


class Shifting:
    """Rows of a log with some signals moved in time."""

    def __init__(self, part: Excerpt, names: tuple[str, ...]) -> None:
        self.observation = part.observation
        self._rows = part.moved(*names)
        self._slope = self._rows.slope

    def with_tangent(self, late: float, X: FloatArray) -> Observation:
        """Rows of a delay, with the derivative of W X - y by the delay as one more column."""
        W, y = self.observation.W, self.observation.y
        if late:
            changed = self._rows.change(late)
            W, y = W + changed[0], y + changed[1]
        tangent = self._slope[0] @ X - self._slope[1]
        return replace(self.observation, W=np.concatenate([W, tangent[..., None]], axis=2), y=y)


def beyond_feedback(
    parts: Sequence[Excerpt], fit: LeastSquares, names: tuple[str, ...], found: Delay
) -> Delay:
    """The delay of forces at the cutoff, or a lower one, at which it is most certain.

    A controller turns the encoder's noise into force. It is then in the residual and in the derivative of the force,
    and looks like a delay. It grows with at least the third power of the frequency, so lower cutoffs leave little of
    it.
    """
    best = found
    for factor in _LOWER_CUTOFFS:
        lower = [_at_lower_cutoff(part, factor) for part in parts]
        seen = [part.observation for part in lower]
        without = estimate_of(seen)
        if without.status != "ok" or min(without.rows) < _ROWS_A_PARAMETER * without.solution.size:
            break
        other = refined(lower, [Shifting(part, names) for part in lower], without, found.late)
        if other is None or not other.deviation < best.deviation:
            break
        changed = fit.solution + other.parameters - without.solution
        best = replace(other, remaining=found.remaining, parameters=changed)
    return best


def _at_lower_cutoff(part: Excerpt, factor: float) -> Excerpt:
    """An excerpt with rows at a part of its cutoff."""
    chosen = part.observation.preparation
    assert chosen.cutoff_hz is not None
    lower = replace(chosen, cutoff_hz=factor * chosen.cutoff_hz, trim=None)
    return Excerpt(part.model, part.log, observe(part.model, part.log, lower), part.of)
