"""Logs of machines: reading, checking, filtering and differentiating them."""

from symid.data.checks import inspect_spans, inspect_values
from symid.data.clock import MINIMUM_SAMPLES, Clock, inspect_clock
from symid.data.filtering import (
    LowPass,
    central_difference,
    central_difference_gain,
    decimate,
    derivatives,
    kept_indices,
)
from symid.data.log import Log
from symid.data.reading import REFERENCE, read_log

__all__ = [
    "MINIMUM_SAMPLES",
    "REFERENCE",
    "Clock",
    "Log",
    "LowPass",
    "central_difference",
    "central_difference_gain",
    "decimate",
    "derivatives",
    "inspect_clock",
    "inspect_spans",
    "inspect_values",
    "kept_indices",
    "read_log",
]
