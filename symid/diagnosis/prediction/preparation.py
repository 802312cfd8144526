"""Preparation of logs for a diagnosis: repaired, in physical units, with positions, and divided by purpose.

A channel that is updated only at every n-th sample, or interpolated in between, has no further information: the whole
log is then decimated to that rate, forces by a zero-phase low-pass filter, and each channel keeps its clock. In a log
of speeds without a position, the integral of the speed takes its place. In motion of one direction, dry friction and a
constant force in the same joint are one force: the constant force becomes known.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from symid.arrays import FloatArray
from symid.axis import Axis, Body, CoulombFriction, OffsetForce, Position, Velocity
from symid.data import Log
from symid.data.quality import restored, without_repeated_rows
from symid.diagnosis.prediction.data import LogsByPurpose, logs_by_purpose
from symid.diagnosis.prediction.record import LEAST_SAMPLES
from symid.diagnosis.prediction.scaled_sensors import with_quantities
from symid.errors import LogError
from symid.identification import Preparation
from symid.identification.faults import interpolated_from, updated_every


@dataclass(frozen=True, eq=False)
class PreparedLogs:
    """Logs that the diagnosis can use, and the axis in terms of their signals."""

    logs: LogsByPurpose
    axis: Axis
    declared: Axis  # with its own sensors, and the parameters that became known
    decimation: int  # recorded samples for each sample of the logs
    faults: tuple[str, ...]  # sentences on repaired faults of the recorder
    notes: tuple[str, ...]  # sentences on the conversions


def prepared(
    axis: Axis,
    logs: Sequence[Log],
    n_validation: int | None,
    nominal: Mapping[str, float] | None,
    preparation: Preparation,
) -> PreparedLogs:
    """Prepare logs, of which the last `n_validation` validate; by default the last of several."""
    whole = repaired(axis, logs)
    plain = with_quantities(axis, whole.logs, nominal, preparation)
    moving, every, notes = with_positions(plain.axis, plain.logs)
    constants, indistinct = indistinct_constant_forces(moving, every, nominal)
    moving = moving.with_known(constants)
    return PreparedLogs(
        logs_by_purpose(moving, every, n_validation),
        moving,
        plain.declared.with_known(constants),
        whole.decimation,
        whole.notes,
        (*plain.notes, *notes, *indistinct),
    )


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


def with_positions(axis: Axis, logs: Sequence[Log]) -> tuple[Axis, list[Log], tuple[str, ...]]:
    """The axis and its logs with positions in place of speeds, if the logs hold no position; and notes on that.

    The integral of a speed keeps the name of the signal. Logs with a position, or without a speed, stay as they are.

    >>> from symid import Body, Drive, Velocity
    >>> motor = Body("motor", inertia="J")
    >>> axis = Axis("fan", (motor,), Drive("T", motor), (Velocity("w", motor),))
    >>> log = Log.from_arrays({"w": np.full(50, 3.0), "T": np.ones(50)}, sampling_period=0.1)
    >>> moved, logs, notes = with_positions(axis, [log])
    >>> type(moved.sensors[0]).__name__, round(float(logs[0]["w"][-1]), 9), notes[0]
    ('Position', 14.7, 'No position was logged: that of w is its integral from 0 on.')
    """
    held = set.intersection(*(set(log.signals) for log in logs))
    of_order = [
        [sensor.signal for sensor in axis.sensors if sensor.derivative == order and sensor.signal in held]
        for order in (0, 1)
    ]
    if of_order[0] or not of_order[1]:
        return axis, list(logs), ()
    speeds = of_order[1]
    sensors = tuple(
        Position(s.signal, s.body, s.relative_to, delay=s.delay)
        if isinstance(s, Velocity) and s.signal in speeds
        else s
        for s in axis.sensors
    )
    moved = [
        replace(log, signals={**log.signals, **{name: _integral(log, name) for name in speeds}})
        for log in logs
    ]
    note = f"No position was logged: that of {', '.join(speeds)} is its integral from 0 on."
    return replace(axis, sensors=sensors), moved, (note,)


def _integral(log: Log, name: str) -> FloatArray:
    """Integral of a speed from 0 on, by its spectrum beside the line from its first to its last sample.

    The trapezoidal rule would take 32 % off at 0.3 of the sampling frequency, and hide the noise beyond, which shows
    where the motion ends.
    """
    v, time = log[name], log.time - log.time[0]
    slope = (v[-1] - v[0]) / time[-1]
    rest = v - v[0] - slope * time
    spectrum, omega = scipy.fft.rfft(rest), 2 * np.pi * scipy.fft.rfftfreq(v.size, log.sampling_period)
    spectrum[1:] /= 1j * omega[1:]
    mean, spectrum[0] = float(rest.mean()), 0.0
    course = (v[0] + mean) * time + slope * time**2 / 2 + scipy.fft.irfft(spectrum, v.size)
    return np.asarray(course - course[0])


_BACK = 0.002
"""Largest way back, relative to the stroke, of a motion in one direction: encoders and rests show some."""


def indistinct_constant_forces(
    axis: Axis, logs: Sequence[Log], nominal: Mapping[str, float] | None
) -> tuple[dict[str, float], tuple[str, ...]]:
    """Constant forces that logs do not distinguish from dry friction, with the values to take, and notes.

    If both were free, they would grow without bound with opposite signs. The constant force is given its nominal value,
    or 0.

    >>> from symid import Drive, Position
    >>> table = Body("table", mass="M")
    >>> laws = (CoulombFriction(table, "Fc"), OffsetForce(table, "OF"))
    >>> axis = Axis("slide", (table, *laws), Drive("F", table), (Position("q", table),))
    >>> log = Log.from_arrays({"q": np.arange(50.0) ** 2, "F": np.ones(50)}, sampling_period=0.1)
    >>> indistinct_constant_forces(axis, [log], {"OF": 3.0})
    ({'OF': 3.0}, ('q goes one way only, in which OF and Fc are one force: OF is taken as 3 N.',))
    """
    known, notes = dict[str, float](), list[str]()
    free = axis.physical_parameters
    for sensor in axis.sensors:
        if not isinstance(sensor, Position) or sensor.relative_to is not None:
            continue
        if not _is_one_way(logs, sensor.signal):
            continue
        dry, constant = (
            [
                term.parameter
                for law in axis.laws
                if isinstance(law, kind) and isinstance(law.at, Body) and law.at == sensor.body
                for term in law.terms()
                if term.parameter in free
            ]
            for kind in (CoulombFriction, OffsetForce)
        )
        for name in constant if dry else ():
            known[name] = float((nominal or {}).get(name, 0.0))
            notes.append(
                f"{sensor.signal} goes one way only, in which {name} and {dry[0]} are one force: {name} is taken as "
                f"{known[name]:.4g} {free[name]}."
            )
    return known, tuple(notes)


def _is_one_way(logs: Sequence[Log], name: str) -> bool:
    """Whether a position never goes back, in all logs alike."""

    def way_back(q: FloatArray) -> float:
        return float(np.max(np.maximum.accumulate(q) - q))

    return all(name in log.signals for log in logs) and any(
        all(way_back(sign * log[name]) < _BACK * np.ptp(log[name]) for log in logs) for sign in (1.0, -1.0)
    )
