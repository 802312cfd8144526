"""Systematic errors of an estimate that standard deviations do not contain: from noise in W and from differences.

Noise dW of the columns and dy of the output give W'S^2 (y - W X) the expectation c - C X at the true parameters X,
with C and c the sums over the rows of S^2 E[dW' dW] and S^2 E[dW' dy] (errors in variables; S. Van Huffel and
J. Vandewalle, The Total Least Squares Problem, SIAM 1991, chapter 8). The estimate is off by

    (W'S^2 W - C)^-1 (c - C X^)

which `identify` subtracts; deviations grow by (W'S^2 W - C)^-1 W'S^2 W. The noise of a signal is limited by the
residual: near Nyquist, where noise is estimated, jumps of friction in a force look like noise.

Rows made with sharper differences, laws of motion that is filtered less, and a force filtered as the motion is, have a
residual r at the estimate. Where they are right, the estimate is off by -(W'S^2 W)^-1 W'S^2 r.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symid.arrays import FloatArray, read_only
from symid.codegen import GeneratedModel
from symid.data import Log
from symid.estimation import CorrelatedCovariance, LeastSquares
from symid.identification.rows.excerpts import Excerpt, share_of_rows
from symid.identification.rows.noise import noise_levels, noise_limited_widening, noise_of_rows
from symid.identification.rows.observation import Observation, rows_by
from symid.identification.rows.settings import sharper

_COUNTS = 0.1
"""Share of the standard deviation beyond which a bias changes the coverage of an interval."""
_NOWHERE = -1
_MOST_NOISE = 0.9
"""Share of a column's power up to which noise is corrected."""
MOST_TAKEN = 0.5
"""Share of noise up to which the bias by it is removed from the estimate; with more a log cannot determine it."""
_LEFT = 0.1
"""Share of the bias by noise that may remain after the correction; 5 to 8 % on seed 501 of benchmarks.intervals, where
noise is white, as is assumed here."""


@dataclass(frozen=True, eq=False)
class Bias:
    """Expected error of parameters, by its cause; positive where the estimate is too high."""

    noise: FloatArray
    """Caused by sensor noise in the columns of W; shape (n_parameters,)."""
    preparation: FloatArray
    """Caused by central differences, reversals that the filter moves, or a force that is filtered unlike the
    motion; shape (n_parameters,)."""
    removed: FloatArray | None = None
    """Part that was already subtracted from the estimate; shape (n_parameters,), optional."""

    @property
    def total(self) -> FloatArray:
        """Sum of all parts of the bias."""
        return self.noise + self.preparation

    def mapped(self, sensitivity: FloatArray) -> Bias:
        """Bias of other parameters that are a function of these, to first order."""
        removed = None if self.removed is None else sensitivity @ self.removed
        return Bias(sensitivity @ self.noise, sensitivity @ self.preparation, removed)

    def dominates(self, deviations: FloatArray) -> tuple[int, ...]:
        """Parameters whose bias exceeds a tenth of the standard deviation.

        Examples
        --------
        >>> Bias(np.array([0.0, 0.3]), np.array([0.01, -0.1])).dominates(np.array([1.0, 1.0]))
        (1,)
        """
        return tuple(int(i) for i in np.flatnonzero(np.abs(self.total) > _COUNTS * deviations))


@dataclass(frozen=True, eq=False)
class NoiseBias:
    """Bias by sensor noise in W, the part that can be removed, and the matrix by which that amplifies errors."""

    whole: FloatArray
    removed: FloatArray
    growth: FloatArray

    @classmethod
    def of(cls, model: GeneratedModel, parts: Sequence[Excerpt], fit: LeastSquares) -> NoiseBias:
        """Bias of an estimate by noise, examined on logs or parts of them; all its parameters are determined."""
        p, root = fit.solution.size, fit.rank.inverse_root
        noise = np.zeros((p, p + 1))
        for part, weights in _weighted(model, parts, fit):
            rows = part.observation.valid.sum(axis=1)
            noise += np.einsum("j,jab->ab", weights * rows, _noise_shown(model, part, fit.solution))[:p]
        # W T has orthonormal columns: there, the share of noise in the power of each direction is an eigenvalue
        shares, directions = np.linalg.eigh(root.T @ noise[:, :p] @ root)
        growth = 1.0 / (1.0 - np.clip(shares, 0.0, _MOST_NOISE))
        taken, steps = shares < MOST_TAKEN, root @ directions
        moves = growth * (steps.T @ (noise[:, p] - noise[:, :p] @ fit.solution))
        grown = steps @ np.diag(np.where(taken, growth, 1.0)) @ np.linalg.pinv(steps)
        return cls(steps @ moves, steps @ np.where(taken, moves, 0.0), grown)


def _noise_shown(model: GeneratedModel, part: Excerpt, X: FloatArray) -> FloatArray:
    """Covariance of the noise of a row; the noise of each signal is limited to what the residual of the rows allows."""
    seen, error, found = part.observation, np.append(X, -1.0), []
    shown = seen.squares(X) / np.maximum(seen.valid.sum(axis=1), 1)
    for name, level in part.levels.items():
        own = noise_of_rows(model, part.log, seen.preparation, {name: level})
        expected = np.einsum("a,jab,b->j", error, own, error)
        found.append(
            own * np.min(np.divide(shown, expected, out=np.ones_like(shown), where=expected > shown))
        )
    return np.asarray(np.sum(found, axis=0))


