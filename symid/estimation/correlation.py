"""Correlation of a residual over time: its covariances, its length, and the number of independent samples.

The residual of filtered signals is not white, which classical standard deviations assume.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from math import ceil, log10, sqrt

import numpy as np

from symid.arrays import BoolArray, ComplexArray, FloatArray, fast_length
from symid.errors import SettingError

_TRANSFORM = 65_536  # least samples of a transform of residuals


@dataclass(frozen=True)
class ResidualCovariance:
    """Lagged products of the residuals of all equations, summed over blocks in time order."""

    # shape (n_equations, n_equations, 2 max_lag + 1): sums of rho_i(t) rho_j(t+k) over pairs of valid rows, k =
    # -max_lag ... max_lag
    products: FloatArray
    pairs: FloatArray  # numbers of these pairs
    # tail_residual, tail_valid: shape (n_equations, at most max_lag): the last samples, to be paired with those
    # of the next block
    tail_residual: FloatArray
    tail_valid: FloatArray

    @classmethod
    def empty(cls, n_equations: int, max_lag: int) -> ResidualCovariance:
        """Sums over no samples; SettingError if there is no equation or the lag is negative.

        >>> ResidualCovariance.empty(2, 10).products.shape
        (2, 2, 21)
        """
        if n_equations < 1 or max_lag < 0:
            raise SettingError(f"{n_equations} equations and lag {max_lag}: at least 1 and 0 are required")
        sums = np.zeros((n_equations, n_equations, 2 * max_lag + 1))
        nothing = np.zeros((n_equations, 0))
        return cls(sums, sums, nothing, nothing)

    @property
    def max_lag(self) -> int:
        """Largest lag, in samples."""
        lags: int = self.products.shape[-1] // 2
        return lags

    def update(
        self, residual: FloatArray, valid: BoolArray | None = None, continues: bool = True
    ) -> ResidualCovariance:
        """Sums with a block of samples in time order added, of shape (n_equations, n_samples).

        Only `valid` samples count. No pair of samples spans two logs: a block that starts one `continues` nothing.

        >>> sums = ResidualCovariance.empty(1, 1).update(np.array([[1.0, 2.0, 3.0]]))
        >>> sums.covariance().round(9).tolist()
        [[[4.0, 4.666666667, 4.0]]]
        """
        mask = np.ones(residual.shape, dtype=bool) if valid is None else valid
        nothing = np.zeros((len(residual), 0))
        products, tail = self._added(residual, mask, self.tail_residual if continues else nothing)
        pairs, tail_valid = self._added(mask, mask, self.tail_valid if continues else nothing)
        return ResidualCovariance(self.products + products, np.rint(self.pairs + pairs), tail, tail_valid)

    def _added(
        self, x: FloatArray | BoolArray, valid: BoolArray, tail: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Lagged products of the valid samples of a block with each other and those before it, and its last samples."""
        keep = self.max_lag
        step = samples_of_window(keep, _TRANSFORM)
        sizes = fast_length(min(tail.shape[1] + x.shape[1], step + keep) + keep), fast_length(2 * keep + 1)
        powers = [np.zeros((len(x), len(x), size // 2 + 1), dtype=complex) for size in sizes]
        for start in range(0, x.shape[1], step):
            part = slice(start, start + step)
            window = np.concatenate([tail, np.where(valid[:, part], x[:, part], 0.0)], axis=1)
            powers[0] += _power(window, sizes[0])
            powers[1] += _power(tail, sizes[1])  # pairs within it have been counted
            tail = window[:, max(window.shape[1] - keep, 0) :]
        whole = _lags(powers[0], sizes[0], keep)
        return whole - _lags(powers[1], sizes[1], keep) if powers[1].any() else whole, tail

    def covariance(self) -> FloatArray:
        """gamma_ij(k), the mean product over valid pairs, 0 without pairs; shape of `products`."""
        return self.products / np.maximum(self.pairs, 1.0)


def samples_of_window(reach: int, least: int) -> int:
    """Samples by which windows advance, with `reach` samples before and as many zeros behind them.

    They make a power of two, the length of the fastest transforms, of which at most a quarter is not their own.

    >>> samples_of_window(100, 1024)
    824
    """
    return (1 << (max(8 * reach, least) - 1).bit_length()) - 2 * reach


def _power(x: FloatArray, size: int) -> ComplexArray:
    """Spectra of the lagged products of rows, padded to a size: shape (n, n, size // 2 + 1)."""
    if x.shape[1] == 0:
        return np.zeros((len(x), len(x), size // 2 + 1), dtype=np.complex128)
    X = np.fft.rfft(x, size, axis=1)
    return np.asarray(np.conj(X)[:, None, :] * X[None, :, :])


def _lags(power: ComplexArray, size: int, max_lag: int) -> FloatArray:
    """Sums over t of x_i(t) x_j(t + k), shape (n, n, 2 max_lag + 1), k from -max_lag; x is 0 outside."""
    circular = np.fft.irfft(power, size, axis=2)
    return np.concatenate([circular[..., size - max_lag :], circular[..., : max_lag + 1]], axis=2)


def default_max_lag(samples: int) -> int:
    """Default of the largest lag considered: 10 sqrt(samples), a quarter of the samples at most.

    >>> default_max_lag(10_000), default_max_lag(100)
    (1000, 25)
    """
    return min(samples // 4, ceil(10.0 * sqrt(samples)))


def correlation_length(covariance: FloatArray, samples: int) -> int | None:
    """Smallest lag beyond which the correlation is below its own uncertainty; None if there is none.

    The rule of Politis and White (Econometric Reviews 23, 2004): the smallest m with |r(m+k)| below
    2 sqrt(log10(N)/N) for k = 1 ... K. With their K of 5 lags, a zero crossing of the slow oscillation that a low-pass
    filter leaves would pass for the end of the correlation; here K is at least m, the length of the correlation.
    If there is no such lag, the bound is widened by Bartlett's variance of a correlated residual, sum of r^2 / N, as
    long as it remains below 0.5. gamma_ij(k) is given for one log or for each of several.

    >>> import numpy as np
    >>> gamma = np.zeros((1, 1, 41))
    >>> gamma[0, 0, 19:22] = 0.5, 1.0, 0.5
    >>> correlation_length(gamma, 10_000)
    1
    """
    correlation = _correlation(covariance)
    max_lag = covariance.shape[-1] // 2
    largest = np.max(np.abs(correlation), axis=tuple(range(correlation.ndim - 1)))
    strength = np.maximum(largest[max_lag:], largest[max_lag::-1])
    threshold = 2.0 * sqrt(log10(max(samples, 2)) / max(samples, 1))
    squares = max(1.0, float(np.max(_sums_of_squares(correlation))))
    length = _quiet_from(strength, threshold)
    if length is None and threshold * sqrt(squares) < 0.5:
        length = _quiet_from(strength, threshold * sqrt(squares))
    return length


def _quiet_from(strength: FloatArray, threshold: float) -> int | None:
    """First lag followed by at least 5 lags, and at least as many as itself, below the threshold."""
    above = np.flatnonzero(strength[1:] >= threshold) + 1
    starts = np.concatenate([[0], above])
    stops = np.concatenate([above, [len(strength)]])
    quiet = np.flatnonzero(stops - starts > np.maximum(starts, 5))
    return int(starts[quiet[0]]) if len(quiet) else None


def effective_samples(covariance: FloatArray, rows: tuple[int, ...]) -> float:
    """Number of independent samples that would estimate a variance equally well.

    N_j / sum over k of r_jj(k)^2, summed over the equations j, for a tapered `covariance`.

    >>> import numpy as np
    >>> effective_samples(np.array([[[0.5, 1.0, 0.5]]]), (300,))
    200.0
    """
    squares = _sums_of_squares(_correlation(covariance)).ravel()
    return float(np.sum(np.asarray(rows) / np.maximum(squares, 1.0)))


def flat_top(max_lag: int, length: int) -> FloatArray:
    """Trapezoidal taper: 1 up to lag `length`, 0 from 2 `length` on; shape (2 max_lag + 1,).

    >>> flat_top(3, 2).tolist()
    [0.5, 1.0, 1.0, 1.0, 1.0, 1.0, 0.5]
    """
    lags = np.abs(np.arange(-max_lag, max_lag + 1))
    return np.clip(2.0 - lags / max(length, 1), 0.0, 1.0) if length else (lags == 0).astype(np.float64)


def _correlation(covariance: FloatArray) -> FloatArray:
    middle = covariance.shape[-1] // 2
    deviation = np.sqrt(np.maximum(np.diagonal(covariance[..., middle], axis1=-2, axis2=-1), 0.0))
    scale = (deviation[..., :, None] * deviation[..., None, :])[..., None]
    correlation: FloatArray = np.divide(covariance, scale, out=np.zeros_like(covariance), where=scale > 0.0)
    return correlation


def _sums_of_squares(correlation: FloatArray) -> FloatArray:
    """Sum over the lags of r_jj(k)^2, shape (..., n_equations)."""
    return np.asarray(np.sum(np.diagonal(correlation, axis1=-3, axis2=-2) ** 2, axis=-2))


def correlation_matrix(covariance: FloatArray) -> FloatArray:
    """Correlation of a covariance; nan where a deviation is 0 or not known.

    >>> correlation_matrix(np.array([[4.0, 3.0], [3.0, 9.0]])).tolist()
    [[1.0, 0.5], [0.5, 1.0]]
    """
    deviations = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    known = np.where(deviations > 0, deviations, np.nan)
    with np.errstate(over="ignore", invalid="ignore"):  # a covariance from a file may hold anything
        return np.asarray(covariance / np.outer(known, known))


def with_nonnegative_spectrum(kernel: FloatArray) -> FloatArray:
    """Covariances with a non-negative spectrum: the given ones, or clipped ones up to twice the lag.

    The side lobes of the taper and masked pairs can make the spectrum negative. It is clipped at 0 (for several
    equations, its eigenvalues are), and what clipping spreads beyond twice the lag is left out.
    """
    reach = kernel.shape[2] // 2
    size = fast_length(8 * reach + 1)
    values, vectors = np.linalg.eigh(np.moveaxis(_spectrum(kernel, size), 2, 0))
    if values.min() >= -1e-12 * max(float(values.max()), 0.0):
        return kernel
    clipped = (vectors * np.maximum(values, 0.0)[:, None, :]) @ np.conj(np.swapaxes(vectors, 1, 2))
    circular = np.fft.irfft(np.moveaxis(clipped, 0, 2), size, axis=2)
    return np.concatenate([circular[..., size - 2 * reach :], circular[..., : 2 * reach + 1]], axis=2)


def _spectrum(kernel: FloatArray, size: int) -> ComplexArray:
    reach = kernel.shape[2] // 2
    circular = np.zeros((*kernel.shape[:2], size))
    circular[..., : reach + 1] = kernel[..., reach:]
    circular[..., size - reach :] = kernel[..., :reach]
    return np.asarray(np.fft.rfft(circular, axis=2), dtype=np.complex128)


class KernelSpectra:
    """Conjugate spectra of kernels for transforms of some lengths, each frequency standing for its negative too."""

    def __init__(self, kernel: FloatArray) -> None:
        self.reach = kernel.shape[2] // 2
        self.of_size = cache(lambda size: self._of_size(kernel, size))

    @staticmethod
    def _of_size(kernel: FloatArray, size: int) -> ComplexArray:
        G = _spectrum(kernel, size).conj() * (2.0 / size)
        G[..., 0] *= 0.5  # these have no negative
        if size % 2 == 0:
            G[..., -1] *= 0.5
        return G


def pair_sum(U: FloatArray, kernel: KernelSpectra) -> FloatArray:
    """Sum over i, j, k and t of kernel_ij(k) u_i(t) u_j(t+k)', by Parseval's theorem."""
    total = np.zeros((U.shape[1], U.shape[1]))
    if U.shape[2] == 0:
        return total
    size = fast_length(U.shape[2] + kernel.reach)
    X = np.fft.rfft(U, size, axis=2)
    for own, G in zip(X, kernel.of_size(size), strict=True):
        filtered = G[0] * X[0]
        for other, g in zip(X[1:], G[1:], strict=True):
            filtered += g * other
        total += own.view(np.float64) @ filtered.view(np.float64).T  # the real part of conj(own) @ filtered.T
    return total


def independent_rows(blocks: Iterable[tuple[FloatArray, BoolArray]]) -> float:
    """Number of independent rows with the same information as correlated residuals.

    Of each block, the residuals of its equations and which of them count, both of shape (n_equations, n_samples).

    >>> pairs = np.repeat(np.random.default_rng(1).standard_normal((1, 5000)), 2, axis=1)
    >>> bool(6000 < independent_rows([(pairs, pairs < np.inf)]) < 7000)
    True
    """
    every = list(blocks)
    counts = np.concatenate([np.count_nonzero(valid, axis=1) for _, valid in every])
    samples = int(counts.max())
    sums = [ResidualCovariance.empty(len(r), default_max_lag(samples)).update(r, valid) for r, valid in every]
    kernel, _ = tapered(np.stack([one.covariance() for one in sums]), samples)
    return effective_samples(kernel, tuple(counts.tolist()))


def tapered(gamma: FloatArray, samples: int) -> tuple[FloatArray, int | None]:
    """Autocovariances of the residuals of each log, and the lag beyond which they are noise; None if there is none.

    Gamma, the covariance of the residual, is banded and Toeplitz: its autocovariances are tapered to zero beyond the
    lag at which their sampling error exceeds them, since larger lags would add noise only.
    """
    lags = gamma.shape[-1] // 2
    length = correlation_length(gamma, samples)
    taper = flat_top(lags, lags // 2 if length is None else min(length, lags // 2))
    reach = int(np.count_nonzero(taper)) // 2
    return (gamma * taper)[..., lags - reach : lags + reach + 1], length
