"""Samples that a recorder lost and filled with 0 or the last value, and their restoration from those beside them."""

from collections.abc import Collection, Mapping

import numpy as np
import scipy

from symid.arrays import BoolArray, FloatArray, IntArray, runs_of_true
from symid.text import counted

FEWEST_LOST = 3
"""Fewest lost samples of one channel that are reported for that channel alone."""
_LONGEST = 3
"""Most consecutive lost samples that are restored; the motion across a longer gap is unknown."""
_LEAST_DISTANCE = 0.25
"""Least difference of a lost sample from its neighbours, as a share of the rms signal."""
_ABOVE_NOISE = 5.0
"""Least difference in multiples of the usual second difference: noise turns coarse values into zeros."""
_LEAST_REPEATED, _MOST_REPEATED = 0.002, 0.3
"""Share of repeated rows: from the first on rows were lost, beyond the second a channel is slow, not lossy."""
_COARSE_SHARE = 0.4
"""Share of distinct values below which a channel is coarse."""
_COUNTS, _STEPS_A_VALUE, _ROUNDING = 5000, 200, 1e-3
"""Most counts in the range of a coarse channel of whole counts, or for each of its values, and the relative rounding of
counts in a file."""
_STRIDE, _LONG_CHANNEL = 16, 10_000
"""Stride of a first check for repeated values, and the number of samples above which it is made."""
_LEAST_STEPS = 12.0
"""Steps that the neighbours of a repeated value of a coarse channel must move for it to be suspicious."""
_BESIDE = 8
"""Samples on either side within which they must move: even a channel updated every eighth sample does."""
_MOST_LOST = 0.05
"""Share of the samples beyond which a channel is not restored: its faults are then reported."""


def dropped(x: FloatArray) -> BoolArray:
    """Samples that are exactly 0 with values far from 0 on both sides, within three samples.

    Of a channel of steps, which passes through 0, these values must be of one sign and far beyond its noise, also
    beside these samples: a controller whose encoder is coarse commands rough forces while the machine moves.

    >>> dropped(np.where(np.arange(30) == 7, 0.0, np.linspace(5.0, 6.0, 30))).nonzero()[0].tolist()
    [7]
    >>> noise = np.random.default_rng(0).standard_normal(300)
    >>> int(dropped(np.where(np.arange(300) % 5 == 2, 0.0, noise)).sum()) > 20, int(dropped(np.round(noise)).sum())
    (True, 0)
    """
    zero = np.flatnonzero(x == 0.0)
    is_dropped = np.zeros(x.size, dtype=np.bool_)
    if zero.size:
        far = _LEAST_DISTANCE * float(np.sqrt(np.mean(x**2)))
        inner = zero[(zero > 0) & (zero < x.size - 1)]
        before, after = np.zeros((2, inner.size))  # the nearest values other than 0
        for k in range(_LONGEST, 0, -1):
            earlier, later = x[np.maximum(inner - k, 0)], x[np.minimum(inner + k, x.size - 1)]
            before, after = np.where(earlier == 0.0, before, earlier), np.where(later == 0.0, after, later)
        nearest = np.minimum(np.abs(before), np.abs(after))
        is_lost = nearest > far
        if is_lost.any() and step_of(x) > 0.0:
            usual = float(np.median(np.abs(np.diff(x, 2))))
            is_lost &= (before * after > 0) & (
                nearest > np.maximum(_ABOVE_NOISE * usual, 2 * _roughness(x, inner))
            )
        is_dropped[inner[is_lost]] = True
    return is_dropped


def _roughness(x: FloatArray, at: IntArray) -> FloatArray:
    """Largest step between the four values other than 0 before, and those after, samples that are 0."""
    steps = np.abs(np.diff(x[x != 0.0]))
    across = np.cumsum(x != 0.0)[at] - 1  # index of the step from the value before to the value after
    beside = across + np.array([-3, -2, -1, 1, 2, 3])[:, None]
    return np.asarray(
        np.where((beside >= 0) & (beside < steps.size), steps.take(beside, mode="clip"), 0.0).max(axis=0)
    )


