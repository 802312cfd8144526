"""First-order lag of a signal that was filtered before it was recorded: the time constant of least residual.

A signal F behind a lag was F + tau F' before it. Its rows are linear in tau as they are in F, so that Gauss-Newton
steps over tau and the parameters need no new rows. On flexible axes a lag imitates a damped mode: the residual is
small, and the parameters are another machine's.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symid.codegen import GeneratedModel
from symid.estimation import LeastSquares, estimate, triangular_factors
from symid.identification.criteria import CRITERIA, Criteria
from symid.identification.excerpts import Excerpt
from symid.identification.lag_scan import shiftable
from symid.identification.timing import Timing

_MOST_ROUNDS = 6
_SETTLED = 0.01
"""Relative change of the time constant that ends the rounds."""


def lag_of(
    model: GeneratedModel,
    parts: Sequence[Excerpt],
    fit: LeastSquares,
    timing: Timing | None = None,
    criteria: Criteria = CRITERIA,
) -> str:
    """Statement on a signal that lags; empty without one, or if a delay explains as much."""
    by_delay = timing.remaining if timing is not None and timing.is_significant else 1.0
    found = [(_remaining(parts, fit, name), name) for name in shiftable(model)]
    (remaining, lag), name = min(found, default=((1.0, 0.0), ""))
    if remaining > criteria.lagging * by_delay or lag < parts[0].log.sampling_period:
        return ""
    return (
        f"{name} lags with a time constant of {1e3 * lag:.3g} ms (without it, {100 * remaining:.3g} % of the residual "
        "remain), which biases all parameters: it was filtered before it was recorded, or the drive is slow; "
        "record it raw"
    )


def _remaining(parts: Sequence[Excerpt], fit: LeastSquares, name: str) -> tuple[float, float]:
    """Residual without the lag of a signal as part of that with it, and the time constant; 1 where none is found."""
    slopes = [part.moved(name).slope for part in parts]
    seen = [part.observation for part in parts]
    before = estimate([f for o in seen for f in triangular_factors(o.W, o.y, o.valid)])
    lag, X, found = 0.0, fit.solution, before
    for _ in range(_MOST_ROUNDS):
        rows = [
            (np.concatenate([o.W + lag * W, (W @ X - y)[..., None]], axis=2), o.y + lag * y, o.valid)
            for o, (W, y) in zip(seen, slopes, strict=True)
        ]
        found = estimate([factor for one in rows for factor in triangular_factors(*one)])
        if found.status != "ok":
            return 1.0, 0.0
        X, step = found.solution[:-1], float(found.solution[-1])
        lag += step
        if abs(step) < _SETTLED * abs(lag):
            break
    left, whole = found.residual_norm**2, np.maximum(before.residual_norm**2, np.finfo(float).tiny)
    return float(np.sqrt(np.mean(left / whole))), lag
