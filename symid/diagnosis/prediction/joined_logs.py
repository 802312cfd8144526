"""Several logs of an axis as one, joined by smooth bridges that belong to no log.

The logs share the values of the axis; hidden states are unknown after each bridge, as after any rest.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from symid.arrays import BoolArray, FloatArray
from symid.data import Log
from symid.errors import LogError

_TRANSITION = 0.5
"""Least duration of a bridge from the end of a log to the beginning of the next, s."""
_FASTER = 6.0
"""Greatest mean speed of a bridge, relative to the greatest speed in the logs: an axis that turns far one way has far
to return, and a faster bridge, limited to the band, would ring in the logs."""
_SPEED_OVER = 0.1
"""Time over which that speed is taken, s: over a sample, noise and steps of encoders would exceed it."""
_OF_A_WAY = 0.05
"""Least part of the travel of a log one way that counts as motion that way: overshoot at the end of a move is less."""
_SAME_CLOCK = 0.01
"""Relative difference of sampling periods up to which logs are taken to have the same clock."""
_ENDS = 8  # samples from which the slope at an end follows


@dataclass(frozen=True, eq=False)
class JoinedLogs:
    """Logs joined to one, with the rows that belong to each."""

    log: Log  # all of them, with smooth bridges in between
    recorded: BoolArray  # shape (n_samples,): samples that belong to a log
    parts: tuple[Log, ...]  # the logs as they were recorded


def joined(logs: Sequence[Log], positions: Sequence[str] = ()) -> JoinedLogs:
    """Join logs by smooth bridges, with the signals that all of them have; `positions` may have far to return.

    >>> one = Log.from_arrays({"q": np.zeros(100)}, sampling_period=0.01)
    >>> both = joined([one, one])
    >>> both.log.n_samples, int(both.recorded.sum())
    (250, 200)
    """
    if not logs:
        raise LogError("no log was given: a diagnosis needs one")
    first = logs[0]
    if len(logs) == 1:
        return JoinedLogs(first, np.ones(first.n_samples, dtype=bool), (first,))
    for log in logs[1:]:
        if abs(log.sampling_period - first.sampling_period) > _SAME_CLOCK * first.sampling_period:
            raise LogError(
                f"log {log.source!r} is sampled every {log.sampling_period:g} s, {first.source!r} every "
                f"{first.sampling_period:g} s: logs that are diagnosed together need one sampling period: "
                "read them with `resample`"
            )
    names = [name for name in first.signals if all(name in log.signals for log in logs)]
    pairs = [(before[name], after[name]) for name in positions for before, after in pairwise(logs)]
    n = bridge_samples(pairs, first.sampling_period, 2 * _ENDS)
    signals = {name: _with_transitions([log[name] for log in logs], n) for name in names}
    inside = [np.ones(log.n_samples, dtype=bool) for log in logs]
    transitions = [np.zeros(n, dtype=bool)] * (len(logs) - 1)
    recorded = np.concatenate(
        [part for pair in zip(inside, [*transitions, transitions[0][:0]], strict=True) for part in pair]
    )
    source = ", ".join(log.source for log in logs)
    return JoinedLogs(Log(source, first.start, first.sampling_period, signals), recorded, tuple(logs))


def ways(log: Log, positions: Sequence[str]) -> set[tuple[str, bool]]:
    """Directions in which positions move, True for the positive one.

    >>> up = Log.from_arrays({"q": np.linspace(0.0, 1.0, 100)}, sampling_period=0.01)
    >>> ways(up, ["q"])
    {('q', True)}
    """
    span = max(1, round(_SPEED_OVER / log.sampling_period))
    steps = {name: np.diff(log[name][::span]) for name in positions}
    return {
        (name, positive)
        for name, moved in steps.items()
        for positive in (True, False)
        if np.abs(moved[(moved > 0.0) == positive]).sum() > _OF_A_WAY * np.abs(moved).sum()
    }


def with_common_zeros(logs: Sequence[Log], driven: Sequence[str], others: Sequence[str]) -> list[Log]:
    """Logs whose further position readings have the zeros of the first log.

    Incremental encoders have other zeros in each log. A further reading is y = r q + z + deflection for the driven
    positions q: r and z follow by least squares, and z is replaced by its value in the first log.
    """
    found = [logs[0]]
    for log in logs[1:]:
        signals = dict(log.signals)
        for name in others:
            zeros = [_zero_reading(each, driven, name) for each in (logs[0], log)]
            signals[name] = log[name] + zeros[0] - zeros[1]
        found.append(replace(log, signals=signals))
    return found


def _zero_reading(log: Log, driven: Sequence[str], name: str) -> float:
    """Reading of a further position where the driven ones read zero."""
    columns = np.stack([*(log[each] for each in driven), np.ones(log.n_samples)], axis=1)
    return float(np.linalg.lstsq(columns, log[name], rcond=None)[0][-1])


def _with_transitions(parts: Sequence[FloatArray], n: int) -> FloatArray:
    found = [parts[0]]
    for before, after in pairwise(parts):
        found += [transition(before, after, n), after]
    return np.concatenate(found)


def transition(before: FloatArray, after: FloatArray, n: int) -> FloatArray:
    """Values that lead smoothly from the end of a signal to the beginning of another, with the slopes of both."""
    m = min(_ENDS, before.size, after.size)
    (v0, x0), (v1, x1) = (
        np.polyfit(k, part, 1) for k, part in ((np.arange(1 - m, 1), before[-m:]), (np.arange(m), after[:m]))
    )
    return bridge((x0, v0), (x1, v1), n)


def bridge_samples(pairs: Sequence[tuple[FloatArray, FloatArray]], period: float, least: int) -> int:
    """Samples of a bridge from the end of each signal of a pair to the beginning of the other one.

    The bridge is at most as long as the longest signal.

    >>> turned = np.arange(1000.0)
    >>> bridge_samples([(turned, turned)], 0.01, 64), bridge_samples([(turned, turned[::-1])], 0.01, 64)
    (166, 64)
    """
    n, span = max(least, int(_TRANSITION / period)), max(_ENDS, round(_SPEED_OVER / period))
    for before, after in pairs:
        fastest = max(float(np.abs(x[span:] - x[:-span]).max(initial=0.0)) / span for x in (before, after))
        far = abs(float(after[0] - before[-1]))
        if far > _FASTER * fastest * n:
            n = min(int(far / (_FASTER * fastest)) if fastest else n, max(before.size, after.size))
    return n


def bridge(left: tuple[float, float], right: tuple[float, float], n: int) -> FloatArray:
    """The n samples of the quintic between two values with slopes per sample, and zero curvature at both ends."""
    (x0, v0), (x1, v1) = left, right
    u = np.arange(1, n + 1) / (n + 1)
    v0, v1, distance = v0 * (n + 1), v1 * (n + 1), x1 - x0
    cubic = 10 * distance - 6 * v0 - 4 * v1
    quartic = -15 * distance + 8 * v0 + 7 * v1
    quintic = 6 * distance - 3 * v0 - 3 * v1
    return np.asarray(x0 + v0 * u + cubic * u**3 + quartic * u**4 + quintic * u**5)
