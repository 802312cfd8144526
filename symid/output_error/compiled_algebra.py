"""Algebra of small matrices as compiled loops; imported when a search runs, as Numba takes 0.3 s."""

import numpy as np

from symid.jit import inner, jitted

_DOUBLINGS = 60  # of the horizon: 2^60 samples
_SETTLED = 1e-13  # relative change of the covariance


@jitted
def doubled(A, G, H):  # type: ignore[no-untyped-def]
    """Solve H = A' H (1 + G H)^-1 A + H0 from H = H0, in place; whether a solution is found.

    Structure-preserving doubling algorithm (Chu, Fan, Lin, Wang 2004): each step doubles the horizon of the Riccati
    recursion, so that H is the covariance after 2**k samples after k of them.
    """
    n = len(A)
    P, W, HW, AW = np.empty((n, n)), np.empty((n, 2 * n)), np.empty((n, 2 * n)), np.empty((n, 2 * n))
    for _ in range(_DOUBLINGS):
        # [W1 W2] = (1 + G H)^-1 [A G]
        _product(G, H, P)
        for i in range(n):
            P[i, i] += 1.0
            for j in range(n):
                W[i, j], W[i, n + j] = A[i, j], G[i, j]
        _solve(P, W)
        _product(H, W, HW)
        _product(A, W, AW)
        # H += A' H W1, G += A W2 A', A = A W1
        largest, change = 0.0, 0.0
        for i in range(n):
            for j in range(i + 1):
                more, spread = 0.0, 0.0
                for k in range(n):
                    more += (A[k, i] * HW[k, j] + A[k, j] * HW[k, i]) / 2
                    spread += (AW[i, n + k] * A[j, k] + AW[j, n + k] * A[i, k]) / 2
                H[i, j] += more
                G[i, j] += spread
                H[j, i], G[j, i] = H[i, j], G[i, j]
                change, largest = max(change, abs(more)), max(largest, abs(H[i, j]))
        for i in range(n):
            for j in range(n):
                A[i, j] = AW[i, j]
        if change <= _SETTLED * largest:
            return True
    return False


@inner
def _product(A, B, into):  # type: ignore[no-untyped-def]
    for i in range(len(A)):
        for j in range(B.shape[1]):
            total = 0.0
            for k in range(len(B)):
                total += A[i, k] * B[k, j]
            into[i, j] = total


@inner
def _solve(A, B):  # type: ignore[no-untyped-def]
    """Gaussian elimination with exchange of rows; A is used up, B becomes the solution."""
    n, m = B.shape
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(A[i, k]) > abs(A[pivot, k]):
                pivot = i
        for j in range(n):
            A[k, j], A[pivot, j] = A[pivot, j], A[k, j]
        for j in range(m):
            B[k, j], B[pivot, j] = B[pivot, j], B[k, j]
        for i in range(k + 1, n):
            factor = A[i, k] / A[k, k]
            for j in range(k + 1, n):
                A[i, j] -= factor * A[k, j]
            for j in range(m):
                B[i, j] -= factor * B[k, j]
    for k in range(n - 1, -1, -1):
        for j in range(m):
            for i in range(k + 1, n):
                B[k, j] -= A[k, i] * B[i, j]
            B[k, j] /= A[k, k]
