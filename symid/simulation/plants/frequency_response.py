"""The frequency response of an axis, identified and measured, and its band for uncertain parameters."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from symid.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from symid.axis import Axis, length_unit
from symid.data import Log
from symid.estimation import correlation_matrix
from symid.simulation.plants.forward_dynamics import forward_dynamics, plant_of
from symid.simulation.plants.plant import Plant
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


_DRAWS, _SEED = 200, 0
_MOST_PLACES = 300
_WIDEST = 5.0
"""Largest relative deviation of a drawn parameter: an undetermined one varies over decades."""
_SIDES = (0.025, 0.975)  # quantiles of a 95 % interval


@dataclass(frozen=True, eq=False)
class ResponseBand:
    """Band of 95 % of a frequency response, each array of shape (n,)."""

    frequency: FloatArray  # Hz
    # lowest, highest: magnitude
    lowest: FloatArray
    highest: FloatArray
    # latest, earliest: phase relative to that of the response, rad
    latest: FloatArray
    earliest: FloatArray


def response_band(
    axis: Axis,
    values: Mapping[str, float],
    deviations: FloatArray,
    covariance: FloatArray,
    of: FrequencyResponse,
) -> ResponseBand:
    """Quantiles of the responses of parameters drawn around those identified.

    At a sharp resonance a response is not linear in its parameters: the peak moves by more than its width. Parameters
    are drawn log-normally, so that a mass stays positive; the draws are the same each time. Correlations come from the
    covariance; `deviations` are infinite or nan where undetermined.

    >>> from symid.axis import load_axis
    >>> from symid.simulation.plants.frequency_response import identified_response
    >>> axis, values = load_axis("rigid_1m"), {"M": 2.0, "Fv": 0.0, "Fs": 1.0}
    >>> f, none = np.array([1.0]), np.zeros(1)
    >>> identified = identified_response(axis, values, "q", f, 1)
    >>> of = FrequencyResponse("F", "q", "velocity", "", f, none + 0j, none, identified)
    >>> band = response_band(axis, values, np.array([0.02, 0.0, 0.0]), np.diag([4e-4, 0.0, 0.0]), of)
    >>> bool(0.95 < np.log(band.highest / band.lowest)[0] / (2 * 1.96 * 0.01) < 1.05)
    True
    """
    places = _places(of)
    frequency, centre = of.frequency[places], of.identified[places]
    value = np.array(list(values.values()))
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = np.where(value != 0, np.fmin(deviations / np.abs(value), _WIDEST), 0.0)
        correlations = np.nan_to_num(correlation_matrix(covariance))
    alone = np.where((value == 0) & np.isfinite(deviations), deviations, 0.0)
    factor = _root(correlations)
    # a Latin hypercube: each parameter has the quantiles of a normal one, in its own order
    order = np.random.default_rng(_SEED).permuted(np.tile(np.arange(_DRAWS), (value.size, 1)), axis=1).T
    normal = scipy.special.ndtri((order + 0.5) / _DRAWS) @ factor.T
    drawn = value * np.exp(relative * normal) + alone * normal
    dynamics = forward_dynamics(axis)
    plants = (dynamics.at(dict(zip(values, one, strict=True))) for one in drawn.tolist())
    ratios = np.array([plant_response(plant, of.signal, frequency, of.order) / centre for plant in plants])
    low, high = np.quantile(np.abs(ratios), _SIDES, axis=0, method="hazen")
    late, early = np.quantile(np.angle(ratios), _SIDES, axis=0, method="hazen")
    size = np.abs(centre)
    return ResponseBand(frequency, size * low, size * high, late, early)


def _root(correlations: FloatArray) -> FloatArray:
    """A factor of correlations, whose rows keep their length though rounding made them indefinite."""
    np.fill_diagonal(correlations, 1.0)
    spread, directions = np.linalg.eigh(correlations)
    factor = directions * np.sqrt(np.maximum(spread, 0.0))
    return np.asarray(factor / np.linalg.norm(factor, axis=1, keepdims=True))


def _places(of: FrequencyResponse) -> IntArray:
    """Frequencies of a band: evenly over the octaves, and every peak and notch with its neighbours."""
    f, size = np.log(of.frequency), np.abs(of.identified)
    even = np.searchsorted(f, np.linspace(f[0], f[-1], _MOST_PLACES))
    turns = 1 + np.flatnonzero(np.diff(np.sign(np.diff(size))))
    beside = (turns[:, None] + np.arange(-3, 4)).ravel()
    return np.unique(np.clip(np.concatenate([even, beside]), 0, f.size - 1))
