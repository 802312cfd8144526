"""Least squares, linear on triangular factors and nonlinear, rank analysis, covariances under correlated residuals."""

from symid.estimation.corrected_covariance import (
    CorrelatedCovariance,
    ObservationBlock,
    corrected_covariance,
    corrected_covariance_of_blocks,
)
from symid.estimation.correlation import independent_rows
from symid.estimation.least_squares import LeastSquares, Method, estimate, residuals
from symid.estimation.refinement import refine_blocks
from symid.estimation.triangular import TriangularFactor, triangular_factors

__all__ = [
    "CorrelatedCovariance",
    "LeastSquares",
    "Method",
    "ObservationBlock",
    "TriangularFactor",
    "corrected_covariance",
    "corrected_covariance_of_blocks",
    "estimate",
    "independent_rows",
    "refine_blocks",
    "residuals",
    "triangular_factors",
]
