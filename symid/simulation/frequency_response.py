"""The frequency response of an axis, identified and measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from symid.arrays import BoolArray, ComplexArray, FloatArray
from symid.axis import Axis, length_unit
from symid.data import Log
from symid.simulation.forward_dynamics import plant_of
from symid.simulation.plant import Plant
from symid.units import Unit

COHERENT = 0.6
"""Least coherence of a shown point."""
_AVERAGES, _LONGEST = 8, 2**14
"""Least number of averaged segments of a log, and most samples of a segment."""
_FEWEST, _MOST = 16, 0.8
"""Least number of coherent points in a measured response, and their least share of the points below its end."""
_TOP = 0.4
"""Highest frequency of a shown response, relative to the sampling frequency."""


@dataclass(frozen=True, eq=False)
class FrequencyResponse:
    """A frequency response from the drive force to a reading."""

    # force, signal, quantity, unit: the drive, the sensor, the quantity compared (velocity or acceleration) and
    # the unit of the response
    force: str
    signal: str
    quantity: str
    unit: str
    frequency: FloatArray  # shape (n,): Hz
    measured: ComplexArray  # shape (n,): H1 = S_uy / S_uu of the logs
    # shape (n,): abs(S_uy)^2 / (S_uu S_yy): 1 where the reading follows from the force alone
    coherence: FloatArray
    identified: ComplexArray  # shape (n,): of the identified axis without its nonlinear laws

    @property
    def order(self) -> int:
        """Derivative of the displacement that is compared: 1 for a velocity, 2 for an acceleration."""
        return 1 if self.quantity == "velocity" else 2

    @property
    def is_coherent(self) -> BoolArray:
        """Frequencies at which the reading follows from the force."""
        return np.asarray(self.coherence >= COHERENT)

    @property
    def top_hz(self) -> float:
        """Highest frequency below which most points are coherent; 0 where the log hardly excites the axis."""
        coherent = self.is_coherent
        most = np.flatnonzero(np.cumsum(coherent) >= _MOST * np.arange(1, coherent.size + 1))
        if most.size == 0 or coherent[: most[-1] + 1].sum() < _FEWEST:
            return 0.0
        return float(self.frequency[most[-1]])


def response_of(
    axis: Axis,
    values: Mapping[str, float],
    signal: str,
    logs: Sequence[Log],
    late: Mapping[str, float] | None = None,
) -> FrequencyResponse:
    """Measured and identified response of a sensor, averaged over logs of the same sampling period.

    Velocity per force for a sensor of position or velocity, acceleration per force for an accelerometer. A position is
    differentiated by central differences, whose known attenuation is corrected. Under feedback H1 is biased where the
    coherence is low. `values` are the physical parameters, SI; `late` are the delays of the recorded signals, s.
    """
    (sensor,) = axis.measured((signal,))
    moves = sensor.derivative in (0, 1)
    period, second = logs[0].sampling_period, Unit.of("s")
    force = axis.only_drive.signal
    same = [log for log in logs if log.sampling_period == period]
    length = 2 ** int(np.log2(2 * min(log.n_samples for log in same) / (_AVERAGES + 1)))
    length = min(length, _LONGEST)
    settings = {"fs": 1 / period, "nperseg": length, "detrend": "linear"}
    frequency: FloatArray = np.fft.rfftfreq(length, period).astype(np.float64)
    uu, yy, uy = np.zeros(frequency.size), np.zeros(frequency.size), np.zeros(frequency.size, complex)
    for log in same:
        u, y = np.asarray(log[force]), np.asarray(log[signal])
        y = np.gradient(y, period) if sensor.derivative == 0 else y
        uu = uu + scipy.signal.welch(u, **settings)[1]
        yy = yy + scipy.signal.welch(y, **settings)[1]
        uy = uy + scipy.signal.csd(u, y, **settings)[1]
    kept = (frequency > 0) & (frequency <= _TOP / period)
    frequency, uu, uy, yy = frequency[kept], uu[kept], uy[kept], yy[kept]
    # The central difference of a position attenuates by sinc(2 f T); delays of the records turn the phase.
    attenuation = np.sinc(2 * frequency * period) if sensor.derivative == 0 else np.ones(frequency.size)
    delay = (late or {}).get(signal, 0.0) - (late or {}).get(force, 0.0)
    in_time = np.exp(2j * np.pi * frequency * delay)
    return FrequencyResponse(
        force=force,
        signal=signal,
        quantity="velocity" if moves else "acceleration",
        unit=f"{length_unit(sensor.joint) / second ** (1 if moves else 2)} per {axis.signal_units[force]}",
        frequency=frequency,
        measured=np.asarray(uy / uu / attenuation * in_time),
        coherence=np.abs(uy) ** 2 / (uu * yy),
        identified=identified_response(axis, values, signal, frequency, 1 if moves else 2),
    )


def has_response(axis: Axis, values: Mapping[str, float]) -> bool:
    """Whether the frequency response can be computed: all values are finite and all masses positive."""
    values = axis.with_known_values(values)
    masses = [values.get(b.inertial, 0.0) for b in axis.bodies]
    return bool(values) and bool(np.isfinite(list(values.values())).all()) and min(masses) > 0


def degrees_of(response: ComplexArray) -> FloatArray:
    """Phase in degrees; nan where it jumps by a full turn, which breaks a plotted line there.

    >>> degrees_of(np.array([1j, -1.0 + 0.1j, -1.0 - 0.1j])).round().tolist()
    [90.0, 174.0, nan]
    """
    phase = np.rad2deg(np.angle(response))
    turns = np.abs(np.diff(phase, prepend=phase[:1])) > 180
    return np.where(turns, np.nan, phase)


def identified_response(
    axis: Axis, values: Mapping[str, float], signal: str, frequency: FloatArray, order: int
) -> ComplexArray:
    """Response of a derivative of a sensor's displacement to the drive force, r s^k (M s^2 + C s + K)^-1 B.

    >>> from symid.axis import load_axis
    >>> values = {"M": 2.0, "Fv": 0.0, "Fs": 1.0}
    >>> abs(identified_response(load_axis("rigid_1m"), values, "q", np.array([1 / (2 * np.pi)]), 1)).tolist()
    [0.5]
    """
    return plant_response(plant_of(axis, values), signal, frequency, order)


def plant_response(plant: Plant, signal: str, frequency: FloatArray, order: int) -> ComplexArray:
    """Response of a plant with one drive, as `identified_response`."""
    s = 2j * np.pi * frequency[:, None, None]
    matrix = plant.mass * s**2 + plant.damping * s + plant.stiffness
    motion = np.linalg.solve(matrix, np.broadcast_to(plant.drive[:, None], (len(s), plant.drive.size, 1)))
    response = plant.sensors[signal].row @ motion[..., 0].T * s[:, 0, 0] ** order
    return np.asarray(response)
