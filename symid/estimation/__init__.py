"""Least squares on triangular factors, rank analysis, and covariances under correlated residuals."""

from symid.estimation.corrected_covariance import CorrelatedCovariance, ObservationBlock, corrected_covariance
from symid.estimation.least_squares import LeastSquares, estimate, relative_standard_deviation, residuals
from symid.estimation.refinement import refine
from symid.estimation.triangular import TriangularFactor, combine, triangular_factors

__all__ = [
    "CorrelatedCovariance",
    "LeastSquares",
    "ObservationBlock",
    "TriangularFactor",
    "combine",
    "corrected_covariance",
    "estimate",
    "refine",
    "relative_standard_deviation",
    "residuals",
    "triangular_factors",
]
