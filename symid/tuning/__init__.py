"""Tuning: cutoff frequency and sampling period, from bounds on systematic errors or from the total error."""

from symid.tuning.bound import BoundSearch
from symid.tuning.exact_run import exact_run, excited_band, tuning_chirp
from symid.tuning.from_log import identified_and_tuned
from symid.tuning.total import TotalTuning, tune_total
from symid.tuning.tune import Tuning, tune, without_jumps

__all__ = [
    "BoundSearch",
    "TotalTuning",
    "Tuning",
    "exact_run",
    "excited_band",
    "identified_and_tuned",
    "tune",
    "tune_total",
    "tuning_chirp",
    "without_jumps",
]
