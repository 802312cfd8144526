"""Position and velocity of an axis over a log."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from symid.arrays import FloatArray
from symid.axis import Axis
from symid.data.log import Log

_SMOOTHED_HZ = 50.0


@dataclass(frozen=True, eq=False)
class SensorMotion:
    """Position and velocity of the first position sensor, SI; the velocity is smoothed below 50 Hz."""

    signal: str
    unit: str
    time: FloatArray
    position: FloatArray
    velocity: FloatArray

    @classmethod
    def of(cls, axis: Axis, log: Log) -> SensorMotion | None:
        """Motion in a log; None without a position."""
        signals = [s.signal for s in axis.sensors if s.derivative == 0 and s.signal in log.signals]
        if not signals:
            return None
        position, period = np.asarray(log[signals[0]]), log.sampling_period
        velocity = np.gradient(position, period)
        if 0.4 / period > _SMOOTHED_HZ and position.size > 100:
            sections = scipy.signal.butter(2, _SMOOTHED_HZ, fs=1 / period, output="sos")
            velocity = scipy.signal.sosfiltfilt(sections, velocity)
        return cls(signals[0], str(axis.signal_units[signals[0]]), log.time, position, velocity)

    def at(self, time: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Position and velocity at other times."""
        return np.interp(time, self.time, self.position), np.interp(time, self.time, self.velocity)
