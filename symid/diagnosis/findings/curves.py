"""Signals and spectra of a comparison, for pages and plots."""

import numpy as np
import scipy

from symid.arrays import FloatArray
from symid.diagnosis.findings.comparison import Comparison
from symid.diagnosis.findings.diagnosis_result import Signals, Spectrum, WeightedError

_SEGMENT = 1024
_USED = 0.65
_MEMORY = 64
"""Lags up to which the memory of the weighted noise is kept."""


def signal_curves(comparison: Comparison) -> Signals:
    """Forces of a drive in the band of the gap: measured, and of the models."""
    record, inside = comparison.record, comparison.record.rows_in_log
    measured = record.rows(comparison.measured * record.taper)[inside]

    def predicted(model: int) -> FloatArray:
        state = comparison.states[model]
        if state is None:
            return np.full(measured.size, np.nan)
        return measured - record.rows(state.errors[comparison.drive] * record.taper)[inside]

    return Signals(
        time=record.row_time[inside] + record.log.time[0],
        position=record.rows(comparison.motion)[inside],
        velocity=record.rows(1j * record.omega * comparison.motion)[inside],
        measured=measured,
        nominal=predicted(0),
        reidentified=predicted(1),
        explained=predicted(len(comparison.states) - 1),
        compared=comparison.weighting.kept[inside],
    )


def weighted_of(comparison: Comparison) -> WeightedError | None:
    """The last model in the weights of the rows; None where its hidden motion grew without bound."""
    state, errors, drive = comparison.states[-1], comparison.errors[-1], comparison.drive
    if state is None or errors is None:
        return None
    record, weighting = comparison.record, comparison.weighting
    predicted = weighting.rows(record.measured - state.errors)[drive]
    weights = weighting.density[drive] / state.prediction.noise_density[drive]
    power = np.zeros(record.n_rows // 2 + 1)
    power[: record.n_bins] = (weights * record.taper) ** 2
    noise = scipy.fft.irfft(power, record.n_rows)[:_MEMORY]
    inside = record.rows_in_log
    return WeightedError(np.nan_to_num(errors[drive])[inside], predicted[inside], noise / noise[0])


def spectrum_of(comparison: Comparison) -> Spectrum:
    """Densities of a drive's force error, before and after, and of the noise."""
    record = comparison.record
    grid, before = comparison.power(1, _SEGMENT)
    after = comparison.power(len(comparison.errors) - 1, _SEGMENT)[1]
    used = (grid > 0) & (grid < _USED * record.band_hz)
    weight = np.interp(grid, record.omega / (2 * np.pi), comparison.weighting.density[comparison.drive])
    noise = np.sqrt(2 / comparison.row_rate) / weight
    reidentified, explained = (np.sqrt(power / comparison.kept_share) / weight for power in (before, after))
    return Spectrum(grid[used], reidentified[used], explained[used], noise[used])
