"""Bands of a log, and the settings that follow from them where a preparation leaves them open."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from symid.arrays import ComplexArray, FloatArray
from symid.codegen import GeneratedModel
from symid.data import AnyLog, Log, require_times_within
from symid.identification.rows.noise import noise_levels, noise_limited_widening, spread_excerpts
from symid.identification.rows.settings import LOW_PASSED, Preparation
from symid.signal_processing import (
    NOISE_FROM,
    derivatives,
    differencing_bandwidth,
    explained_power,
    mean_power,
    segment_spectra,
)

_COHERENT = 0.8
_MARGIN, _HIGHEST_MARGIN = 1.5, 3.0
_LEAST_SEGMENTS = 8
_NOISE_SHARE = 0.005
_KEPT_AMPLITUDE = 0.97
_BAND_ORDER = 2
"""Differences of the paper's order bound the first cutoff, whatever order is used: sharper ones are accurate five times
as far, but noise there draws parameters of stiff parts towards zero (errors in variables; a ball screw with a scale
lost 47 % of its table's mass at 1010 Hz, 0.03 % at 154 Hz)."""
_PAPER_PERIODS = 3
"""Periods of the cutoff that are trimmed at each end with the paper's differences, with which its tables are made."""
_WIDEST = 4.0
"""Times the cutoff that motion in laws is filtered at most: from there on reversals are off by next to nothing (a mass
on a multisine: Fv +1.6 % at 1, +0.04 % at 4, +0.03 % at 16)."""
_LAWS_SEEN = 65_536
"""Samples in the middle of a log from which the noise of its velocities is estimated."""


@dataclass(frozen=True, eq=False)
class Spectra:
    """Windowed Fourier transforms of segments of a log (Welch)."""

    frequency: FloatArray  # shape (n_frequencies,): in Hz
    forces: ComplexArray  # shape (n_drives, n_segments, n_frequencies): of the force of each drive
    # shape (n_segments, n_frequencies): of the second derivative of the signal that is differentiated most
    motion: ComplexArray
    power: FloatArray  # shape (n_frequencies,): of that signal itself, to a factor

    @classmethod
    def of(cls, log: AnyLog, model: GeneratedModel) -> Spectra:
        """Spectra of a log; above a million samples, of evenly spread excerpts."""
        recorded = spread_excerpts(log, model.most_differentiated)
        segment = max(16, min(8192, log.n_samples // (_LEAST_SEGMENTS // 2 + 1)))
        length = min(segment, recorded.shape[1])
        acceleration = derivatives(recorded, log.sampling_period, 2)[1]
        forces = np.stack([segment_spectra(spread_excerpts(log, force), length) for force in model.forces])
        motion, itself = (segment_spectra(x, length) for x in (acceleration, recorded))
        power = mean_power(itself)
        if length % 2 == 0:
            power[-1] *= 0.5  # every other line represents its negative frequency too
        return cls(np.arange(power.size) / (length * log.sampling_period), forces, motion, power)

    @property
    def coherence(self) -> FloatArray:
        """Share of the motion's power that is linear in the forces: with several drives the multiple coherence."""
        with np.errstate(divide="ignore", invalid="ignore"):
            share = explained_power(self.motion, self.forces) / mean_power(self.motion)
        return np.asarray(np.nan_to_num(share, posinf=0.0))


def coherent_band(log: AnyLog, model: GeneratedModel, spectra: Spectra | None = None) -> float:
    """Highest frequency at which forces and motion are coherent, in Hz: above it a log holds only noise.

    The magnitude-squared coherence is averaged over segments (Welch); a frequency counts where it exceeds 0.8, and
    the spectrum is smoothed over five lines so that lines of noise do not count.
    """
    seen = spectra or Spectra.of(log, model)
    smooth = np.convolve(seen.coherence, np.full(5, 0.2), mode="same")
    above = np.flatnonzero(smooth > _COHERENT)
    return float(seen.frequency[above[-1]]) if above.size else log.sampling_frequency / 20


def noise_limited_band(log: AnyLog, model: GeneratedModel, spectra: Spectra | None = None) -> float:
    """Highest cutoff at which noise is no more than `_NOISE_SHARE` of the power of the highest derivative, in Hz.

    Noise in the columns of W draws the parameters towards zero by about this share (errors in variables). Its level is
    that of the log itself above 0.7 of the Nyquist frequency, taken as white.
    """
    seen = spectra or Spectra.of(log, model)
    frequency, power = seen.frequency, seen.power
    noise = float(np.median(power[frequency > NOISE_FROM * log.sampling_frequency]))
    gain = (2 * np.pi * frequency) ** (2 * model.highest_derivatives[model.most_differentiated])
    share = np.cumsum(noise * gain)[1:] / np.maximum(np.cumsum(power * gain)[1:], np.finfo(float).tiny)
    quiet = np.flatnonzero(share < _NOISE_SHARE)
    return float(frequency[1:][quiet[-1]]) if quiet.size else float(frequency[1:][np.argmin(share)])


def accurate_band(log: AnyLog, model: GeneratedModel, difference_order: int) -> float:
    """Frequency at which repeated central differences of an order lose 3 % of the highest derivative [36], in Hz.

    Models with derivatives of different orders in one equation are biased by the difference of these losses.
    """
    order = max(model.highest_derivatives.values())
    share = differencing_bandwidth(order, _KEPT_AMPLITUDE, order=difference_order) if order else 0.5
    return share * log.sampling_frequency


def cutoff_range(log: AnyLog, model: GeneratedModel, difference_order: int) -> tuple[float, float, float]:
    """Cutoff to begin with, the highest to which forces and motion are coherent, and the highest of all, in Hz.

    All stay in the quiet band. The first also stays below 1.5 times the coherent band and where differences of the
    paper's order are accurate, the second below 3 times the coherent band and, as the last, where those of this order
    are.
    """
    found = partial(_cutoff_range, log, model, difference_order)
    return log.kept((cutoff_range, model, difference_order), found) if isinstance(log, Log) else found()


def _cutoff_range(log: AnyLog, model: GeneratedModel, difference_order: int) -> tuple[float, float, float]:
    spectra = Spectra.of(log, model)
    coherent, quiet = coherent_band(log, model, spectra), noise_limited_band(log, model, spectra)
    first = min(_MARGIN * coherent, quiet, accurate_band(log, model, _BAND_ORDER))
    order = max(difference_order, _BAND_ORDER)
    highest = min(quiet, accurate_band(log, model, order))
    return float(f"{first:.3g}"), min(_HIGHEST_MARGIN * coherent, highest), highest


def completed(given: Preparation, log: AnyLog, model: GeneratedModel) -> Preparation:
    """Settings with everything chosen that was left open.

    The cutoff is the first one of `cutoff_range`; the decimation keeps it below half of the new Nyquist frequency;
    trimming leaves out one period of the cutoff frequency and one more for each derivative, which multiplies what a
    Butterworth filter remembers of its start: a tenth after each period. A hold of the force is part of `late`.
    """
    rate = log.sampling_frequency
    cutoff = given.cutoff_hz
    if cutoff is None:
        cutoff, *_ = cutoff_range(log, model, given.difference_order)
    decimation = given.decimation or max(1, int(LOW_PASSED * rate / (2 * cutoff)))
    highest = max(model.highest_derivatives.values())
    periods = _PAPER_PERIODS if given.difference_order == _BAND_ORDER else 1 + highest
    edge = math.ceil(periods * rate / cutoff) + highest * given.difference_order // 2
    edge = min(edge, log.n_samples // 10)
    trim = given.trim if given.trim is not None else (edge, edge)
    late = given.with_hold(model, log.sampling_period)
    require_times_within(log.source, late, log.n_samples * log.sampling_period)
    hold = log.sampling_period if given.is_held(model) else given.hold
    widening = given.widening or (widening_of(log, model, cutoff) if given.filter_force else 1.0)
    return replace(
        given,
        cutoff_hz=cutoff,
        decimation=decimation,
        trim=trim,
        late=late,
        held=False,
        hold=hold,
        widening=widening,
    )


def widening_of(
    log: AnyLog, model: GeneratedModel, cutoff: float, levels: Mapping[str, float] | None = None
) -> float:
    """Widening that the noise in the middle of a log allows; laws with known parameters are filtered alike.

    The levels of the noise of the sensors are read from the log if not given.
    """
    if model.known_laws or not any(model.sliding):
        return 1.0
    first = max(0, (log.n_samples - _LAWS_SEEN) // 2)
    stop = min(first + _LAWS_SEEN, log.n_samples)
    part = log if isinstance(log, Log) and not first else log.window(first, stop)
    own = noise_levels(model, part, forces=False) if levels is None else levels
    return noise_limited_widening(model, part, cutoff, own, _WIDEST)
