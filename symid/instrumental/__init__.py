"""Instrumental variables: a simulation of the axis removes the bias that sensor noise causes in least squares."""

from symid.instrumental.instrumental_variables import identify_by_instruments

__all__ = ["identify_by_instruments"]
