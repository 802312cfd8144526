"""Identification without derivatives: one-step prediction of the exactly sampled axis, by maximum likelihood."""

from symid.output_error.likelihood_result import OutputErrorIdentification
from symid.output_error.maximum_likelihood import identify_output_error
from symid.output_error.predicted_log import OutputErrorPrediction

__all__ = ["OutputErrorIdentification", "OutputErrorPrediction", "identify_output_error"]