def repeated(x: FloatArray) -> BoolArray:
    """Samples equal to the one before, where the signal moves by many of its smallest steps around them."""
    n, is_repeated = _BESIDE, np.zeros(x.size, dtype=np.bool_)
    if x.size < 4 * n:
        return is_repeated
    step = np.abs(np.diff(x))
    moving = step[step > 0]
    if moving.size == step.size or moving.size < x.size // 20:
        return is_repeated
    smallest = float(np.quantile(moving, 0.01))
    noise = float(np.median(np.abs(np.diff(x, 2)))) / 2
    # between i and i + 1 nothing changes, though it moves the same way before and after
    before, after = x[n : -n - 1] - x[: -2 * n - 1], x[2 * n + 1 :] - x[n + 1 : -n]
    least = _LEAST_STEPS * max(smallest, noise)
    steady = (np.minimum(np.abs(before), np.abs(after)) > least) & (before * after > 0)
    odd, usual = (step[n:-n] == 0.0) & steady, np.abs(before + after) / (2 * n)
    # where the smallest steps come among large ones as often, rough values are rounded to the same by chance
    small = (step[n:-n] > 0.0) & (step[n:-n] < np.minimum(1.5 * smallest, 0.5 * usual)) & steady
    if 2 * np.count_nonzero(small) >= np.count_nonzero(odd):
        return is_repeated
    # a machine that stops for a moment slows down before; a lost sample has a full step beside it
    beside = np.maximum(step[n - 1 : -n - 1], step[n + 1 : -n + 1])
    odd &= beside > 0.5 * usual
    # the largest value of a clipped or limited channel is repeated for another reason
    odd &= (x[n : -n - 1] < x.max()) & (x[n : -n - 1] > x.min())
    is_repeated[n + 1 : -n] = odd
    return is_repeated


