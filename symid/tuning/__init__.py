"""Tuning: cutoff frequency and sampling period from bounds on the errors of the parameters."""

from symid.tuning.bound import BoundSearch
from symid.tuning.excitation import excited_band, modes_hz, tuning_chirp
from symid.tuning.tune import Tuning, first_sampling_frequency, tune, without_jumps

__all__ = [
    "BoundSearch",
    "Tuning",
    "excited_band",
    "first_sampling_frequency",
    "modes_hz",
    "tune",
    "tuning_chirp",
    "without_jumps",
]
