"""Instrumental variables: a simulation of the axis removes the bias that sensor noise causes in least squares."""

from symid.instrumental.instrumental_variables import identify_by_instruments
from symid.instrumental.recorded_gains import cascade_of_log

__all__ = ["cascade_of_log", "identify_by_instruments"]
