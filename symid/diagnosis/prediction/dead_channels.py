"""Channels that never change are refused, as they are where a file is read."""

from __future__ import annotations

from collections.abc import Sequence

from symid.axis import Axis
from symid.data import Log
from symid.data.checks import said_range
from symid.errors import LogError


def require_live_channels(axis: Axis, logs: Sequence[Log]) -> None:
    """Raise LogError if the drive or a sensor of an axis never changes in a log.

    Examples
    --------
    >>> import numpy as np
    >>> from symid import load_axis
    >>> log = Log.from_arrays({"F": np.cos(np.arange(100.0)), "q": np.zeros(100)}, sampling_period=0.01)
    >>> try:
    ...     require_live_channels(load_axis("rigid_1m"), [log])
    ... except LogError as error:
    ...     print(str(error)[:55])
    log 'arrays': 'q' is constant (0) over the whole log: c
    """
    for log in logs:
        for name in (*(drive.signal for drive in axis.drives), *(sensor.signal for sensor in axis.sensors)):
            x = log.signals.get(name)
            if x is not None and x.size and (fault := said_range(name, float(x.min()), float(x.max()))):
                raise LogError(f"log {log.source!r}: {fault}")
