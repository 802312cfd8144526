"""Rows of the observation: signals filtered, differentiated, put into the regressor and thinned."""

from symid.identification.rows.bands import coherent_band, completed, widening_of
from symid.identification.rows.noise import noise_deviations, noise_of_rows, response_of_rows
from symid.identification.rows.settings import DIFFERENCE_ORDER, notes_on_declared

__all__ = [
    "DIFFERENCE_ORDER",
    "coherent_band",
    "completed",
    "noise_deviations",
    "noise_of_rows",
    "notes_on_declared",
    "response_of_rows",
    "widening_of",
]
