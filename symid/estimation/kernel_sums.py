"""Sums of lagged products with a kernel of covariances, in the frequency domain."""

from functools import cache

import numpy as np

from symid.arrays import ComplexArray, FloatArray, fast_length


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