def _weighted(
    model: GeneratedModel, parts: Sequence[Excerpt], fit: LeastSquares
) -> Iterator[tuple[Excerpt, FloatArray]]:
    """Parts, each with the squared weights of its equations times the rows that one of its rows represents."""
    equations = len(model.output_names)
    for part, share in zip(parts, share_of_rows(parts, fit.rows), strict=True):
        yield part, fit.weights[part.of * equations : (part.of + 1) * equations] ** 2 * share


def _bias_of_preparation(model: GeneratedModel, parts: Sequence[Excerpt], fit: LeastSquares) -> FloatArray:
    slope, root = np.zeros(fit.solution.size), fit.rank.inverse_root
    for part, weights in _weighted(model, parts, fit):
        seen = part.observation
        rest = _rest_of_sharper_rows(model, part.log, seen, fit.solution, part.levels)
        own = np.where(seen.valid, seen.y - seen.W @ fit.solution, 0.0)  # over all rows it is orthogonal to W
        slope += np.einsum("j,jt,jta->a", weights, rest - own, seen.W)
    return np.asarray(-root @ (root.T @ slope))


@dataclass(frozen=True, eq=False)
class Correction:
    """Correction of an estimate for the noise in W: the bias that remains, and the growth of errors by it."""

    bias: Bias
    growth: FloatArray

    @classmethod
    def of(cls, model: GeneratedModel, parts: Sequence[Excerpt], fit: LeastSquares) -> Correction:
        """Correction of an estimate, examined on logs or parts of them; all its parameters are determined."""
        noise = NoiseBias.of(model, parts, fit)
        left = noise.whole - (1.0 - _LEFT) * noise.removed
        return cls(Bias(left, _bias_of_preparation(model, parts, fit), noise.removed), noise.growth)

    def grown(self, covariance: FloatArray) -> FloatArray:
        """Covariance of the parameters after the correction."""
        return self.growth @ covariance @ self.growth.T

    def applied(
        self, fit: LeastSquares, correlated: CorrelatedCovariance
    ) -> tuple[LeastSquares, CorrelatedCovariance]:
        """The estimate and its covariances after the correction."""
        assert self.bias.removed is not None
        fit = replace(
            fit,
            parameters=read_only(fit.parameters - self.bias.removed),
            solution=read_only(fit.solution - self.bias.removed),
            covariance=read_only(self.grown(fit.covariance)),
        )
        return fit, replace(correlated, covariance=read_only(self.grown(correlated.covariance)))


def bias_of_instruments(
    model: GeneratedModel,
    logs: Sequence[Log],
    observations: Sequence[Observation],
    fit: LeastSquares,
    instruments: Sequence[FloatArray],
) -> Bias:
    """Bias of an estimate (Z'S^2 W)^-1 Z'S^2 y: that of the preparation alone, noise does not bias it.

    Z is given for each observation, of the shape of its W; the rank of the fit is that of W.
    """
    p, root = fit.solution.size, fit.rank.inverse_root
    cross, slope = np.zeros((p, p)), np.zeros(p)
    per_log = fit.weights.reshape(len(observations), -1) ** 2
    for log, seen, Z, weights in zip(logs, observations, instruments, per_log, strict=True):
        used = np.where(seen.valid[..., None], Z, 0.0)
        cross += np.einsum("j,jta,jtb->ab", weights, used, seen.W, optimize=True)
        rest = _rest_of_sharper_rows(model, log, seen, fit.solution, noise_levels(model, log))
        slope += np.einsum("j,jt,jta->a", weights, rest, used)
    by_preparation = -root @ np.linalg.solve(root.T @ cross @ root, root.T @ slope)
    return Bias(np.zeros(p), by_preparation)


def _rest_of_sharper_rows(
    model: GeneratedModel, log: Log, seen: Observation, X: FloatArray, levels: Mapping[str, float]
) -> FloatArray:
    """Residual of an estimate in rows with differences of higher order; 0 in rows that are not used."""
    scheme = sharper(seen.preparation.difference_order)
    assert seen.preparation.cutoff_hz is not None
    widening = seen.preparation.widening or 1.0
    if widening < scheme.widening:
        quiet = noise_limited_widening(model, log, seen.preparation.cutoff_hz, levels, scheme.widening)
        widening = max(quiet, widening)
    chosen = replace(seen.preparation, filter_force=True)
    W, y = rows_by(_rest(model, X, chosen.coulomb or ()), log, chosen, replace(scheme, widening=widening))
    return np.where(seen.valid, y - W[..., 0], 0.0)


def _rest(model: GeneratedModel, X: FloatArray, coulomb: tuple[float, ...]) -> GeneratedModel:
    """Model of the residual that parameters leave: its only column is the laws, its output the residual of the others.

    Filters are linear: two rows per equation give the same result as all columns. Friction that is taken off the
    force beforehand, `coulomb`, is not given back to the output, but taken off the column of laws.
    """
    of_laws = np.zeros((len(model.output_names), X.size, 1))
    for equation, parameter in model.law_columns:
        of_laws[equation, parameter] = X[parameter]
    of_others = X[:, None] - of_laws
    for (_, parameter), level in zip(model.coulomb_at_drive, coulomb, strict=False):
        for equation, column in model.law_columns:
            of_laws[equation, parameter] -= level if column == parameter else 0.0
    return replace(
        model,
        minimal_units={"laws": "1"},
        coulomb_at_drive=tuple((row, _NOWHERE) for row, _ in model.coulomb_at_drive),
        law_columns=tuple((equation, 0) for equation in sorted({place[0] for place in model.law_columns})),
        regressor=lambda *signals: model.regressor(*signals) @ of_laws,
        output=lambda *signals: model.output(*signals) - (model.regressor(*signals) @ of_others)[..., 0],
    )
