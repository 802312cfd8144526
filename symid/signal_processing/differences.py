"""Central differences: derivatives of sampled signals, and the gain and bandwidth that differencing leaves."""

import math
from bisect import bisect_left
from functools import lru_cache, reduce
from typing import Final

import numpy as np
import numpy.typing as npt

from symid.arrays import FloatArray
from symid.errors import SettingError

_BLOCK: Final = 16_384  # samples of a block that stays in the cache between two operations on it
_BISECTIONS: Final = 52  # to the last digit of a frequency


def central_difference(x: npt.ArrayLike, sampling_period: float, *, order: int = 2) -> FloatArray:
    """First derivative by central differences, equation [31], one-sided at the two ends.

    Parameters
    ----------
    x : array_like of shape (..., n_samples)
        Signal, or one signal per row; at least two samples.
    sampling_period : float
        Time between two samples, s.
    order : int
        Order of accuracy, an even number: 2 is the paper's difference of the two neighbours. A higher one takes more
        neighbours on either side, half as many as its number; near the ends the order is reduced.

    Returns
    -------
    array of shape (..., n_samples)

    Raises
    ------
    SettingError
        If there are fewer than two samples, or the order is not possible.

    Examples
    --------
    >>> central_difference([0.0, 1.0, 4.0, 9.0], 1.0).tolist()
    [1.0, 2.0, 4.0, 5.0]
    """
    values = np.asarray(x, dtype=np.float64)
    if values.ndim == 0 or values.shape[-1] < 2:
        raise SettingError("a difference needs at least 2 samples: give a longer signal")
    slope = np.empty(values.shape)
    for row in np.ndindex(values.shape[:-1]):
        _difference_row(values[row], sampling_period, difference_factors(order), slope[row])
    return slope


@lru_cache(maxsize=16)
def difference_factors(order: int) -> tuple[float, ...]:
    """Factors c_k of (x[i+k] - x[i-k]) in the central difference of an even order, k = 1 to order/2.

    With m = order/2, c_k = (-1)^(k+1) (m!)^2 / (k (m-k)! (m+k)!) (B. Fornberg, Math. Comp. 51, 1988).

    Raises
    ------
    SettingError
        If the order is not even, or not from 2 to 20.

    Examples
    --------
    >>> difference_factors(2), [round(60 * c) for c in difference_factors(6)]
    ((0.5,), [45, -9, 1])
    """
    if order % 2 or not 2 <= order <= 20:
        raise SettingError(f"differences of order {order} are not possible: give an even number from 2 to 20")
    m = order // 2
    below = (k * math.factorial(m - k) * math.factorial(m + k) for k in range(1, m + 1))
    return tuple((-1) ** i * math.factorial(m) ** 2 / divisor for i, divisor in enumerate(below))


