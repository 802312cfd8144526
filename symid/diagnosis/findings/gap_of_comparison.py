"""The gap of a comparison: the force error of its models before and after, near reversals, and in each repetition."""

from dataclasses import dataclass

import numpy as np
import scipy.fft

from symid.arrays import BoolArray, FloatArray
from symid.diagnosis.findings.comparison import Comparison
from symid.diagnosis.findings.gap import Gap, NotRepeated, Reversal
from symid.diagnosis.findings.shares import closed_fraction, closed_interval
from symid.diagnosis.prediction.corners import near_reversals

_FEW = 8
"""Least number of rows near reversals that show the level of their errors."""
_SAME = 0.02
"""Largest rms difference between two repetitions, relative to the rms of the motion."""
_SAME_SPEED = 0.1
"""Largest relative rms difference of the velocity, as faster motion on a repeated stroke must repeat too."""
_OTHER = 0.5
"""Relative difference that a lag must exceed first: a slow motion differs little from itself shortly after."""
_FEWEST = 40
"""Least number of compared rows."""


def gap_of(comparison: Comparison) -> Gap:
    """The force error of the models of a comparison."""
    axis, signal = comparison.record.dynamics.axis, comparison.record.forces[comparison.drive]
    re, explained = comparison.squares(1), comparison.squares(len(comparison.errors) - 1)
    return Gap(
        signal=signal,
        unit=str(axis.signal_units[signal]),
        band_hz=_half_power_hz(comparison),
        nominal=None if comparison.errors[0] is None else comparison.level(0),
        reidentified=comparison.level(1),
        explained=comparison.level(len(comparison.errors) - 1),
        noise_floor=comparison.level_of(comparison.floor),
        steps=tuple(comparison.level(i) for i in range(2, len(comparison.errors))),
        closed_fraction=closed_fraction(re, explained, comparison.floor),
        closed_interval=closed_interval(re, explained, comparison.floor),
        unexplained_share=comparison.unexplained_share,
        reversal=_reversal(comparison),
        not_repeated=_not_repeated(comparison),
    )


def _reversal(comparison: Comparison) -> Reversal | None:
    """Force error near reversals; None where the log has none."""
    turning = near_reversals(comparison.turns, comparison.row_rate)[comparison.weighting.kept]
    if turning.sum() < _FEW:
        return None
    re, explained = (
        comparison.level_of(float(np.sqrt(np.mean(comparison.squares(i)[turning]))))
        for i in (1, len(comparison.errors) - 1)
    )
    return Reversal(re, explained)


def _not_repeated(comparison: Comparison) -> NotRepeated | None:
    """Part of the last model's force error that differs in each repetition; None if the motion does not repeat."""
    record, inside = comparison.record, comparison.record.rows_in_log
    errors = comparison.errors[-1]
    if errors is None:
        return None
    motion, error = record.rows(comparison.motion)[inside], np.nan_to_num(errors[comparison.drive])[inside]
    found = repetition(motion, error, comparison.weighting.kept[inside])
    if found is None:
        return None
    return NotRepeated(found.rows / comparison.row_rate, comparison.level_of(found.rms))


def _half_power_hz(comparison: Comparison) -> float:
    """Frequency at which the weight of the force error has fallen by 3 dB."""
    fallen = np.flatnonzero(comparison.relative_density < np.sqrt(0.5))
    bins = fallen[fallen > 8]
    return float(comparison.record.omega[bins[0]] / (2 * np.pi)) if bins.size else comparison.record.band_hz


@dataclass(frozen=True)
class Repetition:
    """A motion that repeats, and the part of an error that does not."""

    rows: int  # from one repetition to the next
    rms: float  # of the part that differs each time, in the unit of the error


def repetition(motion: FloatArray, error: FloatArray, kept: BoolArray) -> Repetition | None:
    """The part of an error that differs in each repetition of a motion; None if the motion does not repeat.

    No law of the motion can explain it, and a machine repeats itself less well than its sensors. It is half the mean
    square of the difference between the errors of successive repetitions, as with periodic excitation in the frequency
    domain (R. Pintelon and J. Schoukens, System Identification: A Frequency Domain Approach, 2012). Motion and error
    are given at evenly spaced rows, shape (n,); the error counts in the `kept` ones.

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
