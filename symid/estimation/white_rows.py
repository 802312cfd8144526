"""Whitening of rows by an autoregressive model, compiled for hundreds of columns with few outputs and past rows."""

import numpy as np

from symid.jit import jitted


@jitted
def white_rows(rows, coefficients, whitening, usable):  # type: ignore[no-untyped-def]  # compiled
    """Whitened rows, (n, n_outputs, n_usable), from rows (n, n_outputs, n_rows); see `Autoregression`."""
    n, n_outputs, n_rows = rows.shape
    found, left = np.empty((n, n_outputs, usable.size)), np.empty((n_outputs, n_rows))
    for c in range(n):
        left[:] = rows[c]
        for i in range(n_outputs):
            own = left[i]
            for k in range(coefficients.shape[1]):
                for j in range(n_outputs):
                    share, past = coefficients[i, k, j], rows[c, j]
                    if share != 0.0:
                        for t in range(k + 1, n_rows):
                            own[t] -= share * past[t - k - 1]
        for i in range(n_outputs):
            white = found[c, i]
            for u in range(usable.size):
                white[u] = whitening[i, 0] * left[0, usable[u]]
            for j in range(1, n_outputs):
                for u in range(usable.size):
                    white[u] += whitening[i, j] * left[j, usable[u]]
    return found