def _difference_row(x: FloatArray, period: float, factors: tuple[float, ...], out: FloatArray) -> None:
    last, reach = x.size - 1, min(len(factors), (x.size - 1) // 2)
    factors = factors if reach == len(factors) else difference_factors(2 * max(reach, 1))
    _inner_differences(x, [factor / period for factor in factors], out)
    for i in range(1, reach):
        fewer = np.array(difference_factors(2 * i)) / period
        out[i] = fewer @ (x[i + 1 : 2 * i + 1] - x[:i][::-1])
        out[last - i] = fewer @ (x[last - i + 1 :] - x[last - 2 * i : last - i][::-1])
    out[0] = (x[1] - x[0]) / period
    out[last] = (x[last] - x[last - 1]) / period


def _inner_differences(x: FloatArray, factors: list[float], out: FloatArray) -> None:
    """Differences where a signal has as many samples on either side as there are factors."""
    reach = len(factors)
    product = np.empty(min(_BLOCK, x.size))
    for first in range(reach, x.size - reach, _BLOCK):
        stop = min(first + _BLOCK, x.size - reach)
        block, more = out[first:stop], product[: stop - first]
        np.subtract(x[first + 1 : stop + 1], x[first - 1 : stop - 1], out=block)
        block *= factors[0]
        for k, factor in enumerate(factors[1:], 2):
            np.subtract(x[first + k : stop + k], x[first - k : stop - k], out=more)
            more *= factor
            block += more


def derivatives(
    x: npt.ArrayLike, sampling_period: float, order: int, *, accuracy: int = 2
) -> list[FloatArray]:
    """Derivatives of order 1 to `order`, each the central difference of the one before.

    Parameters
    ----------
    x : array_like of shape (..., n_samples)
        Signal, or one signal per row.
    sampling_period : float
        Time between two samples, s.
    order : int
        Highest derivative; 0 gives an empty list.
    accuracy : int
        Order of accuracy of each difference, as in `central_difference`.

    Returns
    -------
    list of array of shape (..., n_samples)

    Examples
    --------
    >>> [x[2:-2].tolist() for x in derivatives(np.arange(6.0) ** 2, 1.0, 2)]
    [[4.0, 6.0], [2.0, 2.0]]
    """
    found: list[FloatArray] = []
    current = np.asarray(x, dtype=np.float64)
    for _ in range(order):
        current = central_difference(current, sampling_period, order=accuracy)
        found.append(current)
    return found


def sparse_derivatives(
    x: FloatArray, sampling_period: float, order: int, kept: slice, *, accuracy: int = 2
) -> list[FloatArray]:
    """Samples `kept` of a vector and of its `derivatives`, without those of all others.

    Examples
    --------
    >>> [x.tolist() for x in sparse_derivatives(np.arange(9.0) ** 2, 1.0, 2, slice(1, 9, 3))]
    [[1.0, 16.0, 49.0], [2.0, 8.0, 14.0], [1.5, 2.0, 1.5]]
    """
    found, places = [x[kept]], range(*kept.indices(x.size))
    for m in range(1, order + 1):
        # Successive differences are one sum of samples, of differences to the middle one: as exact as those.
        factors = _successive_factors(m, accuracy)
        reach = len(factors) // 2
        if x.size < 4 * reach:
            found.append(derivatives(x, sampling_period, m, accuracy=accuracy)[-1][kept])
            continue
        begin, end = (bisect_left(places, place) for place in (reach, x.size - reach))
        values, inner = np.empty(len(places)), places[begin:end]
        if inner:
            near = np.lib.stride_tricks.sliding_window_view(x, len(factors))
            near = near[inner[0] - reach : inner[-1] - reach + 1 : places.step]
            values[begin:end] = (near - near[:, reach, None]) @ factors / sampling_period**m
        # Near the ends differences are of lower order.
        for part, first, stop in (
            (slice(0, begin), 0, 3 * reach),
            (slice(end, None), x.size - 3 * reach, x.size),
        ):
            if at := places[part]:
                dense = derivatives(x[first:stop], sampling_period, m, accuracy=accuracy)[-1]
                values[part] = dense[at[0] - first : at[-1] - first + 1 : places.step]
        found.append(values)
    return found


@lru_cache(maxsize=16)
def _successive_factors(times: int, order: int) -> FloatArray:
    """Factors of the samples around one in a number of successive central differences."""
    one_side = np.array(difference_factors(order))
    once = np.concatenate((-one_side[::-1], [0.0], one_side))
    return reduce(np.convolve, [once] * times)


def central_difference_gain(
    frequency: npt.ArrayLike, sampling_period: float, *, order: int = 2
) -> FloatArray:
    """Share of the true derivative that the central difference gives at `frequency` (Hz): sin(w T) / (w T) [33].

    That of a higher `order` of accuracy is the sum of 2 c_k sin(k w T) / (w T).

    Parameters
    ----------
    frequency : array_like
        Frequencies, Hz.
    sampling_period : float
        Time between two samples, s.
    order : int
        Order of accuracy, an even number.

    Examples
    --------
    >>> float(central_difference_gain(0.0, 0.001))
    1.0
    """
    turns = np.asarray(frequency, dtype=np.float64) * sampling_period
    factors = enumerate(difference_factors(order), 1)
    return np.asarray(sum(2.0 * k * factor * np.sinc(2.0 * k * turns) for k, factor in factors))[()]


@lru_cache(maxsize=64)
def differencing_bandwidth(differences: int, gain: float, *, order: int = 2) -> float:
    """Frequency over sampling frequency at which successive central differences keep a gain, equation [36].

    [sin(w T) / (w T)]^m = A is solved for w T / (2 pi). A cutoff frequency divided by it is the first guess of the
    sampling frequency in the paper's tuning.

    Parameters
    ----------
    differences : int
        Number m of successive differences, at least 1.
    gain : float
        Gain A to keep, between 0 and 1.
    order : int
        Order of accuracy of each difference, as in `central_difference`.

    Raises
    ------
    SettingError
        If the number or the gain is not possible.

    Examples
    --------
    The two sampling frequencies of the paper, from -0.08 dB and -0.045 dB at 164.42 Hz:

    >>> [round(164.42 / differencing_bandwidth(m, 10 ** (db / 20))) for m, db in ((4, -0.08), (2, -0.045))]
    [8791, 8289]
    """
    if differences < 1 or not 0.0 < gain < 1.0:
        raise SettingError(
            f"{differences} differences with a gain of {gain:g} are not possible: give 1 or more, "
            "and a gain between 0 and 1"
        )
    low, high = 1e-9, 0.5
    for _ in range(_BISECTIONS):
        share = 0.5 * (low + high)
        kept = max(float(central_difference_gain(share, 1.0, order=order)), 0.0) ** differences
        low, high = (share, high) if kept > gain else (low, share)
    return low
