"""Processing of sampled signals: zero-phase filters, differences, splines, spectra."""

from symid.signal_processing.density import (
    NOISE_FROM,
    density_of,
    explained_power,
    incoherent_density,
    incoherent_density_of,
    mean_power,
    power_density,
    segment_spectra,
)
from symid.signal_processing.differences import (
    central_difference,
    central_difference_gain,
    derivatives,
    difference_factors,
    differencing_bandwidth,
    sparse_derivatives,
)
from symid.signal_processing.filtering import LowPass, decimation_filter, kept_indices
from symid.signal_processing.splines import QuinticSpline
from symid.signal_processing.zero_phase import Piece, ZeroPhaseFilter, in_pieces, kept_of

__all__ = [
    "NOISE_FROM",
    "LowPass",
    "Piece",
    "QuinticSpline",
    "ZeroPhaseFilter",
    "central_difference",
    "central_difference_gain",
    "decimation_filter",
    "density_of",
    "derivatives",
    "difference_factors",
    "differencing_bandwidth",
    "explained_power",
    "in_pieces",
    "incoherent_density",
    "incoherent_density_of",
    "kept_indices",
    "kept_of",
    "mean_power",
    "power_density",
    "segment_spectra",
    "sparse_derivatives",
]
