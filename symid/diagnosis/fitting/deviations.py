"""Standard deviations of fitted values; the larger of two estimates counts.

The first takes the errors as an autoregressive process and shows the effect of noise. The second, from the scatter of
the gradients of blocks, shows the effect of model errors with any correlation. A value is not determined if it takes
part in a combination that leaves the prediction unchanged, such as a mass and the force constant of its drive: its
deviation is infinite.
"""

import numpy as np

from symid.arrays import FloatArray, norms_or_one
from symid.diagnosis.fitting.fit import Fit
from symid.estimation.autoregression import autoregression

AR_ORDER = 6
_NULL = 1e-13
"""Relative eigenvalue of the normal matrix of unit columns below which it counts as 0."""
_TAKES_PART = 1e-3
"""Least component with which a value takes part in an undetermined combination."""


def standard_deviations(fit: Fit) -> FloatArray:
    """Standard deviations of parameters and values of effects, in their units, of shape (n_columns,)."""
    noise = autoregression(fit.left, fit.weighting.kept, AR_ORDER)
    columns = noise.apply(fit.base)
    scale = norms_or_one(columns, axis=1)
    unit = columns / scale[:, None]
    # Variances from the eigenvectors that the rows determine; the null space marks the undetermined values.
    squares, directions = np.linalg.eigh(unit @ unit.T)
    seen = squares > _NULL * squares[-1]
    variances = directions[:, seen] ** 2 @ (1 / squares[seen])
    undetermined = (directions[:, ~seen] ** 2).sum(axis=1) > _TAKES_PART**2
    of_noise = np.where(undetermined, np.inf, np.sqrt(variances) / scale)[: len(fit.columns)]
    of_blocks = np.sqrt(np.maximum(np.diag(fit.blocks.covariance), 0.0))
    return np.asarray(np.maximum(of_noise, of_blocks))
