"""Standard deviations of what was fitted, by two routes: the larger counts.

Errors taken as an autoregressive process show the effect of noise. The scatter of the gradients of blocks shows that of
errors of the model, which are correlated over any time. What takes part in a combination that leaves the prediction as
it is, as a mass and the force constant of its drive do, is not determined: its deviation is infinite.
"""

from __future__ import annotations

import numpy as np

from symid.arrays import FloatArray
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.prediction.weighting import autoregression

AR_ORDER = 6
_NULL = 1e-13
"""Eigenvalues of the normal matrix of columns of unit length, relative to the largest, up to which one is 0."""
_TAKES_PART = 1e-3
"""Least component of a value in a combination that is not determined."""


def standard_deviations(fit: Fit) -> FloatArray:
    """Of parameters and effects' values, in their units, of shape (n_columns,)."""
    noise = autoregression(fit.left, fit.weighting.kept, AR_ORDER)
    columns = noise.apply(fit.base)
    scale = np.linalg.norm(columns, axis=1)
    scale = np.where(scale > 0, scale, 1.0)
    unit = columns / scale[:, None]
    squares, directions = np.linalg.eigh(unit @ unit.T)
    seen = squares > _NULL * squares[-1]
    variances = directions[:, seen] ** 2 @ (1 / squares[seen])
    undetermined = (directions[:, ~seen] ** 2).sum(axis=1) > _TAKES_PART**2
    of_noise = np.where(undetermined, np.inf, np.sqrt(variances) / scale)[: len(fit.columns)]
    of_blocks = np.sqrt(np.maximum(np.diag(fit.blocks.covariance), 0.0))
    return np.asarray(np.maximum(of_noise, of_blocks))
