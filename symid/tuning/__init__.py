"""Tuning: cutoff frequency and sampling period from bounds on the errors of the parameters."""

from symid.tuning.bound import BoundSearch, lowest_within
from symid.tuning.exact_run import ExactRun, exact_run
from symid.tuning.excitation import excited_band, modes_hz, tuning_chirp
from symid.tuning.low_pass import LowPassErrors
from symid.tuning.standard import StandardModel, standard_model
from symid.tuning.tune import Tuning, first_sampling_frequency, tune, without_jumps

__all__ = [
    "BoundSearch",
    "ExactRun",
    "LowPassErrors",
    "StandardModel",
    "Tuning",
    "exact_run",
    "excited_band",
    "first_sampling_frequency",
    "lowest_within",
    "modes_hz",
    "standard_model",
    "tune",
    "tuning_chirp",
    "without_jumps",
]