def step_of(x: FloatArray) -> float:
    """Smallest step of a channel of few values, or of whole counts; 0 for one whose values all differ.

    A long channel is sorted only if values recur among every sixteenth sample, or if those are whole counts apart. In a
    short log of counts, or one of a fast encoder, few values recur, but all of them are whole steps apart.

    >>> counts, fast = (np.round(x * np.sin(np.arange(300) / 40)) for x in (200, 2000))
    >>> step_of(counts), step_of(fast), step_of(fast + 1e-3 * np.random.default_rng(0).standard_normal(300))
    (1.0, 1.0, 0.0)
    """
    some = np.unique(x[::_STRIDE])
    if x.size > _LONG_CHANNEL and some.size == -(-x.size // _STRIDE) and not _whole(np.diff(some)):
        return 0.0
    values = np.unique(x)
    if values.size < 2:
        return 0.0
    gaps = np.diff(values)
    return float(gaps.min()) if values.size < _COARSE_SHARE * x.size or _whole(gaps) else 0.0


def _whole(gaps: FloatArray) -> bool:
    """Whether all gaps between values are whole multiples of the smallest one, with few such steps for each value.

    With few numbers or many steps, gaps are of one size by chance.
    """
    with np.errstate(over="ignore", invalid="ignore"):  # beside the least numbers, gaps count too many
        counts = gaps / gaps.min()
    most = max(_COUNTS, _STEPS_A_VALUE * gaps.size)
    return bool(counts.sum() < most and np.all(np.abs(counts - np.round(counts)) < _ROUNDING * counts))


def restored(
    signals: Mapping[str, FloatArray], smooth: Collection[str]
) -> tuple[dict[str, FloatArray], list[str]]:
    """Signals without samples that were lost and filled with 0, and a note on each.

    Where a recorder lost a sample of a signal far from 0, each row in which all signals are exactly 0, and in the rows
    beside it none is, was lost as a whole. Positions, in `smooth`, are restored by a cubic spline, others by lines.

    >>> q = 1.0 + np.arange(80) / 10
    >>> values, notes = restored({"q": np.where(np.arange(80) % 26 == 5, 0.0, q)}, ["q"])
    >>> bool(np.allclose(values["q"], q)), notes[0][:30]
    (True, "'q' was exactly 0 in 3 samples")
    """
    alone = {name: dropped(x) for name, x in signals.items()}
    rows = _lost_rows(signals)
    if not any(np.any(rows & far) for far in alone.values()):
        rows[:] = False
    values, notes = dict(signals), []
    for name, x in signals.items():
        lost = rows | alone[name] if np.count_nonzero(alone[name]) >= FEWEST_LOST else rows
        if not lost.any() or np.mean(lost) > _MOST_LOST:
            continue
        values[name] = _filled(x, ~lost, smooth=name in smooth)
        number = counted(int(np.count_nonzero(lost)), "sample")
        notes.append(f"{name!r} was exactly 0 in {number} between others: they were lost, and interpolated")
    return values, notes


def without_repeated_rows(
    signals: Mapping[str, FloatArray], smooth: Collection[str]
) -> tuple[dict[str, FloatArray], list[str]]:
    """Signals without rows that were lost and filled with the row before, and a note on them.

    >>> t = np.arange(2000) / 1000
    >>> row = np.arange(2000) - (np.arange(2000) % 97 == 50)
    >>> whole = {"q": np.sin(t), "F": np.cos(5 * t)}
    >>> values, notes = without_repeated_rows({name: x[row] for name, x in whole.items()}, ["q"])
    >>> bool(np.allclose(values["q"], whole["q"])), notes[0][:16]
    (True, '21 rows repeated')
    """
    rows = np.stack([np.diff(x, prepend=np.nan) == 0.0 for x in signals.values()]).all(axis=0)
    odd = np.stack([repeated(x) for x in signals.values()]).any(axis=0) & rows
    least = max(FEWEST_LOST, _LEAST_REPEATED * rows.size)
    if len(signals) < 2 or np.count_nonzero(odd) < least or np.mean(odd) > _MOST_REPEATED:
        return dict(signals), []
    lost = _short(np.asarray(rows))
    values = {name: _filled(x, ~lost, smooth=name in smooth) for name, x in signals.items()}
    count = counted(int(np.count_nonzero(lost)), "row")
    return values, [f"{count} repeated the one before: they were lost, and interpolated"]


def _lost_rows(signals: Mapping[str, FloatArray]) -> BoolArray:
    """Rows of several signals, at most three in a row, in which all are exactly 0 between rows in which none is."""
    zeros = np.stack([x == 0.0 for x in signals.values()])
    if len(zeros) < 2:
        return np.zeros(zeros.shape[1], dtype=np.bool_)
    whole, sound = np.asarray(zeros.all(axis=0)), np.asarray(~zeros.any(axis=0))
    beside = np.concatenate([sound[:1], sound[:-1]]) | whole, np.concatenate([sound[1:], sound[-1:]]) | whole
    return np.asarray(_short(whole) & beside[0] & beside[1])


def _short(lost: BoolArray) -> BoolArray:
    """Places within a log, at most three in a row."""
    short = lost.copy()
    for start, end in runs_of_true(lost):
        short[start:end] = start > 0 and end < lost.size and end - start <= _LONGEST
    return short


def _filled(x: FloatArray, sound: BoolArray, *, smooth: bool) -> FloatArray:
    places = np.arange(x.size)
    if smooth and np.count_nonzero(sound) > _LONGEST:
        between = scipy.interpolate.CubicSpline(places[sound], x[sound])(places)
    else:
        between = np.interp(places, places[sound], x[sound])
    values = np.unique(x[sound])
    if values.size < _COARSE_SHARE * x.size:  # a coarse channel stays one of its steps
        between = values[np.searchsorted((values[1:] + values[:-1]) / 2, between)]
    return np.where(sound, x, between)
