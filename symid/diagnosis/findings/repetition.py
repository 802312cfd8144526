"""The part of an error that does not repeat with the motion: no law of the motion can explain it.

The noise floor of a diagnosis is that of the sensors, but a machine repeats itself less well. Where a log contains the
same motion several times, half the mean square of the difference between the errors of successive repetitions is the
part that differs each time, as with periodic excitation in the frequency domain (R. Pintelon and J. Schoukens, System
Identification: A Frequency Domain Approach, 2012).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.fft

from symid.arrays import BoolArray, FloatArray

_SAME = 0.02
"""Largest rms difference between two repetitions, relative to the rms of the motion."""
_SAME_SPEED = 0.1
"""Largest relative rms difference of the velocity, as faster motion on a repeated stroke must repeat too."""
_OTHER = 0.5
"""Relative difference that a lag must exceed first: a slow motion differs little from itself shortly after."""
_FEWEST = 40
"""Least number of compared rows."""


@dataclass(frozen=True)
class Repetition:
    """A motion that repeats, and the part of an error that does not."""

    rows: int  # from one repetition to the next
    rms: float  # of the part that differs each time, in the unit of the error


def repetition(motion: FloatArray, error: FloatArray, kept: BoolArray) -> Repetition | None:
    """The part of an error that differs in each repetition of a motion; None if the motion does not repeat.

    Motion and error are given at evenly spaced rows, shape (n,); the error counts in the `kept` ones.

    >>> t = np.arange(4000) / 1000
    >>> new = np.random.default_rng(1).standard_normal(t.size)
    >>> found = repetition(np.sin(2 * np.pi * t), 5 * np.cos(6 * np.pi * t) + new, np.ones(t.size, dtype=bool))
    >>> found.rows, round(found.rms, 1)
    (1000, 1.0)
    """
    lag = repeated_after(motion)
    if lag is None:
        return None
    both = kept[lag:] & kept[:-lag]
    if both.sum() < _FEWEST:
        return None
    difference = (error[lag:] - error[:-lag])[both]
    return Repetition(lag, float(np.sqrt(np.mean(difference**2) / 2)))


def repeated_after(motion: FloatArray) -> int | None:
    """Rows after which a motion first repeats, at most half of all; None if it does not repeat."""
    x = motion - motion.mean()
    n = x.size
    spectrum = scipy.fft.rfft(x, scipy.fft.next_fast_len(2 * n, real=True))
    products = scipy.fft.irfft(np.abs(spectrum) ** 2)[: n // 2 + 1]
    squares = np.concatenate([[0.0], np.cumsum(x**2)])
    # Mean squared difference at each lag, from the autocorrelation and cumulative sums of squares.
    lags = np.arange(products.size)
    apart = squares[n - lags] + squares[n] - squares[lags] - 2 * products
    power = float(np.mean(x**2))
    if power == 0.0:
        return None
    differs = np.sqrt(np.maximum(apart, 0.0) / (n - lags) / power)
    away = int(np.argmax(differs > _OTHER))
    same = np.flatnonzero(differs[away:] < _SAME) + away
    if not away or not same.size:
        return None
    # The lag of smallest difference in the first run of lags at which the motion repeats.
    first = same[: int(np.argmax(np.diff(same, append=n) > 1)) + 1]
    lag = int(first[np.argmin(differs[first])])
    speed = np.diff(motion)
    faster = np.sqrt(np.mean((speed[lag:] - speed[:-lag]) ** 2) / np.mean(speed**2))
    return lag if faster < _SAME_SPEED else None
