"""The estimate by instrumental variables from rows and instruments, and how strong these are."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from symid.arrays import FloatArray
from symid.estimation import LeastSquares
from symid.identification import Observation

_RESOLVED = 1e-12
"""Power of a combination of the instruments, as part of the largest, at which it is rounding and not correlated."""


@dataclass(frozen=True, eq=False)
class InstrumentalFit:
    """An estimate by instrumental variables, and how strong its instruments are."""

    # the parameters with their classical covariance; rank and conditions are those of least squares
    fit: LeastSquares
    # lowest canonical correlation between the columns of Z and of W: 1 if both span the same
    correlation: float

    def strength(self, effective_samples: float) -> float:
        """F of the weakest direction in the regression of W on Z, for a number of independent samples.

        Below about 10 instruments are weak (D. Staiger and J. Stock, Econometrica 65, 1997).
        """
        explained = min(self.correlation, 1.0) ** 2
        n = self.fit.solution.size
        return explained / max(1.0 - explained, 1e-12) * max(effective_samples - n, 0.0) / n


def estimate_by_instruments(
    observations: Sequence[Observation], instruments: Sequence[FloatArray], start: LeastSquares
) -> InstrumentalFit:
    """Estimate with instruments, one array of the shape of W for each observation.

    The start is the estimate by least squares from these rows, with all parameters determined: it gives the weights.
    """
    root, p = start.rank.inverse_root, start.solution.size
    cross, own, slope = np.zeros((p, p)), np.zeros((p, p)), np.zeros(p)
    for seen, Z, weights in zip(
        observations, instruments, start.weights.reshape(len(observations), -1), strict=True
    ):
        for j, weight in enumerate(weights):
            used = seen.valid[j]
            z, w = (weight * columns[j][used] @ root for columns in (Z, seen.W))
            # the estimate is a correction of the start: products with residuals lose fewer digits than with y
            rest = weight * (seen.y[j][used] - seen.W[j][used] @ start.solution)
            cross, own, slope = cross + z.T @ w, own + z.T @ z, slope + z.T @ rest
    gain = np.linalg.pinv(cross)  # instruments without information show in their correlation
    solution = start.solution + root @ (gain @ slope)
    values, vectors = np.linalg.eigh(own)
    # W T is orthonormal. With Z T made orthonormal too, the singular values are the canonical correlations.
    resolved = values > _RESOLVED * values[-1]
    orthonormal = np.where(resolved, vectors / np.sqrt(np.where(resolved, values, 1.0)), 0.0)
    correlation = float(np.linalg.svd(orthonormal.T @ cross, compute_uv=False)[-1])
    norms = np.array(
        [
            float(np.linalg.norm(y[used] - W[used] @ solution))
            for seen in observations
            for W, y, used in zip(seen.W, seen.y, seen.valid, strict=True)
        ]
    )
    sigma = float(np.linalg.norm(start.weights * norms)) / np.sqrt(max(sum(start.rows) - p, 1))
    spread = root @ gain
    fit = replace(
        start,
        method="iv",
        parameters=solution,
        solution=solution,
        covariance=sigma**2 * spread @ own @ spread.T,
        sigma_rho=sigma,
        sigma_rho_equation=norms / np.sqrt(np.maximum(np.array(start.rows) - p, 1)),
        residual_norm=norms,
    )
    return InstrumentalFit(fit, correlation)
