"""Envelopes of long curves: fewer points than samples, and no peak is lost."""

import numpy as np

from symid.arrays import FloatArray


def envelope(values: FloatArray, most: int) -> FloatArray:
    """Lowest and highest value of each bundle of samples, in order of time: no peak is lost.

    Two values for each bundle, at the places of `envelope_places`, nan where the whole bundle is nan; a curve of at
    most `most` points stays as it is.

    >>> envelope(np.array([0.0, 9.0, 1.0, 2.0, -5.0, 3.0, 4.0, 5.0]), most=4).tolist()
    [0.0, 9.0, -5.0, 5.0]
    """
    size = _bundle(values.size, most)
    if size == 1:
        return values
    padded = np.full(-(-values.size // size) * size, np.nan)
    padded[: values.size] = values
    bundles = padded.reshape(-1, size)
    low = np.argmin(np.where(np.isnan(bundles), np.inf, bundles), axis=1)
    high = np.argmax(np.where(np.isnan(bundles), -np.inf, bundles), axis=1)
    rows = np.arange(bundles.shape[0])[:, None]
    ends: FloatArray = bundles[rows, np.sort(np.stack([low, high], axis=1), axis=1)]
    return ends.ravel()


def envelope_places(places: FloatArray, most: int) -> FloatArray:
    """Places of the points of an envelope: beginning and middle of each bundle, the same for all curves.

    >>> envelope_places(np.arange(8.0), most=4).tolist()
    [0.0, 2.0, 4.0, 6.0]
    """
    size = _bundle(places.size, most)
    if size == 1:
        return places
    begin = np.arange(0, places.size, size)
    middle = np.minimum(begin + size // 2, places.size - 1)
    return np.stack([places[begin], places[middle]], axis=1).ravel()


def _bundle(count: int, most: int) -> int:
    return 1 if count <= most else -(-2 * count // most)
