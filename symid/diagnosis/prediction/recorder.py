"""Repair of logs before the diagnosis: lost samples, and channels that are slower than the log.

A channel that is updated only at every n-th sample, or interpolated in between, has no further information. The whole
log is then decimated to that rate, forces by a zero-phase low-pass filter, and each channel keeps its clock.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from symid.arrays import FloatArray
from symid.axis import Axis
from symid.data import Log
from symid.data.quality.lost_samples import restored, without_repeated_rows
from symid.diagnosis.prediction.record import LEAST_SAMPLES
from symid.errors import LogError
from symid.identification.faults.smoothing import interpolated_from, updated_every


@dataclass(frozen=True)
class Repaired:
    """Logs without the faults of their recorder."""

    logs: tuple[Log, ...]  # repaired
    notes: tuple[str, ...]  # the faults
    decimation: int  # recorded samples for each sample that is kept


def repaired(axis: Axis, logs: Sequence[Log]) -> Repaired:
    """Logs of one machine without lost samples, at the rate of their slowest sensor.

    >>> from symid import load_axis
    >>> t = np.arange(4000) / 4000
    >>> slow = {"F": np.sin(20 * t), "q": np.repeat(np.sin(20 * t[::4]), 4)}
    >>> found = repaired(load_axis("rigid_1m"), [Log.from_arrays(slow, sampling_period=2.5e-4)])
    >>> found.logs[0].n_samples, found.notes[0][:36]
    (1000, 'q is updated every 4th sample only: ')
    """
    whole, notes = zip(*(_restored(axis, log) for log in logs), strict=True)
    messages = [note for each in notes for note in each]
    slowest = {sensor.signal: _slowest(whole, sensor.signal) for sensor in axis.sensors}
    n = max((spacing for spacing, _ in slowest.values()), default=1)
    if n == 1:
        return Repaired(whole, tuple(dict.fromkeys(messages)), 1)
    rate = whole[0].sampling_frequency / n
    messages += [
        f"{name} is {how} every {_ordinal(spacing)} sample only: all was thinned to {rate:g} Hz"
        for name, (spacing, how) in slowest.items()
        if spacing > 1
    ]
    shortest = min(whole, key=lambda log: log.n_samples)
    if shortest.n_samples < n * LEAST_SAMPLES:
        left, reason = shortest.n_samples // n, messages[-1].split(":")[0]
        raise LogError(
            f"log {shortest.source!r} has {left} independent samples, as {reason}: a diagnosis needs at least "
            f"{LEAST_SAMPLES}"
        )
    drives = {drive.signal for drive in axis.drives}
    return Repaired(tuple(_decimated(log, n, drives) for log in whole), tuple(dict.fromkeys(messages)), n)


def _ordinal(n: int) -> str:
    return {2: "2nd", 3: "3rd"}.get(n, f"{n}th")


def _restored(axis: Axis, log: Log) -> tuple[Log, list[str]]:
    """A log with lost samples restored, and the faults found."""
    positions = [sensor.signal for sensor in axis.sensors if sensor.derivative == 0]
    names = {drive.signal for drive in axis.drives} | {sensor.signal for sensor in axis.sensors}
    values, zeros = restored({k: x for k, x in log.signals.items() if k in names}, positions)
    repeats = list[str]()
    if all(updated_every(x)[0] == 1 for x in values.values()):
        values, repeats = without_repeated_rows(values, positions)
    notes = [*zeros, *repeats]
    return (replace(log, signals=dict(log.signals) | values), notes) if notes else (log, notes)


def _slowest(logs: Sequence[Log], name: str) -> tuple[int, str]:
    """Largest spacing of the updates of a channel in logs, in samples, and the word for it."""
    found = [(1, "updated")]
    for x in (log[name] for log in logs if name in log.signals):
        found += [(updated_every(x)[0], "updated"), (interpolated_from(x), "measured, and interpolated,")]
    return max(found)


def _decimated(log: Log, n: int, forces: Collection[str]) -> Log:
    """Decimate a log; slow channels are interpolated between their own samples, forces are low-passed first.

    If possible, the samples that are kept are those of a slow channel, so that a coarse reading stays on its steps.
    """
    own = {name: _own_samples(x) for name, x in log.signals.items()}
    begin = next((first for spacing, first in own.values() if spacing > 1 and n % spacing == 0), 0)
    kept = np.arange(begin, log.n_samples, n)
    signals = {}
    for name, x in log.signals.items():
        spacing, first = own[name]
        if spacing > 1 and (name not in forces or spacing >= n):
            places = np.arange(first, x.size, spacing)
            is_own = n % spacing == 0 and begin % spacing == first
            signals[name] = x[kept] if is_own else scipy.interpolate.CubicSpline(places, x[places])(kept)
        elif name in forces:
            signals[name] = scipy.signal.resample_poly(x[begin:], 1, n, padtype="line")[: kept.size]
        else:
            signals[name] = x[kept]
    start, period = log.start + begin * log.sampling_period, n * log.sampling_period
    return replace(log, signals=signals, start=start, sampling_period=period)


def _own_samples(x: FloatArray) -> tuple[int, int]:
    """Spacing of a channel's own samples, and the index of the first."""
    spacing, first = updated_every(x)
    if spacing > 1 or not (between := interpolated_from(x)):
        return spacing, first
    curvature = np.abs(np.diff(x, 2))
    knots = np.mean(curvature[: curvature.size // between * between].reshape(-1, between), axis=0)
    return between, (int(np.argmax(knots)) + 1) % between
