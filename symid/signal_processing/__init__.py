"""Processing of sampled signals: zero-phase filters, differences, splines, spectra."""

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
    "LowPass",
    "Piece",
    "QuinticSpline",
    "ZeroPhaseFilter",
    "central_difference",
    "central_difference_gain",
    "decimation_filter",
    "derivatives",
    "difference_factors",
    "differencing_bandwidth",
    "in_pieces",
    "kept_indices",
    "kept_of",
    "sparse_derivatives",
]
