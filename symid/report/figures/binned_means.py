"""Means of a residual in bins of position or velocity."""

from dataclasses import dataclass

import numpy as np

from symid.arrays import FloatArray

_BINS, _FEWEST = 24, 5
"""Bins over the whole range, and the fewest samples of a shown mean."""


@dataclass(frozen=True, eq=False)
class Means:
    """Means of a residual in bins of equal width, at the mean places of the samples.

    `doubt` is twice the deviation of each mean, samples taken as independent.
    """

    places: FloatArray
    values: FloatArray
    doubt: FloatArray


def means_over(x: FloatArray, residual: FloatArray) -> Means:
    """Means of a residual over a signal, of shape (n_samples,), in two dozen bins of five samples or more.

    0 is an edge if the signal changes its sign.

    >>> found = means_over(np.repeat([-1.0, 2.0], 8), np.repeat([-3.0, 4.0], 8))
    >>> found.places.tolist(), found.values.tolist(), found.doubt.tolist()
    ([-1.0, 2.0], [-3.0, 4.0], [0.0, 0.0])
    """
    width = (np.ptp(x) if x.size else 0.0) / _BINS or 1.0
    bins = np.floor(x / width)
    parts = [part for b in np.unique(bins) if (part := np.flatnonzero(bins == b)).size >= _FEWEST]
    return Means(
        np.array([np.mean(x[part]) for part in parts]),
        np.array([np.mean(residual[part]) for part in parts]),
        np.array([2 * np.std(residual[part]) / np.sqrt(part.size) for part in parts]),
    )
