"""Iterative refinement: digits lost to rounding in the factorisation are recovered from the rows."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from symid.arrays import read_only
from symid.estimation.corrected_covariance import ObservationBlock
from symid.estimation.least_squares import LeastSquares

_CHUNK_ROWS = 16_384  # in extended precision at a time


def refine_blocks(blocks: Iterable[ObservationBlock], fit: LeastSquares) -> LeastSquares:
    """Refine the parameters of a fit by one step on the residual of its rows in extended precision.

    Corrected semi-normal equations (Bjorck, Linear Algebra and its Applications 88, 1987): the scalar products of the
    residual with the columns, which are 0 for the exact solution, are computed in extended precision and solved for the
    correction with the R of the fit. This gains digits for ill-conditioned problems whose scaled condition number is
    below about 1e8, at the cost of a few copies of a block's rows.

    Parameters
    ----------
    blocks : iterable of ObservationBlock
        All rows of the fit, in any order.
    fit : LeastSquares
        The estimate from these rows.

    Returns
    -------
    LeastSquares
        The fit with refined parameters; covariances and norms are unchanged.

    Examples
    --------
    >>> import numpy as np
    >>> from symid.estimation.least_squares import estimate
    >>> from symid.estimation.triangular import triangular_factors
    >>> x = np.arange(21.0)
    >>> W, y = np.stack([x**k for k in range(6)], axis=1)[None], sum(x**k for k in range(6))[None]
    >>> fit = estimate(triangular_factors(W, y))
    >>> bool(np.max(abs(refine_blocks([ObservationBlock(W, y)], fit).parameters - 1)) < 1e-12)
    True
    """
    exact = fit.solution.astype(np.longdouble)
    slope = np.zeros(len(exact), dtype=np.longdouble)
    for block in blocks:
        for j, weight in enumerate(fit.weights[block.equations]):
            for start in range(0, block.W.shape[1], _CHUNK_ROWS):
                part = slice(start, start + _CHUNK_ROWS)
                rows, output = block.W[j, part], block.y[j, part]
                if block.valid is not None:
                    rows, output = rows[block.valid[j, part]], output[block.valid[j, part]]
                columns = rows.astype(np.longdouble)
                slope += weight**2 * ((output - columns @ exact) @ columns)
    root = fit.rank.inverse_root
    solution = (exact + root @ (root.T @ slope)).astype(np.float64)
    parameters = np.where(np.isnan(fit.parameters), np.nan, solution)
    return replace(fit, parameters=read_only(parameters), solution=read_only(solution))
