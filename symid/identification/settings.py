"""How a log is prepared for the estimation."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import signal

from symid.arrays import FloatArray
from symid.codegen import GeneratedModel
from symid.data import Log, derivatives
from symid.errors import SettingError

_COHERENT = 0.8
_MARGIN = 1.5
_LEAST_SEGMENTS = 8


@dataclass(frozen=True)
class Preparation:
    """Filter, differences, decimation and choice of rows. What is None is chosen from the log.

    Parameters
    ----------
    cutoff_hz : float, optional
        Cutoff frequency of one pass of the zero-phase Butterworth filter.
    order : int
        Order of one pass.
    filter_force : bool
        Whether the force passes the same filter as the motion. False is the published recipe of EMPS; it biases
        flexible models, whose regressor holds derivatives of the force.
    decimation : int, optional
        Every so many samples one row.
    trim : tuple of int, optional
        Samples left out at the beginning and at the end.
    standstill : float, optional
        Speed below which rows do not enter equations with a law that jumps at standstill; 0 keeps all rows.
    held : bool
        Whether a sample of the force is held until the next one, so that it acts half a sample late.
    """

    cutoff_hz: float | None = None
    order: int = 4
    filter_force: bool = True
    decimation: int | None = None
    trim: tuple[int, int] | None = None
    standstill: float | None = None
    held: bool = False

    def __post_init__(self) -> None:
        for name, value, least in (("decimation", self.decimation, 1), ("standstill", self.standstill, 0.0)):
            if value is not None and not (math.isfinite(value) and value >= least):
                raise SettingError(f"{name} is {value}: it must be at least {least:g}")
        if self.trim is not None and min(self.trim) < 0:
            raise SettingError(f"trim is {self.trim}: both numbers of samples must be 0 or more")


def coherent_band(log: Log, model: GeneratedModel) -> float:
    """Highest frequency at which force and acceleration are coherent, in Hz: above it a log holds only noise.

    The magnitude-squared coherence is averaged over segments (Welch); a frequency counts where it exceeds 0.8, and
    the spectrum is smoothed over five lines so that lines of noise do not count.
    """
    force = next(name for name in model.highest_derivatives if name not in model.measured)
    highest = {name: order for name, order in model.highest_derivatives.items() if name in model.measured}
    name = max(highest, key=lambda n: (highest[n], -model.measured.index(n)))
    motion: FloatArray = derivatives(log[name], log.sampling_period, 2)[1] if highest[name] >= 2 else log[name]
    length = min(8192, log.n_samples // (_LEAST_SEGMENTS // 2 + 1))
    if length < 32:
        return log.sampling_frequency / 5
    frequency, coherence = signal.coherence(log[force], motion, fs=log.sampling_frequency, nperseg=length, detrend="linear")
    smooth = np.convolve(np.nan_to_num(coherence), np.full(5, 0.2), mode="same")
    above = np.flatnonzero(smooth > _COHERENT)
    return float(frequency[above[-1]]) if above.size else log.sampling_frequency / 20


def completed(given: Preparation, log: Log, model: GeneratedModel) -> Preparation:
    """Settings with everything chosen that was left open.

    The cutoff lies 1.5 times above the coherent band, at most at 0.2 of the sampling frequency; the decimation keeps
    the cutoff below 0.8 of the new Nyquist frequency; trimming leaves out three periods of the cutoff frequency, the
    time in which a Butterworth filter forgets its start to a thousandth.
    """
    rate = log.sampling_frequency
    cutoff = given.cutoff_hz
    if cutoff is None:
        cutoff = float(f"{min(_MARGIN * coherent_band(log, model), 0.2 * rate):.3g}")
    decimation = given.decimation or max(1, int(0.8 * rate / (2 * cutoff)))
    edge = min(math.ceil(3 * rate / cutoff) + max(model.highest_derivatives.values()), log.n_samples // 10)
    trim = given.trim if given.trim is not None else (edge, edge)
    return Preparation(cutoff, given.order, given.filter_force, decimation, trim, given.standstill, given.held)
