"""Resampling of signals with jitter, missing samples or different clocks."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

import numpy as np
import scipy

from symid.arrays import FloatArray
from symid.data.columns import TIME
from symid.data.quality.clock import MINIMUM_SAMPLES
from symid.errors import LogError
from symid.text import moment

Rate: TypeAlias = 'float | Literal["own"]'
"""Sampling frequency, Hz, or "own": the mean rate of the log where no sample is missing."""

_LONGEST_GAP: Final = 10
"""Samples in a row that may be missing: beyond them the motion between is unknown."""
_LONGEST_STEP: Final = 1.75
"""Longest interval without a missing sample, in multiples of the median interval."""
_ANTI_ALIASED_FROM: Final = 1.02
"""Ratio of the new to the old period above which an anti-aliasing filter is needed."""
_HIGHEST_RATE: Final = 1.25
"""Highest new rate, in multiples of the highest rate of the signals."""
_CUTOFF_SHARE: Final = 0.8
"""Cutoff of the anti-aliasing filter (order 8, forward and backward) over the new Nyquist frequency."""
_MOST_REPEATED: Final = 0.01
"""Share of samples with the time of the one before that are left out: more are no repeated rows but a coarse clock."""
_EVEN: Final = 1e-3
"""Deviation of times from even ones, in periods, below which they are taken for these."""
_MOST_SAMPLES: Final = 10**9  # on the common clock


def resampled(
    values: Mapping[str, FloatArray], clocks: Mapping[str, FloatArray], rate: Rate
) -> tuple[dict[str, FloatArray], tuple[str, ...]]:
    """Signals, and the time as ``t``, on one uniform clock by cubic splines through their samples; and notes.

    `rate` is in Hz, or "own": the highest mean rate of a signal. Where the new rate is lower,
    a zero-phase Butterworth filter removes what it cannot represent. Up to ten samples in a row that are missing (nan)
    are filled; a longer gap is an error. The signals keep the span in which all of them were recorded.

    >>> t = np.arange(400) / 400 + 5e-4 * np.random.default_rng(0).uniform(-1, 1, 400)
    >>> found, notes = resampled({"q": np.sin(5 * t)}, {"q": t}, 400.0)
    >>> float(np.max(np.abs(found["q"] - np.sin(5 * found["t"])))) < 1e-6, notes[0]
    (True, 'resampled to 400 Hz by cubic splines')
    """
    if not values:
        raise LogError("has no signal to resample: name its columns")
    written = {name: _Written.of(name, clocks[name], x) for name, x in values.items()}
    finest = min(signal.period for signal in written.values())
    period = finest if rate == "own" else 1.0 / rate
    begin = max(signal.start for signal in written.values())
    end = min(signal.start + signal.time[-1] for signal in written.values())
    if rate == "own":
        begin += _phase(list(written.values()), begin, finest)
    count = (end - begin) / period
    if not MINIMUM_SAMPLES <= count < _MOST_SAMPLES:
        raise LogError(
            f"has {max(count, 0):.6g} samples at {1 / period:.6g} Hz in the span that all signals share: "
            f"between {MINIMUM_SAMPLES} and {_MOST_SAMPLES:g} are required"
        )
    if period * _HIGHEST_RATE < finest:
        raise LogError(
            f"cannot be resampled to {1 / period:.6g} Hz, above the {1 / finest:.6g} Hz of its fastest signal: "
            "interpolated samples would count as readings without noise; give `resample=own` or a lower rate"
        )
    time: FloatArray = period * np.arange(float(math.floor(count + _EVEN) + 1))
    done = f"resampled to {1 / period:.6g} Hz by cubic splines"
    if any(signal.is_slower(period) for signal in written.values()):
        done += f" after a zero-phase low-pass at {_CUTOFF_SHARE / (2 * period):.6g} Hz"
    notes = dict.fromkeys([done, *(note for signal in written.values() for note in signal.notes)])
    signals = {name: signal.at(begin - signal.start + time, period) for name, signal in written.items()}
    return {TIME: begin + time, **signals}, tuple(notes)


def _phase(written: Sequence[_Written], begin: float, period: float) -> float:
    """Offset from `begin` of the instants at which most of the fastest signals are sampled, so that they stay."""
    fastest = [signal for signal in written if not period * _ANTI_ALIASED_FROM < signal.period]
    sizes = [(signal.start, signal.time.size) for signal in fastest]
    most = fastest[sizes.index(max(sizes, key=sizes.count))]
    turns = np.angle(np.mean(np.exp(2j * np.pi * (most.start - begin + most.time) / period))) / (2 * np.pi)
    return float(turns if turns > -_EVEN else turns + 1.0) * period


def known_samples(time: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray, int]:
    """Times and values of the samples that have both, without a few that repeat a time, and the number of these."""
    size = min(time.size, values.size)
    there = np.isfinite(time[:size]) & np.isfinite(values[:size])
    t, x = time[:size][there], values[:size][there]
    repeats = np.diff(t, prepend=-np.inf) == 0
    n_repeats = int(np.count_nonzero(repeats))
    if n_repeats > _MOST_REPEATED * t.size:
        return t, x, 0
    return t[~repeats], x[~repeats], n_repeats


@dataclass(frozen=True)
class _Written:
    """A signal with its sampling times, counted from the first one, its usual period, and notes on its clock."""

    start: float
    time: FloatArray
    values: FloatArray
    period: float
    notes: tuple[str, ...]

    @classmethod
    def of(cls, name: str, time: FloatArray, values: FloatArray) -> _Written:
        """The samples that are there, checked; LogError for a gap that nothing can fill."""
        t, x, repeated = known_samples(time, values)
        steps = np.diff(t)
        if t.size < MINIMUM_SAMPLES:
            raise LogError(
                f"{name!r} has {t.size} samples with a time: at least {MINIMUM_SAMPLES} are required"
            )
        if not (steps > 0).all():
            first = int(np.flatnonzero(steps <= 0)[0])
            raise LogError(
                f"t goes back or stops at t = {moment(t[first])} s (sample {first + 2} of {name!r}): "
                "sort the rows, or split the log there"
            )
        # The mean, not the median: written in whole milliseconds, intervals of 7/3 ms are mostly 2 ms.
        period = float(np.mean(steps[steps <= _LONGEST_STEP * np.median(steps)]))
        lost = np.rint(steps / period).astype(np.int64) - 1
        gaps, notes = np.flatnonzero(lost > 0), []
        if repeated:
            notes.append(f"{repeated} samples with the time of the one before were left out")
        if lost.max() > _LONGEST_GAP:
            place = int(np.argmax(lost))
            raise LogError(
                f"{name!r} has {lost[place]} missing samples after t = {moment(t[place])} s: "
                f"at most {_LONGEST_GAP} in a row are filled, split the log there"
            )
        if gaps.size:
            listed = ", ".join(f"{moment(t[place], 6)} s" for place in gaps[:5]) + ", ..." * (gaps.size > 5)
            notes.append(f"{int(lost[gaps].sum())} missing samples were filled, after t = {listed}")
        jitter = float(np.sqrt(np.mean(np.square(np.where(lost == 0, steps / period - 1, 0.0)))))
        if jitter > _EVEN:
            notes.append(f"t jittered by {100 * jitter:.2g} % of the period of {period:.6g} s (rms)")
        count = np.concatenate([[0], np.cumsum(lost + 1)])
        elapsed = t - t[0]
        line = np.polynomial.Polynomial.fit(count, elapsed, 1)
        if np.max(np.abs(line(count) - elapsed)) < _EVEN * period:  # rounding, as of seconds from 1970
            elapsed, period = line(count), float(line.convert().coef[1])
        return cls(float(t[0]), elapsed, x, period, tuple(notes))

    def is_slower(self, period: float) -> bool:
        """Whether a sampling period is so much longer that a low-pass filter is needed first."""
        return period > _ANTI_ALIASED_FROM * self.period

    def at(self, time: FloatArray, period: float) -> FloatArray:
        """Values at other times from its start, without the frequencies that their rate cannot represent."""
        if not self.is_slower(period):
            return np.asarray(scipy.interpolate.CubicSpline(self.time, self.values)(time))
        grid = np.arange(self.time[0], self.time[-1], self.period)
        even = scipy.interpolate.CubicSpline(self.time, self.values)(grid)
        low_pass = scipy.signal.butter(8, _CUTOFF_SHARE * self.period / period, output="sos")
        smooth = scipy.signal.sosfiltfilt(low_pass, even)
        return np.asarray(scipy.interpolate.CubicSpline(grid, smooth)(time))
