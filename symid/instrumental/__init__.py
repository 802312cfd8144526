"""Instrumental variables: identification that noise of the sensors does not bias, by a simulation of the axis."""

from symid.instrumental.instrumental_variables import identify_by_instruments

__all__ = ["identify_by_instruments"]
