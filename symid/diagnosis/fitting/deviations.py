"""Standard deviations of what was fitted, by two routes: the larger counts.

Errors taken as an autoregressive process show the effect of noise. The scatter of the gradients of blocks shows that of
errors of the model, which are correlated over any time.
"""

from __future__ import annotations

import numpy as np

from symid.arrays import FloatArray
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.prediction.weighting import autoregression

AR_ORDER = 6


def standard_deviations(fit: Fit) -> FloatArray:
    """Of parameters and effects' values, in their units, of shape (n_columns,)."""
    noise = autoregression(fit.left, fit.weighting.kept, AR_ORDER)
    columns = noise.apply(fit.base)
    scale = np.linalg.norm(columns, axis=1)
    scale = np.where(scale > 0, scale, 1.0)
    unit = columns / scale[:, None]
    inverse = np.linalg.pinv(unit @ unit.T, rcond=1e-13, hermitian=True)
    of_noise = (np.sqrt(np.maximum(np.diag(inverse), 0.0)) / scale)[: len(fit.columns)]
    of_blocks = np.sqrt(np.maximum(np.diag(fit.blocks.covariance), 0.0))
    return np.asarray(np.maximum(of_noise, of_blocks))
