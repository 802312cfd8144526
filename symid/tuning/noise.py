"""The white noise of each signal of a log, and noise to add to noise-free ones."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
import scipy

from symid.arrays import FloatArray
from symid.data import Log

_QUIET = 0.35
"""Above this share of the sampling frequency (0.7 of Nyquist) a log is taken to hold noise only."""
_SEGMENTS = 16


def noise_levels(log: Log, force: str, measured: Sequence[str]) -> dict[str, float]:
    """Standard deviation of the white noise of the force and of each sensor, SI.

    The level is the median power density above 0.7 of the Nyquist frequency. A controller that reads a noisy position
    makes a noisy force, which is real and moves the axis; only the part of the force that is not coherent with the
    positions is noise of its record.

    Parameters
    ----------
    log : Log
        Holds the signals.
    force : str
        Signal of the drive.
    measured : sequence of str
        Signals of the sensors.

    Examples
    --------
    >>> still = Log.from_arrays({"q": np.zeros(20000), "F": np.zeros(20000)}, sampling_period=0.01)
    >>> levels = noise_levels(with_noise(still, {"q": 2.0, "F": 3.0}, seed=1), "F", ["q"])
    >>> round(levels["q"]), round(levels["F"])
    (2, 3)
    """
    rate, length = log.sampling_frequency, max(16, log.n_samples // _SEGMENTS)
    powers = {name: scipy.signal.welch(log[name], fs=rate, nperseg=length)[1] for name in (force, *measured)}
    frequency, own = scipy.signal.welch(log[force], fs=rate, nperseg=length)
    for name in measured:
        together = np.abs(scipy.signal.csd(log[force], log[name], fs=rate, nperseg=length)[1]) ** 2
        with np.errstate(divide="ignore", invalid="ignore"):
            explained = np.nan_to_num(together / powers[name], posinf=0.0)
        own = np.minimum(own, np.maximum(powers[force] - explained, 0.0))
    powers[force] = own
    quiet = frequency > _QUIET * rate
    return {name: math.sqrt(float(np.median(power[quiet])) * rate / 2) for name, power in powers.items()}


def with_noise(log: Log, levels: Mapping[str, float], seed: int) -> Log:
    """The log with white noise added; the same seed gives the same noise to logs of one length."""
    random = np.random.default_rng(seed)
    signals: dict[str, FloatArray] = dict(log.signals)
    for name in sorted(levels):
        signals[name] = signals[name] + levels[name] * random.standard_normal(log.n_samples)
    return Log(log.source, log.start, log.sampling_period, signals)
