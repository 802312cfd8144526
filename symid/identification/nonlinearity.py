"""Is the recorded force in proportion to what the motion takes? A cubic of the prediction as one more column.

A force that is clipped, limited softly or wrapped around falls short where the prediction is large. The residual then
holds a cubic of the prediction (J. B. Ramsey, J. Royal Statistical Society B 31, 1969), less the part that the model
itself explains. A force that was smoothed lacks, in the same way, a part of its second derivative.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symid.arrays import FloatArray
from symid.codegen import GeneratedModel
from symid.estimation import LeastSquares
from symid.identification.criteria import CRITERIA, Criteria
from symid.identification.excerpts import Excerpt
from symid.identification.misfit import unexplained
from symid.identification.whitened import whitened

_NOISE_EXPLAINS = 1.5
"""Times the noise of the columns and the output up to which a residual says nothing of a force that was smoothed."""
_INDEPENDENT = 1e-8
"""Part of a column's power that the model's columns must leave of it."""


def nonlinearity_of(
    model: GeneratedModel, parts: Sequence[Excerpt], fit: LeastSquares, criteria: Criteria = CRITERIA
) -> str:
    """Compression of the force where it is large, in words; empty if it is in proportion."""
    of_force = [(j, name) for j, name in enumerate(model.output_names) if name in model.forces]
    every = list(whitened(parts, fit))
    beyond_noise = unexplained(model, parts, fit, replace(criteria, noise_explains=_NOISE_EXPLAINS))
    for j, force in of_force:
        rows = [r for r in every if r.equation == j]
        Z, rest, y = (
            np.concatenate([getattr(r, name) for r in rows]) for name in ("Z", "residual", "prediction")
        )
        scale = max(float(np.max(np.abs(y), initial=0.0)), np.finfo(float).tiny)
        share, size = _share(Z, rest, (y / scale) ** 3, y)
        if share > criteria.nonlinear and abs(size) > criteria.nonlinear_output:
            less = "less" if size < 0 else "more"
            return (
                f"where {force} is large it is {less} than in proportion to the motion (a cubic takes away "
                f"{100 * share:.2g} % of the residual's power): it is clipped, limited, or its gain changes with it; "
                "record with a wider range"
            )
        if any(name.startswith(f"{force}_d") for name in model.signals):
            continue  # flexible bodies make the same difference
        if not beyond_noise[j]:
            continue  # noise in W does too
        bent = np.concatenate([_bent(parts[r.part], fit, j) for r in rows])
        share, size = _share(Z, rest, bent, y)
        if share > criteria.nonlinear and size > criteria.smoothed_output:
            return (
                f"{force} lacks what is fast in the motion (its second derivative takes away {100 * share:.2g} % "
                "of the residual's power): it was smoothed; record it raw, or lower --cutoff"
            )
    return ""


def _bent(part: Excerpt, fit: LeastSquares, equation: int) -> FloatArray:
    """Second difference of the predicted output at the used rows of a part."""
    seen = part.observation
    predicted = seen.W[equation] @ fit.solution
    bent = np.zeros_like(predicted)
    bent[1:-1] = predicted[2:] - 2 * predicted[1:-1] + predicted[:-2]
    return np.asarray(bent[seen.valid[equation]])


def _share(Z: FloatArray, r: FloatArray, column: FloatArray, y: FloatArray) -> tuple[float, float]:
    """Part of the power of the residual r that a column takes away beyond those of Z, and its size by that of y."""
    power, whole = float(r @ r), float(column @ column)
    if not power > 0.0 or not whole > 0.0:
        return 0.0, 0.0
    own = column - Z @ np.linalg.lstsq(Z, column, rcond=None)[0]
    rest = float(own @ own)
    if rest < _INDEPENDENT * whole:
        return 0.0, 0.0
    factor = float(own @ r) / rest
    size = np.sign(factor) * np.sqrt(factor**2 * rest / max(float(y @ y), np.finfo(float).tiny))
    return factor**2 * rest / power, float(size)
