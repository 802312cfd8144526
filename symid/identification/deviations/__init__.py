"""Errors of the parameters beyond those by white noise: bias, scatter, what the model lacks."""

from symid.identification.deviations.bias import MOST_TAKEN, NoiseBias
from symid.identification.deviations.discrepancy import Discrepancy
from symid.identification.deviations.log_agreement import LogEstimate, disagreement_between
from symid.identification.deviations.stability import Change, greatest_change, scatter
from symid.identification.deviations.whitened import Segment, segments_of_rows

__all__ = [
    "MOST_TAKEN",
    "Change",
    "Discrepancy",
    "LogEstimate",
    "NoiseBias",
    "Segment",
    "disagreement_between",
    "greatest_change",
    "scatter",
    "segments_of_rows",
]
