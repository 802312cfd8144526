"""Logs of a speed without a position: the integral of the speed takes its place, with an arbitrary zero."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import scipy

from symid.arrays import FloatArray
from symid.axis import Axis, Position, Velocity
from symid.data import Log


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
