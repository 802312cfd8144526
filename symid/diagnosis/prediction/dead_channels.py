"""Channels that never change: without force or position nothing can be diagnosed, other sensors are left out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symid.axis import Axis
from symid.data import Log
from symid.errors import LogError


def without_dead_channels(axis: Axis, logs: Sequence[Log]) -> tuple[list[Log], tuple[str, ...]]:
    """Logs without the sensors that never change in one of them, and a sentence for each of these.

    Parameters
    ----------
    axis : Axis
        With its drive and sensors.
    logs : sequence of Log
        Logs for identification and for validation.

    Raises
    ------
    LogError
        If the force, or every position, never changes.

    Examples
    --------
    >>> from symid import load_axis
    >>> axis, t = load_axis("ballscrew_2m1s"), np.arange(100) / 100
    >>> log = Log.from_arrays({"Fm": np.cos(t), "qm": np.sin(t), "ql": np.zeros(100)}, sampling_period=0.01)
    >>> (kept,), notes = without_dead_channels(axis, [log])
    >>> sorted(kept.signals), notes
    (['Fm', 'qm'], ("ql never changes in log 'arrays': it is left out.",))
    """
    force = axis.only_drive.signal
    dead: dict[str, str] = {}
    for log in logs:
        for name in (force, *(sensor.signal for sensor in axis.sensors)):
            if name in log.signals and log.n_samples and np.ptp(log[name]) == 0.0:
                dead.setdefault(name, log.source)
    positions = [sensor.signal for sensor in axis.sensors if sensor.derivative == 0]
    present = [name for name in positions if all(name in log.signals for log in logs)]
    needed = [force] if force in dead else present if present and set(present) <= dead.keys() else []
    for name in needed:
        raise LogError(
            f"log {dead[name]!r}: {name} never changes, so that the motion says nothing of the axis; take a log "
            "in which the axis moves under its drive"
        )
    kept = [replace(log, signals={n: x for n, x in log.signals.items() if n not in dead}) for log in logs]
    return kept, tuple(
        f"{name} never changes in log {source!r}: it is left out." for name, source in dead.items()
    )
