"""Least squares on triangular factors, rank analysis, and covariances under correlated residuals."""

from symid.estimation.corrected_covariance import (
    CorrelatedCovariance,
    ObservationBlock,
    corrected_covariance,
    corrected_covariance_of_blocks,
)
from symid.estimation.least_squares import (
    LeastSquares,
    Method,
    estimate,
    relative_standard_deviation,
    residuals,
)
from symid.estimation.refinement import refine, refine_blocks
from symid.estimation.triangular import TriangularFactor, combine, triangular_factors

__all__ = [
    "CorrelatedCovariance",
    "LeastSquares",
    "Method",
    "ObservationBlock",
    "TriangularFactor",
    "combine",
    "corrected_covariance",
    "corrected_covariance_of_blocks",
    "estimate",
    "refine",
    "refine_blocks",
    "relative_standard_deviation",
    "residuals",
    "triangular_factors",
]
