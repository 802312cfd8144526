"""Channels that were interpolated or averaged before they were recorded: noise near Nyquist is not the sensor's.

Both leave a trace in differences of neighbouring samples. Between the samples of a linear interpolation every second
difference is zero. A mean over n samples has the first difference (x[k] - x[k - n]) / n, so that fast signals such
as noise recur n samples later with the opposite sign.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from symid.arrays import FloatArray, fast_length
from symid.codegen import GeneratedModel
from symid.data import AnyLog, Log
from symid.identification.criteria import CRITERIA
from symid.identification.rows.excerpts import Excerpt

SPACINGS = range(2, 17)
"""Update intervals of a slower channel, in samples, that are searched."""
_REPEATED = 0.4
"""Share of samples that repeat the last value: of every second one updated, half do, less where the machine rests."""
_IN_STEP = 0.98
"""Least share of changes at the same one of n samples; changes of an encoder follow the motion instead."""
_SUCCESSIVE = 0.02
"""Least share of changes n samples after the last one; steps that are held for multiples of n have none."""
_FEWEST_CHANGES = 100
"""Fewest changes of a channel that determine its update interval."""
_FEWEST_JUMPS, _LEAST_JUMP = 20, 2.0
"""Fewest changes if most are at least `_LEAST_JUMP` times the smallest: an encoder shows the motion between them."""
_STRAIGHT = 0.01
"""Second difference between knots, over the median one at the knots of an interpolation, that counts as straight."""
_LEAST_STRAIGHT = 0.4
"""Least share of such small second differences in an interpolated signal; 0.45 with every second sample."""
_DIFFERENCES = (6, 10)
"""Orders of the differences: lower ones leave more motion than noise in a force, higher ones are for fine encoders."""
_CLIPPED_AT = 3.0
"""Multiple of the median difference at which larger differences are clipped."""
_SEARCHED = 16_384
"""Samples in the middle of a signal that are searched for averaging."""
_SHORTEST_MEAN, _LONGEST_MEAN = 8, 600
"""Lengths of means that are searched: alternating noise near Nyquist resembles a shorter mean."""
_ECHO = -0.3
"""Autocorrelation of the differences below which there is an echo; -0.5 without any motion."""
_OTHER_CORRELATION = 0.25
"""Correlation at any other lag, over that of the echo, that is allowed: a periodic disturbance has many echoes."""


def smoothing_of(model: GeneratedModel, parts: Sequence[Excerpt]) -> str:
    """Statement on a channel that was interpolated, or averaged unlike the others; empty without one."""
    for part in parts:
        signals = {name: part.log[name] for name in model.highest_derivatives}
        for name, x in signals.items():
            if spacing := interpolated_from(x):
                return slow_update(x, name) or (
                    f"{name} runs along straight lines of {spacing} samples each: it was interpolated, so its "
                    f"noise cannot be estimated; record it at the rate of the log, or thin the log by {spacing}"
                )
        cutoff = part.observation.preparation.cutoff_hz
        assert cutoff is not None
        if uneven := uneven_averaging(signals, cutoff * part.log.sampling_period, "cutoff"):
            return uneven
    return ""


def uneven_averaging(
    signals: Mapping[str, FloatArray], cycles: float, edge: str, least: float = CRITERIA.averaged
) -> str:
    """Statement on a signal that was averaged unlike the others; empty without one.

    `cycles` is the frequency up to which the signals are used, in cycles per sample, `edge` its name, and `least` the
    loss of amplitude there that counts.

    >>> x = np.random.default_rng(0).standard_normal(4000)
    >>> mean = np.convolve(x, np.full(21, 1 / 21), mode="same")
    >>> uneven_averaging({"F": mean, "q": x}, 0.02, "cutoff")[:63]
    'F is a mean over 21 samples, which takes 27 % at the cutoff, an'
    >>> uneven_averaging({"F": mean, "q": mean}, 0.02, "cutoff")
    ''
    """
    averaged = {name: averaged_over(x) for name, x in signals.items()}
    lost = {name: 1.0 - float(np.sinc(n * cycles)) for name, n in averaged.items()}
    name = max(lost, key=lost.__getitem__)
    if lost[name] - min(lost.values()) <= least:
        return ""
    return (
        f"{name} is a mean over {averaged[name]} samples, which takes {100 * lost[name]:.0f} % at the {edge}, "
        "and not of all signals: record it raw, or average all alike"
    )


def updated_every(x: FloatArray) -> tuple[int, int]:
    """Samples from one update of a channel to the next, and the place of the first; 1 and 0 if each sample is one.

    >>> x = np.random.default_rng(0).standard_normal(500)
    >>> updated_every(np.repeat(x, 4)[1:]), updated_every(x)
    ((4, 3), (1, 0))
    >>> updated_every(np.repeat(np.sign(x), 50))  # steps that last 50 samples are no channel updated every tenth
    (1, 0)
    """
    steps = np.abs(np.diff(x))
    changes = np.flatnonzero(steps) + 1
    if not _FEWEST_JUMPS <= changes.size <= (1.0 - _REPEATED) * x.size:
        return 1, 0
    sizes = steps[changes - 1]
    if changes.size < _FEWEST_CHANGES and float(np.median(sizes)) < _LEAST_JUMP * float(sizes.min()):
        return 1, 0
    for n in reversed(SPACINGS):
        places = np.bincount(changes % n, minlength=n)
        first = int(np.argmax(places))
        if places[first] >= _IN_STEP * changes.size and np.mean(np.diff(changes) == n) > _SUCCESSIVE:
            return n, first
    return 1, 0


def slow_update(x: FloatArray, name: str) -> str:
    """Statement on a channel that is updated more rarely than it is recorded; a force may really be held so."""
    every, _ = updated_every(x)
    cure = f"record it at the rate of the log, or thin the log by {every}"
    return (
        f"{name} changes every {every} samples only: it is updated more rarely than it is recorded; {cure}"
        if every > 1
        else ""
    )


def slowly_updated(model: GeneratedModel, logs: Sequence[AnyLog]) -> str:
    """`slow_update` of the first channel of logs in memory that is one; empty without one."""
    channels = (
        (log[name], name) for log in logs if isinstance(log, Log) for name in model.highest_derivatives
    )
    return next((said for x, name in channels if (said := slow_update(x, name))), "")


def interpolated_from(x: FloatArray) -> int:
    """Spacing of the samples between which a signal was interpolated linearly; 0 if it was not.

    >>> x = np.random.default_rng(0).standard_normal(1000)
    >>> interpolated_from(np.interp(np.arange(4000) / 4, np.arange(1000), x)), interpolated_from(x)
    (4, 0)
    >>> interpolated_from(np.repeat(np.sign(x[:60]), 16))
    0
    """
    step = np.diff(x)
    curvature = np.abs(np.diff(step))
    # a held value, at rest or between two steps, is not a line
    slopes = (step[1:] != 0.0) | (step[:-1] != 0.0)
    straight = slopes & (curvature < _STRAIGHT * np.max(curvature, initial=0.0))
    if np.count_nonzero(straight) <= _LEAST_STRAIGHT * np.count_nonzero(slopes):
        return 0
    for n in SPACINGS:
        if curvature.size < 10 * n:
            break
        phases = curvature[: curvature.size // n * n].reshape(-1, n)
        knots = np.median(phases, axis=0)
        k = int(np.argmax(knots))
        if np.quantile(np.delete(phases, k, axis=1), 0.9) < _STRAIGHT * knots[k]:
            return n
    return _only_bent_every(curvature)


def _only_bent_every(curvature: FloatArray) -> int:
    """Largest spacing of the second differences of a signal that are not 0; 0 if it has such ones anywhere.

    An interpolated coarse reading of slow motion is straight at most of its knots, too.
    """
    for n in reversed(SPACINGS):
        bends = curvature[: curvature.size // n * n].reshape(-1, n)
        means = bends.mean(axis=0)
        k = int(np.argmax(means))
        if (
            np.count_nonzero(bends[:, k]) > _FEWEST_CHANGES
            and np.delete(means, k).max() < _STRAIGHT * means[k]
        ):
            return n
    return 0


def averaged_over(x: FloatArray) -> int:
    """Samples over which a signal was averaged; 0 if that cannot be seen.

    >>> x = np.random.default_rng(0).standard_normal(4000)
    >>> averaged_over(np.convolve(x, np.full(21, 1 / 21), mode="valid")), averaged_over(x)
    (21, 0)
    >>> motion = 1e4 * np.sin(0.08 * np.arange(6000))  # beside which noise shows in high differences only
    >>> x = motion + 1e-3 * np.random.default_rng(0).standard_normal(6000)
    >>> averaged_over(np.convolve(x, np.full(51, 1 / 51), mode="valid")), averaged_over(x)
    (51, 0)
    """
    first = max(0, (x.size - _SEARCHED) // 2)
    z, order = x[first : first + _SEARCHED], 0
    for higher in _DIFFERENCES:
        z, order = np.diff(z, higher - order), higher
        if n := _echo(z, order):
            return n
    return 0


def _echo(z: FloatArray, order: int) -> int:
    """Samples after which differences of some order recur with the opposite sign; 0 without such an echo."""
    usual = _CLIPPED_AT * float(np.median(np.abs(z)))
    z = np.clip(z, -usual, usual)  # a force that is switched on and off comes back too
    n_lags = min(_LONGEST_MEAN + _SHORTEST_MEAN + 1, z.size // 4)
    size = fast_length(z.size + n_lags)
    spectrum = np.fft.rfft(z, size)  # autocorrelation, from the power spectrum
    lags = np.fft.irfft(spectrum.real**2 + spectrum.imag**2, size)[:n_lags]
    if lags.size < 3 * _SHORTEST_MEAN or not lags[0] > 0.0:
        return 0
    lags /= lags[0]
    n = _SHORTEST_MEAN + int(np.argmin(lags[_SHORTEST_MEAN:-_SHORTEST_MEAN]))
    others = np.abs(lags[order + 1 :])
    others[max(n - 2 * order - 1, 0) : n] = 0.0  # the echo and its neighbours
    is_echo = lags[n] < _ECHO and min(lags[n - 1], lags[n + 1]) > 0.5 * abs(lags[n])
    return n if is_echo and lags[1] < 0.0 and np.max(others) < _OTHER_CORRELATION * abs(lags[n]) else 0
