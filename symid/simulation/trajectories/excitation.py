"""References for an axis: chirps, multisines, moves, steps, and those read from a log.

All begin and end at rest unless their documentation states otherwise, and raise `SettingError` where they
cannot stay within the limits of the axis. `Trajectory.then` joins trajectories.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Literal

import numpy as np

from symid.arrays import FloatArray
from symid.data import REFERENCE, Log
from symid.errors import SettingError
from symid.signal_processing import derivatives
from symid.simulation.trajectories.limits import Limits, checked_positive, fade_envelope, intervals
from symid.simulation.trajectories.multisine import DERIVATIVE_ORDER, MotionQuantity
from symid.simulation.trajectories.trajectory import Trajectory

Sweep = Literal["linear", "logarithmic"]
"""How the frequency of a chirp changes over time."""
_TRIAL = 1e-3
"""Size of a trial motion, SI."""


def chirp(
    f0: float,
    f1: float,
    seconds: float,
    amplitude: float,
    *,
    sampling_period: float,
    quantity: MotionQuantity = "position",
    sweep: Sweep = "linear",
    fade: float | None = None,
    centre: float = 0.0,
    limits: Limits | None = None,
) -> Trajectory:
    """Sine about a position, faded in and out, whose frequency changes from `f0` to `f1`.

    The position is centre + A w(t) omega(t)^-k sin(phi(t)), where omega is the derivative of the phase phi, w the
    envelope and k the order of the derivative that has amplitude A. Velocity and acceleration are its exact
    derivatives. Where the frequency changes little during a cycle, A is the amplitude of the chosen quantity at
    all frequencies.

    Parameters
    ----------
    f0, f1 : float
        Frequency at the beginning and at the end, Hz.
    seconds : float
        Duration, s, fades included; rounded up to whole sampling periods.
    amplitude : float
        Amplitude of `quantity`, SI.
    sampling_period : float
        Time between two samples, s.
    quantity : {"position", "velocity", "acceleration"}
        Quantity that has this amplitude.
    sweep : {"linear", "logarithmic"}
        Whether the frequency changes by equal differences or by equal ratios in equal times.
    fade : float, optional
        Duration of the fade-in and of the fade-out, s; by default a tenth of the chirp. With 0 the chirp has
        full amplitude throughout, and neither begins nor ends at rest.
    centre : float
        Mean position, m or rad; a faded chirp begins and ends there.
    limits : Limits, optional
        Limits of the axis, which all samples must keep.

    Raises
    ------
    SettingError
        If a frequency reaches half the sampling frequency, a value is not possible, or a limit is exceeded.

    Examples
    --------
    >>> sweep = chirp(1.0, 10.0, 5.0, 0.02, sampling_period=0.001, quantity="velocity")
    >>> sweep.duration, sweep.position[[0, -1]].tolist(), round(sweep.velocity.max().item(), 3)
    (5.0, [0.0, 0.0], 0.02)
    >>> chirp(1.0, 10.0, 5.0, 0.02, sampling_period=0.001, limits=Limits((-1.0, 1.0), speed=1.0))
    Traceback (most recent call last):
        ...
    symid.errors.SettingError: chirp from 1 to 10 Hz: speed reaches 1.14985, 0.149851 more than the limit of 1 m/s or \
rad/s: multiply the amplitude by at most 0.8696
    """
    count = intervals(checked_positive(seconds, "chirp", "s"), sampling_period, "chirp")
    _check_chirp(f0, f1, sampling_period, quantity, sweep)
    size = checked_positive(amplitude, "amplitude of the chirp", "SI")
    n_fade = intervals(0.1 * seconds if fade is None else fade, sampling_period, "fade")
    if 2 * n_fade > count:
        raise SettingError(
            f"fades of {n_fade * sampling_period:g} s do not fit twice into {seconds:g} s: give at most half of that"
        )
    time = sampling_period * np.arange(count + 1, dtype=np.float64)
    phase, *omega = _phase(f0, f1, time, count * sampling_period, sweep)
    window = fade_envelope(count, n_fade, sampling_period)
    g, slope, curvature = _scaled(window, omega, DERIVATIVE_ORDER[quantity], size)
    # Position g(t) sin(phi(t)) and its derivatives, g being the amplitude of the position and phi' = omega.
    sine, cosine = np.sin(phase), np.cos(phase)
    return Trajectory(
        position=centre + g * sine,
        velocity=slope * sine + g * omega[0] * cosine,
        acceleration=(curvature - g * omega[0] ** 2) * sine
        + (2.0 * slope * omega[0] + g * omega[1]) * cosine,
        sampling_period=sampling_period,
        name=f"chirp from {f0:g} to {f1:g} Hz",
    ).checked(limits)


def _check_chirp(f0: float, f1: float, sampling_period: float, quantity: str, sweep: str) -> None:
    if quantity not in DERIVATIVE_ORDER:
        raise SettingError(f"amplitude of {quantity!r} is not known: choose {', '.join(DERIVATIVE_ORDER)}")
    if sweep not in ("linear", "logarithmic"):
        raise SettingError(f"sweep {sweep!r} is not known: choose linear or logarithmic")
    low, high = min(f0, f1), max(f0, f1)
    if not (low >= 0.0 and high > 0.0 and high * sampling_period < 0.5):
        raise SettingError(
            f"chirp from {f0:g} to {f1:g} Hz is not possible: give frequencies from 0 Hz to below half the "
            f"sampling frequency of {1.0 / sampling_period:g} Hz"
        )
    if low == 0.0 and (sweep == "logarithmic" or quantity != "position"):
        raise SettingError(
            f"chirp from {f0:g} to {f1:g} Hz has no end at 0 Hz if it is logarithmic or has a constant amplitude "
            f"of {quantity}: give a positive frequency, or a linear sweep with an amplitude of position"
        )


def _phase(
    f0: float, f1: float, time: FloatArray, seconds: float, sweep: Sweep
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Phase of the chirp and its derivatives of order 1 to 3, rad and s."""
    start, end = 2.0 * np.pi * f0, 2.0 * np.pi * f1
    if sweep == "linear" or f0 == f1:
        rate = (end - start) / seconds
        return time * (start + 0.5 * rate * time), start + rate * time, np.full_like(time, rate), 0.0 * time
    growth = math.log(f1 / f0) / seconds
    omega = start * np.exp(growth * time)
    return start * np.expm1(growth * time) / growth, omega, growth * omega, growth**2 * omega


