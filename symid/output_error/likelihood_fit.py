"""Parameters by maximum likelihood on the exactly sampled axis: no derivatives of signals, no filter to choose.

The model predicts each reading from all earlier ones (`PredictionError`); parameters and noise ratios minimise the
innovations. Starts are tried with the modes of the axis at several frequencies below the Nyquist frequency: a mode
above it has an alias below that fits a sampled log as well.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from symid.arrays import FloatArray
from symid.codegen import GeneratedModel
from symid.estimation import (
    CorrelatedCovariance,
    LeastSquares,
    corrected_covariance,
    estimate,
    triangular_factors,
)
from symid.identification.deviations import Change, Segment, greatest_change, scatter, segments_of_rows
from symid.identification.parameters import jacobian
from symid.output_error.prediction_error import PredictionError
from symid.output_error.search import RunError, Search
from symid.simulation import ForwardDynamics

_PASSES = 3
"""Number of updates of the unmeasured motion and the timing."""
_ITERATIONS = 40
"""Iterations on the whole logs; a noise ratio that a step took far off needs more than 20 of them to come back."""
_HOPELESS = 100.0
"""Ratio of a trial's mean square to the best one above which the trial is dropped after its first iterations."""
_SAME = 1e-3
"""Relative difference of mean squares, and a tenth of that of parameters, below which two trials are one."""


@dataclass(frozen=True, eq=False)
class LikelihoodFit:
    """Maximum-likelihood estimate."""

    search: Search  # where it ended
    # of the model linearised there, in the order of `search.seen`, then the nuisance parameters
    linear: LeastSquares
    # its covariance, corrected for what correlation the innovations have left
    correlated: CorrelatedCovariance
    # parameters of the trials that were left after their first iterations, best first
    promising: tuple[Mapping[str, float], ...]
    parts: tuple[Segment, ...]  # sums over segments of the linearised model's rows
    bias: FloatArray  # expected shift of each parameter by noise in the record of the forces

    @property
    def cost(self) -> float:
        """Mean square of the scaled innovations: the lower, the likelier."""
        return self.search.cost

    @cached_property
    def covariance(self) -> FloatArray:
        """Covariance corrected for correlation, as large as that by scatter between segments, with the bias in it."""
        corrected = self.correlated.covariance
        by_segments = np.diag(scatter(self.parts, self.linear))
        with np.errstate(divide="ignore", invalid="ignore"):
            wider = np.fmax(np.sqrt(by_segments / np.diag(corrected)), 1.0)
        return np.asarray(corrected * np.outer(wider, wider) + np.outer(self.bias, self.bias))

    @cached_property
    def inflation(self) -> float:
        """Factor by which the correlation of the innovations raises each standard deviation."""
        return float(np.sqrt(self.linear.rows[0] / max(self.correlated.effective_samples, 1.0)))

    @cached_property
    def change(self) -> Change | None:
        """The span of the logs that separate parameters improve most."""
        return greatest_change(self.parts, self.linear.solution, self.linear.rank.inverse_root)

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

    Masses and stiffnesses of the starts are positive. No mode is looked for above `nyquist`, Hz, unless all starts have
    one there.
    """
    if not all(error.has_motion for error in errors):
        raise np.linalg.LinAlgError("a run holds no motion")
    promising = _promising(model, dynamics, [error.excerpt() for error in errors], starts, nyquist)
    trials = promising
    for iterations, survivors in errors[0].trials[1:]:
        trials = _ranked([trial.improved(iterations) for trial in trials])[:survivors]
    best = trials[0].continued(errors).updated().weighted().improved(_ITERATIONS)
    # Unmeasured motion and timing depend on the parameters, but are constant within a search: alternate until settled.
    if not all(error.is_settled for error in errors):
        for _ in range(_PASSES):
            if best.has_converged:
                best = best.updated().improved(_ITERATIONS)
    if len(errors) > 1 and best.has_converged:
        best = best.weighted().improved(_ITERATIONS)
    # At the optimum the linearised model is a linear regression: its corrected covariance is that of the estimate.
    W, y = best.linearised()
    linear = estimate(triangular_factors(W[None], y[None]))
    correlated = corrected_covariance(W[None], y[None], linear)
    parts = segments_of_rows(W, y, linear, best.rows)
    tried = tuple(trial.parameters for trial in promising)
    return LikelihoodFit(best, linear, correlated, tried, parts, _bias_by_noise(best, linear))


def _bias_by_noise(best: Search, linear: LeastSquares) -> FloatArray:
    """Expected shift of the parameters by noise in the record of the forces.

    The likelihood takes this noise for a disturbance, which moves the axis. Noise of the record alone is in the
    innovations and in their slopes, as in the columns of a regression with errors in variables: their product is
    taken from noise of the same levels. It is 0 for a disturbance and for forces that are simulated.
    """
    pairs = [
        error.of_noise(best.parameters, nuisance)
        for error, nuisance in zip(best.errors, best.nuisance, strict=True)
        if isinstance(error, PredictionError)
    ]
    if not pairs:
        return np.zeros(best.x.size)
    ahead, behind = (replace(best, errors=side) for side in zip(*pairs, strict=True))
    W = (ahead.linearised()[0] - behind.linearised()[0]) / 2
    rest = (ahead.residual(best.x) - behind.residual(best.x)) / 2
    share = np.repeat(np.array(best.rows) / ahead.rows, ahead.rows)
    root = linear.rank.inverse_root * linear.weights[0]
    return np.asarray(root @ (root.T @ (W.T @ (share * rest))))


def _promising(
    model: GeneratedModel,
    dynamics: ForwardDynamics,
    excerpts: Sequence[RunError],
    starts: Sequence[Mapping[str, float]],
    nyquist: float,
) -> list[Search]:
    """Trials from all starts after a few iterations, in order of cost, without hopeless ones."""
    limit = nyquist if any(dynamics.at(start).highest_mode < nyquist for start in starts) else math.inf
    beginnings = [
        Search.at(dynamics, excerpts, _visible_parameters(model, start), start, limit) for start in starts
    ]
    # a hidden body moves as each start predicts: at rest, its weight or friction would be put on other parameters
    trials = [search.updated() for search in beginnings if np.isfinite(search.cost)]
    if not trials:
        raise np.linalg.LinAlgError("no start can be evaluated")
    iterations, survivors = excerpts[0].trials[0]
    ranked = _ranked([trial.improved(iterations) for trial in trials])[:survivors]
    return [trial for trial in ranked if trial.cost <= _HOPELESS * ranked[0].cost]


def _ranked(trials: Sequence[Search]) -> list[Search]:
    """Trials in order of cost, without repetitions of the same minimum."""
    searches: list[Search] = []
    for trial in sorted(trials, key=lambda trial: trial.cost):
        if not any(_is_same(trial, better) for better in searches):
            searches.append(trial)
    return searches


def _is_same(trial: Search, better: Search) -> bool:
    if trial.cost > (1 + _SAME) * better.cost:
        return False
    pairs = ((trial.parameters[name], better.parameters[name]) for name in trial.seen)
    return all(abs(x - y) <= 10 * _SAME * abs(y) for x, y in pairs)


def _visible_parameters(model: GeneratedModel, values: Mapping[str, float]) -> tuple[str, ...]:
    """Physical parameters on which any minimal parameter depends."""
    names = list(model.physical_units)
    with np.errstate(divide="ignore", invalid="ignore"):  # some divide by a friction that starts at 0
        slopes = jacobian(model, np.array([values[name] for name in names]))
    return tuple(name for name, column in zip(names, slopes.T, strict=True) if np.any(column != 0))
