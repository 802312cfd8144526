"""Identification without derivatives: one-step prediction of the exactly sampled axis, by maximum likelihood."""

from symid.output_error.identify import OutputErrorIdentification, identify_output_error

__all__ = ["OutputErrorIdentification", "identify_output_error"]
