"""Parameters by maximum likelihood on the exactly sampled axis: no derivatives of signals, no filter to choose.

The model predicts each reading from all earlier ones (`PredictionError`); parameters and noise ratios are those whose
innovations are least. Starts are tried with the modes of the axis at several frequencies below the Nyquist frequency:
a mode above it has an alias below that fits a sampled log as well.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from symid.codegen import GeneratedModel
from symid.estimation import (
    CorrelatedCovariance,
    LeastSquares,
    corrected_covariance,
    estimate,
    triangular_factors,
)
from symid.identification.physical import jacobian
from symid.output_error.search import RunError, Search
from symid.simulation import ForwardDynamics

_PASSES = 3
"""Times that unmeasured motion and timing are brought up to date."""


@dataclass(frozen=True, eq=False)
class LikelihoodFit:
    """Maximum-likelihood estimate.

    Parameters
    ----------
    search : Search
        Where it ended.
    linear : LeastSquares
        Of the model linearised there, in the order of `search.seen`, then the nuisance parameters.
    correlated : CorrelatedCovariance
        Its covariance, corrected for what correlation the innovations have left.
    """

    search: Search
    linear: LeastSquares
    correlated: CorrelatedCovariance

    @property
    def cost(self) -> float:
        """Mean square of the scaled innovations: the lower, the likelier."""
        return self.search.cost

    @property
    def noise(self) -> dict[str, float]:
        """Standard deviations of the noise of the force and of the readings of the first run, SI."""
        error, search = self.search.errors[0], self.search
        return error.noise(search.parameters, search.nuisance[0])


def fit_errors(
    model: GeneratedModel,
    dynamics: ForwardDynamics,
    errors: Sequence[RunError],
    starts: Sequence[Mapping[str, float]],
    nyquist: float,
) -> LikelihoodFit:
    """Maximum-likelihood parameters of an axis from its runs, the best that any start leads to.

    Parameters
    ----------
    model : GeneratedModel
        Says which physical parameters the sensors see.
    dynamics : ForwardDynamics
        The axis.
    errors : sequence of RunError
        One for each log of the axis.
    starts : sequence of mapping of str to float
        Physical parameters to begin with, masses and stiffnesses positive.
    nyquist : float
        Frequency above which no mode is looked for, Hz, unless all starts have one there.

    Raises
    ------
    numpy.linalg.LinAlgError
        If a run holds no motion, or no start can be evaluated.
    """
    if not all(error.has_motion for error in errors):
        raise np.linalg.LinAlgError("a run holds no motion")
    excerpts = [error.excerpt() for error in errors]
    limit = nyquist if any(dynamics.at(start).highest_mode < nyquist for start in starts) else math.inf
    beginnings = [Search.at(dynamics, excerpts, _seen(model, start), start, limit) for start in starts]
    trials = [search for search in beginnings if np.isfinite(search.cost)]
    if not trials:
        raise np.linalg.LinAlgError("no start can be evaluated")
    for iterations, survivors in errors[0].trials:
        trials = [trial.improved(iterations) for trial in trials]
        trials = sorted(trials, key=lambda trial: trial.cost)[:survivors]
    best = trials[0].continued(errors).weighted().improved()
    if not all(error.is_settled for error in errors):
        for _ in range(_PASSES):
            best = best.updated().improved()
    if len(errors) > 1:
        best = best.weighted().improved()
    W, y = best.linearised()
    linear = estimate(triangular_factors(W[None], y[None]))
    return LikelihoodFit(best, linear, corrected_covariance(W[None], y[None], linear))


def _seen(model: GeneratedModel, values: Mapping[str, float]) -> tuple[str, ...]:
    """Physical parameters on which any minimal parameter depends."""
    names = list(model.physical_units)
    slopes = jacobian(model, np.array([values[name] for name in names]))
    return tuple(name for name, column in zip(names, slopes.T, strict=True) if np.any(column != 0))
