"""Identification without derivatives: one-step prediction of the exactly sampled axis, by maximum likelihood."""

from symid.output_error.identify import identify_output_error, predict_output_error
from symid.output_error.predicted_log import OutputErrorPrediction
from symid.output_error.result import OutputErrorIdentification

__all__ = [
    "OutputErrorIdentification",
    "OutputErrorPrediction",
    "identify_output_error",
    "predict_output_error",
]
