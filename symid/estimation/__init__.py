"""Least squares, linear on triangular factors and nonlinear, rank analysis, covariances under correlated residuals."""

from symid.estimation.autoregression import Autoregression, autoregression, unweighted
from symid.estimation.corrected_covariance import (
    CorrelatedCovariance,
    ObservationBlock,
    corrected_covariance,
    corrected_covariance_of_blocks,
)
from symid.estimation.correlation import correlation_matrix, independent_rows
from symid.estimation.least_squares import (
    LeastSquares,
    Method,
    estimate,
    fit_percent,
    relative_standard_deviation,
    residuals,
)
from symid.estimation.levenberg_marquardt import Minimum, central_slope, levenberg_marquardt
from symid.estimation.refinement import refine_blocks
from symid.estimation.triangular import TriangularFactor, triangle, triangular_factors

__all__ = [
    "Autoregression",
    "CorrelatedCovariance",
    "LeastSquares",
    "Method",
    "Minimum",
    "ObservationBlock",
    "TriangularFactor",
    "autoregression",
    "central_slope",
    "corrected_covariance",
    "corrected_covariance_of_blocks",
    "correlation_matrix",
    "estimate",
    "fit_percent",
    "independent_rows",
    "levenberg_marquardt",
    "refine_blocks",
    "relative_standard_deviation",
    "residuals",
    "triangle",
    "triangular_factors",
    "unweighted",
]
