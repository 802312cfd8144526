"""Covariance of the parameters for a residual that is correlated over time and between equations.

The error of the parameters is A^-1 W' S^2 rho with A = W' S^2 W. For a stationary rho its covariance is

    A^-1 [ sum_ij S_i^2 S_j^2 sum_k taper(k) gamma_ij(k) sum_t w_i(t) w_j(t+k)' ] A^-1

with the auto- and cross-covariances gamma_ij of the residual, of which the classical covariance [22] uses lag 0 only.
The inner sums are computed in the frequency domain, window by window: O(N p log L) for lags up to L, with one window
in memory.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from symid.arrays import BoolArray, FloatArray, read_only
from symid.errors import SettingError
from symid.estimation.correlation import (
    KernelSpectra,
    ResidualCovariance,
    default_max_lag,
    effective_samples,
    pair_sum,
    samples_of_window,
    tapered,
    with_nonnegative_spectrum,
)
from symid.estimation.least_squares import LeastSquares, residuals
from symid.estimation.triangular import checked_observation

CorrelationStatus: TypeAlias = Literal["ok", "correlation_persists", "too_few_samples"]

_WINDOW = 16_384  # samples of a transform at least: those of all columns stay in the cache


@dataclass(frozen=True)
class ObservationBlock:
    """Consecutive samples of an observation, with shapes as in `corrected_covariance`.

    Its equations are those of the fit from index `equation` on: each log may have its own, with residuals independent
    of the other logs. `continues` is False where a new log begins, so that no correlation is taken across logs.
    `instruments`, shaped as W, are those of an estimate (Z'S^2 W)^-1 Z'S^2 y; all blocks have them or none.
    """

    W: FloatArray
    y: FloatArray
    valid: BoolArray | None = None
    continues: bool = True
    instruments: FloatArray | None = None
    equation: int = 0

    def __post_init__(self) -> None:
        W, y, valid = checked_observation(self.W, self.y, self.valid)
        for name, value in (("W", W), ("y", y), ("valid", valid)):
            object.__setattr__(self, name, value)

    @property
    def equations(self) -> slice:
        """Equations of the block among those of the fit."""
        return slice(self.equation, self.equation + len(self.W))


@dataclass(frozen=True)
class CorrelatedCovariance:
    """Covariance of the parameters under a correlated residual. Arrays are read-only."""

    status: CorrelationStatus
    """Either "ok"; "correlation_persists": the residual is correlated over all lags, which suggests a model error
    rather than noise; "too_few_samples": the fit absorbs half of the independent samples of the residual or more,
    and the covariance is nan."""
    covariance: FloatArray
    """In the caller's units; nan where parameters are not determined; shape (n_parameters, n_parameters)."""
    bandwidth: int
    """Lag in samples from which on the correlation is taken as 0."""
    effective_samples: float
    """Number of independent samples with the same information as the correlated residual."""
    degrees_of_freedom: float
    """Of Student's t for intervals from `covariance`: effective samples minus parameters, 1 at least."""

    @property
    def standard_deviations(self) -> FloatArray:
        """Standard deviations corrected for the residual's correlation, shape (n_parameters,)."""
        return np.sqrt(np.diag(self.covariance))


def corrected_covariance(
    W: FloatArray,
    y: FloatArray,
    fit: LeastSquares,
    valid: BoolArray | None = None,
    max_lag: int | None = None,
) -> CorrelatedCovariance:
    """Covariance of the parameters of `fit`, corrected for the correlation of its residual.

    Parameters
    ----------
    W : array, shape (n_equations, n_samples, n_parameters)
        Observation matrix in time order.
    y : array, shape (n_equations, n_samples)
        Output.
    fit : LeastSquares
        The estimate from these rows.
    valid : bool array, shape (n_samples,) or (n_equations, n_samples), optional
        Rows that entered the fit.
    max_lag : int, optional
        Largest lag considered, in samples; `default_max_lag` of the rows by default.

    Raises
    ------
    SettingError
        If the shapes do not match or the rows are not those of the fit.

    Examples
    --------
    Noise whose samples come in equal pairs has half as many independent samples:

    >>> import numpy as np
    >>> from symid.estimation.least_squares import estimate
    >>> from symid.estimation.triangular import triangular_factors
    >>> y = np.repeat(np.random.default_rng(1).standard_normal(5000), 2)[None]
    >>> W = np.ones((1, 10_000, 1))
    >>> fit = estimate(triangular_factors(W, y))
    >>> ratio = corrected_covariance(W, y, fit).covariance / fit.covariance
    >>> bool(1.8 < ratio.item() < 2.2)
    True
    """
    block = ObservationBlock(W, y, valid)
    return corrected_covariance_of_blocks(lambda: [block], fit, max_lag)


def corrected_covariance_of_blocks(
    read: Callable[[], Iterable[ObservationBlock]], fit: LeastSquares, max_lag: int | None = None
) -> CorrelatedCovariance:
    """Corrected covariance of an observation that is read block by block, twice.

    Parameters
    ----------
    read : callable
        Returns the blocks of all logs in time order, from the start at each call.
    fit : LeastSquares
        The estimate from these blocks.
    max_lag : int, optional
        Largest lag considered, in samples.

    Raises
    ------
    SettingError
        If the shapes do not match or the rows are not those of the fit.

    Examples
    --------
    >>> import numpy as np
    >>> from symid.estimation.least_squares import estimate
    >>> from symid.estimation.triangular import triangular_factors
    >>> W, y = np.ones((1, 100, 1)), np.random.default_rng(1).standard_normal((1, 100))
    >>> fit = estimate(triangular_factors(W, y))
    >>> halves = [ObservationBlock(W[:, half], y[:, half]) for half in (slice(50), slice(50, None))]
    >>> blockwise = corrected_covariance_of_blocks(lambda: halves, fit)
    >>> bool(np.allclose(blockwise.covariance, corrected_covariance(W, y, fit).covariance))
    True
    """
    samples = max(fit.rows)
    lags = default_max_lag(samples) if max_lag is None else max_lag
    by_log = _residual_covariances(read, fit, lags)
    kernel, length = tapered(np.stack(list(by_log.values())), samples)
    bandwidth = kernel.shape[-1] // 2 + 1
    # The taper has negative side lobes and can make Gamma indefinite; its spectrum is clipped to be positive.
    weighted = {}
    for first, own in zip(by_log, kernel, strict=True):
        weights = fit.weights[first : first + len(own)]
        weighted[first] = with_nonnegative_spectrum(own * np.multiply.outer(weights, weights)[:, :, None])
    scores = _score_covariance(read, fit, weighted)
    independent = effective_samples(kernel, fit.rows)
    noise = float(np.sum((fit.weights * fit.residual_norm) ** 2))
    absorbed = float(np.trace(scores)) / noise if noise > 0.0 else 0.0
    enough = absorbed < 0.5
    # The fit absorbs part of the noise, for any Gamma: E ||rho||^2 = trace(Gamma) - trace(scores). The covariance is
    # scaled up by this share.
    scale = 1.0 / (1.0 - absorbed) if enough else float("nan")
    root = fit.rank.inverse_root @ _gain_of_instruments(read, fit)
    covariance = scale * (root @ scores @ root.T)
    covariance[list(fit.undetermined)] = np.nan
    covariance[:, list(fit.undetermined)] = np.nan
    return CorrelatedCovariance(
        status="too_few_samples" if not enough else "correlation_persists" if length is None else "ok",
        covariance=read_only(covariance),
        bandwidth=bandwidth,
        effective_samples=independent,
        degrees_of_freedom=max(independent - fit.rank.rank, 1.0),
    )


def _gain_of_instruments(read: Callable[[], Iterable[ObservationBlock]], fit: LeastSquares) -> FloatArray:
    """(T' Z'S^2 W T)^-1, which maps scores of instruments to parameters; the identity without instruments."""
    product = np.zeros((fit.rank.rank, fit.rank.rank))
    for block in read():
        if block.instruments is None:
            return np.eye(fit.rank.rank)
        for j, weight in enumerate(fit.weights[block.equations]):
            rows = slice(None) if block.valid is None else block.valid[j]
            Z, W = (
                weight * columns[j][rows] @ fit.rank.inverse_root for columns in (block.instruments, block.W)
            )
            product += Z.T @ W
    return np.asarray(np.linalg.pinv(product))


def _residual_covariances(
    read: Callable[[], Iterable[ObservationBlock]], fit: LeastSquares, max_lag: int
) -> dict[int, FloatArray]:
    """gamma_ij(k) of each log, by the index of its first equation."""
    sums: dict[int, ResidualCovariance] = {}
    rows = np.zeros(len(fit.rows), dtype=int)
    for block in read():
        W, valid = block.W, block.valid
        if block.equations.stop > len(fit.rows) or W.shape[2] != len(fit.solution):
            raise SettingError(
                f"W has shape {W.shape}, but the fit {len(fit.rows)} equations and {len(fit.solution)} parameters: "
                "give the observation that was fitted"
            )
        rows[block.equations] += W.shape[1] if valid is None else np.count_nonzero(valid, axis=1)
        before = sums.get(block.equation, ResidualCovariance.empty(len(W), max_lag))
        sums[block.equation] = before.update(residuals(W, block.y, fit), valid, block.continues)
    if tuple(rows.tolist()) != fit.rows:
        raise SettingError(
            f"the equations have {rows.tolist()} valid rows, the fit has {list(fit.rows)}: give the fitted rows"
        )
    return {first: found.covariance() for first, found in sums.items()}


def _score_covariance(
    read: Callable[[], Iterable[ObservationBlock]], fit: LeastSquares, kernels: Mapping[int, FloatArray]
) -> FloatArray:
    """The sum in brackets for orthonormal columns, W S T, over all logs; shape (rank, rank).

    A window holds its own samples and the `reach` samples before them. Pairs among the latter were counted in the
    previous window and are subtracted.
    """
    total = np.zeros((fit.rank.rank, fit.rank.rank))
    spectra = {first: KernelSpectra(kernel) for first, kernel in kernels.items()}
    tails: dict[int, FloatArray] = {}
    for block in read():
        kernel = spectra[block.equation]
        tail = np.zeros((len(block.W), fit.rank.rank, 0))
        if block.continues:
            tail = tails.get(block.equation, tail)
        for U in _orthonormal_windows(block, fit, samples_of_window(kernel.reach, _WINDOW)):
            window = np.concatenate([tail, U], axis=2)
            total += pair_sum(window, kernel) - pair_sum(tail, kernel)
            tail = window[..., max(window.shape[2] - kernel.reach, 0) :]
        tails[block.equation] = tail
    values, vectors = np.linalg.eigh(0.5 * (total + total.T))
    return np.asarray((vectors * np.maximum(values, 0.0)) @ vectors.T)


def _orthonormal_windows(block: ObservationBlock, fit: LeastSquares, step: int) -> Iterator[FloatArray]:
    """Rows of W S T, or of the instruments, in windows of shape (n_equations, rank, n_samples), 0 where masked."""
    transform = [weight * fit.rank.inverse_root.T for weight in fit.weights[block.equations]]
    rows = block.W if block.instruments is None else np.asarray(block.instruments, dtype=np.float64)
    for start in range(0, rows.shape[1], step):
        part = slice(start, start + step)
        columns = np.swapaxes(rows[:, part], 1, 2)
        if block.valid is not None:
            columns = np.where(block.valid[:, None, part], columns, 0.0)
        yield np.stack([T @ w for T, w in zip(transform, columns, strict=True)])
