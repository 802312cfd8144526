"""Do sensors that repeat each other agree? An accelerometer against the second derivative of a position."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symid.arrays import FloatArray
from symid.codegen import GeneratedModel
from symid.data import derivatives
from symid.identification.criteria import CRITERIA, Criteria
from symid.identification.excerpts import Excerpt
from symid.identification.sampling import filtered


def disagreement_of(model: GeneratedModel, parts: Sequence[Excerpt], criteria: Criteria = CRITERIA) -> str:
    """Which sensors differ in their gain, in words; empty if none does.

    The gain of one signal against another lies between its two regressions, whatever noise each has (R. Frisch,
    Statistical Confluence Analysis, Oslo 1934): sensors disagree if 1 is not within these bounds.
    """
    for name, terms in model.redundant:
        if not all(signal in part.log.signals for part in parts for signal in (name, *(t[0] for t in terms))):
            continue
        pairs = [_compared(model, part, name, terms) for part in parts]
        own, other = (np.concatenate([pair[k] for pair in pairs]) for k in (0, 1))
        crossed = float(own @ other)
        low, high = sorted(
            (crossed / max(float(other @ other), 1e-300), float(own @ own) / (crossed or 1e-300))
        )
        if low > 1.0 + criteria.gain or high < 1.0 - criteria.gain or crossed <= 0.0:
            what = " + ".join(f"derivative {order} of {signal}" for signal, order, _ in terms)
            return (
                f"{name} is {np.sqrt(max(low * high, 0.0)) * np.sign(crossed):.4g} times what other sensors say "
                f"({what}): correct its unit, sign or gain (--unit, --gain)"
            )
    return ""


def _compared(
    model: GeneratedModel, part: Excerpt, name: str, terms: Sequence[tuple[str, int, float]]
) -> tuple[FloatArray, FloatArray]:
    """A signal and what it should be, both low-passed as for the estimate, between the trimmed ends."""
    chosen, log = part.observation.preparation, part.log
    assert chosen.cutoff_hz is not None
    used = [name, *(signal for signal, _, _ in terms)]
    moved = {key: x[:] for key, x in filtered(model, log, chosen, 1.0, used).items()}
    before, after = chosen.trim or (0, 0)
    inside = slice(before, log.n_samples - after)
    expected = np.zeros(log.n_samples)
    for signal, order, factor in terms:
        x = moved[signal]
        expected += (
            factor * ([x, *derivatives(x, log.sampling_period, order, accuracy=chosen.difference_order)])[-1]
        )
    return moved[name][inside], expected[inside]
