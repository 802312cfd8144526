"""Is the recorded force in proportion to what the motion takes? A cubic of the prediction as one more column.

A force that is clipped, limited softly or wrapped around falls short where the prediction is large. The residual then
holds a cubic of the prediction (J. B. Ramsey, J. Royal Statistical Society B 31, 1969), of which the part that the model
itself explains is taken off.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symid.codegen import GeneratedModel
from symid.estimation import LeastSquares
from symid.identification.criteria import CRITERIA, Criteria
from symid.identification.excerpts import Excerpt
from symid.identification.whitened import WhitenedRows, whitened


def nonlinearity_of(
    model: GeneratedModel, parts: Sequence[Excerpt], fit: LeastSquares, criteria: Criteria = CRITERIA
) -> str:
    """What the force lacks where it is large, in words; empty if it is in proportion.

    Parameters
    ----------
    model : GeneratedModel
        The model identified.
    parts : sequence of Excerpt
        Logs or parts of them, with their observations.
    fit : LeastSquares
        The estimate, all parameters determined.
    criteria : Criteria
        From when on it counts.
    """
    of_force = [j for j, name in enumerate(model.output_names) if name == model.force]
    every = list(whitened(parts, fit))
    for j in of_force:
        rows = [r for r in every if r.equation == j]
        share, size = _cubic(rows)
        if share > criteria.nonlinear and abs(size) > criteria.nonlinear_output:
            less = "less" if size < 0 else "more"
            return (
                f"where {model.force} is large it is {less} than in proportion to the motion (a cubic takes away "
                f"{100 * share:.2g} % of the residual's power): it is clipped, limited, or its gain changes with it; "
                "record with a wider range"
            )
    return ""


def _cubic(rows: Sequence[WhitenedRows]) -> tuple[float, float]:
    """Part of the residual's power that a cubic of the prediction takes away, and its size as part of the output."""
    Z, r, y = (np.concatenate([getattr(x, name) for x in rows]) for name in ("Z", "residual", "prediction"))
    power = float(r @ r)
    scale = float(np.max(np.abs(y), initial=0.0))
    if not power > 0.0 or not scale > 0.0:
        return 0.0, 0.0
    cubic = (y / scale) ** 3
    own = cubic - Z @ np.linalg.lstsq(Z, cubic, rcond=None)[0]
    rest = float(own @ own)
    if rest < 1e-8 * float(cubic @ cubic):
        return 0.0, 0.0
    factor = float(own @ r) / rest
    size = np.sign(factor) * np.sqrt(factor**2 * rest / max(float(y @ y), np.finfo(float).tiny))
    return factor**2 * rest / power, float(size)
