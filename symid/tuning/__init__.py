"""Tuning: cutoff frequency and sampling period, from bounds on systematic errors or from the total error."""

from symid.tuning.bound import BoundSearch, lowest_within
from symid.tuning.exact_run import ExactRun, exact_run, excited_band, tuning_chirp
from symid.tuning.from_log import identified_and_tuned, run_of_log, runs_of_log
from symid.tuning.low_pass import LowPassErrors
from symid.tuning.standard import StandardModel, standard_model
from symid.tuning.total import TotalTuning, tune_total
from symid.tuning.total_errors import TotalErrors, with_noise
from symid.tuning.tune import Tuning, first_sampling_frequency, noise_free_run, tune, without_jumps

__all__ = [
    "BoundSearch",
    "ExactRun",
    "LowPassErrors",
    "StandardModel",
    "TotalErrors",
    "TotalTuning",
    "Tuning",
    "exact_run",
    "excited_band",
    "first_sampling_frequency",
    "identified_and_tuned",
    "lowest_within",
    "noise_free_run",
    "run_of_log",
    "runs_of_log",
    "standard_model",
    "tune",
    "tune_total",
    "tuning_chirp",
    "with_noise",
    "without_jumps",
]