def _scaled(
    window: tuple[FloatArray, FloatArray, FloatArray], omega: Sequence[FloatArray], order: int, size: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Amplitude size * w * omega^-order of the position, with its first and second time derivatives."""
    w, slope, curvature = (size * part for part in window)
    if order == 0:
        return w, slope, curvature
    power = omega[0] ** -order
    relative = omega[1] / omega[0]
    power_slope = -order * relative * power
    power_curvature = order * ((order + 1) * relative**2 - omega[2] / omega[0]) * power
    return (
        w * power,
        slope * power + w * power_slope,
        curvature * power + 2.0 * slope * power_slope + w * power_curvature,
    )


def steps(
    levels: Sequence[float], hold: float, *, sampling_period: float, limits: Limits | None = None
) -> Trajectory:
    """Positions held in turn, with a jump from each to the next.

    Velocity and acceleration are zero, as they are between the jumps; only the travel is checked against the limits.

    Parameters
    ----------
    levels : sequence of float
        Positions, m or rad; the first is where the axis begins.
    hold : float
        Time at each position, s; rounded up to whole sampling periods.
    sampling_period : float
        Time between two samples, s.
    limits : Limits, optional
        Limits of the axis.

    Raises
    ------
    SettingError
        If there are no levels, the time is not positive, or a level is beyond the travel.

    Examples
    --------
    >>> steps([0.0, 0.1], 1.0, sampling_period=0.5).position.tolist()
    [0.0, 0.0, 0.1, 0.1, 0.1]
    """
    values = np.asarray(levels, dtype=np.float64)
    if values.ndim != 1 or values.size == 0:
        raise SettingError(f"levels have shape {values.shape}: give a list of at least one position")
    count = intervals(checked_positive(hold, "hold", "s"), sampling_period, "hold")
    intervals(values.size * count * sampling_period, sampling_period, "steps")
    position = np.append(np.repeat(values, count), values[-1])
    still = np.zeros_like(position)
    return Trajectory(position, still, still, sampling_period, f"steps through {values.size} levels").checked(
        limits
    )


def from_log(log: Log, signal: str = REFERENCE, *, limits: Limits | None = None) -> Trajectory:
    """Reference read from a log, with its derivatives by central differences.

    It need not begin or end at rest.

    Parameters
    ----------
    log : Log
        Log with the commanded position.
    signal : str
        Name of the signal that holds the commanded position, m or rad.
    limits : Limits, optional
        Limits of the axis.

    Raises
    ------
    LogError
        If the log has no such signal.
    SettingError
        If it has fewer than two samples or exceeds the limits.

    Examples
    --------
    >>> log = Log.from_arrays({"reference": [0.0, 1.0, 4.0, 9.0]}, sampling_period=1.0)
    >>> from_log(log).velocity.tolist()
    [1.0, 2.0, 4.0, 5.0]
    """
    position = log[signal]
    velocity, acceleration = derivatives(position, log.sampling_period, 2)
    return Trajectory(
        position=position,
        velocity=velocity,
        acceleration=acceleration,
        sampling_period=log.sampling_period,
        name=f"{signal} of {log.source}",
        start=log.start,
    ).checked(limits)


def largest_within(
    made: Callable[[float], Trajectory], limits: Mapping[str, float], share: float = 1.0
) -> Trajectory:
    """The motion of a size at which it uses a share of the tightest limit, of those in `Extremes.reached`.

    >>> from functools import partial
    >>> made = partial(chirp, 1.0, 5.0, 2.0, sampling_period=1e-3)
    >>> motion = largest_within(made, {"travel": 0.2, "speed": 0.5, "acceleration": 5.0})
    >>> round(motion.extremes.acceleration, 6)
    5.0
    """
    reached = made(_TRIAL).extremes.reached
    return made(share * _TRIAL * min(limits[name] / value for name, value in reached.items()))
