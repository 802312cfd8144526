"""Controller gains read from a log that was recorded under a cascade."""

import numpy as np
import scipy

from symid.arrays import least_squares
from symid.data import REFERENCE, Log
from symid.signal_processing import LowPass, derivatives
from symid.simulation import Cascade

_SEEN = 1e-3
"""Gain of the low-pass filter above which a frequency is used."""


def cascade_of_log(
    log: Log, force: str, position: str, cutoff_hz: float, reference: str = REFERENCE
) -> Cascade | None:
    """Cascade whose force is nearest to that of a log up to `cutoff_hz`, by least squares; None if it is not a cascade.

    With the errors e = r - q of position and de of velocity the force of `Cascade` is linear,

        F = Kpv (Kpp + Kiv) e + Kpv de + Kpv Kpp Kiv (integral of e) + Kfv dr + Kfa ddr + constant

    and its first three factors give the gains. They need not be exact: instruments must resemble the motion and be free
    of its noise.

    >>> from symid.axis import load_axis
    >>> from symid.simulation import chirp, plant_of, simulate
    >>> axis, values = load_axis("rigid_1m"), {"M": 5.0, "Fv": 3.0, "Fs": 0.0}
    >>> gains = Cascade("q", position_gain=30.0, velocity_gain=400.0, integral_gain=10.0)
    >>> log = simulate(axis, values, chirp(0.5, 9.0, 2.0, 0.01, sampling_period=1e-3), gains).log
    >>> found = cascade_of_log(log, "F", "q", 100.0)
    >>> round(found.position_gain), round(found.velocity_gain), round(found.integral_gain)
    (30, 400, 10)
    """
    wanted, q, F = (log[name] for name in (reference, position, force))
    period = log.sampling_period
    speed, acceleration = derivatives(wanted, period, 2)
    error = wanted - q
    # a drive differentiates readings by backward differences; it knows the derivatives of the reference
    error_of_speed = speed - np.diff(q, prepend=q[0]) / period
    columns = [error, error_of_speed, period * np.cumsum(error), speed, acceleration, np.ones_like(error)]
    # a linear equation of samples holds for their spectra too, whatever the signals do at the ends of the log
    gain = LowPass(cutoff_hz).gain(np.fft.rfftfreq(F.size, period))
    used = gain > _SEEN
    spectra = np.stack([scipy.fft.rfft(x)[used] * gain[used] for x in (*columns, F)], axis=1)
    rows = np.concatenate([spectra.real, spectra.imag])
    factors = least_squares(rows[:, :-1], rows[:, -1], rcond=1e-9)
    return _cascade(position, *map(float, factors[:5]))


def _cascade(
    position: str, by_error: float, by_speed: float, by_integral: float, feed_speed: float, feed: float
) -> Cascade | None:
    """Kpp and Kiv are the roots of z^2 - (Kpp + Kiv) z + Kpp Kiv; the larger one is taken as Kpp."""
    if not by_speed > 0:
        return None
    roots = np.roots([1.0, -by_error / by_speed, max(by_integral, 0.0) / by_speed])
    integral, proportional = sorted(float(root.real) for root in roots)
    if not proportional > 0:
        return None
    return Cascade(position, proportional, by_speed, max(integral, 0.0), feed, feed_speed)
