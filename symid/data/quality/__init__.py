"""The clock of a log, and checks of its channels: lost samples, stuck and clipped spans, jumps."""

from symid.data.quality.checks import constant_fault, inspect_finite, jumps_of
from symid.data.quality.clock import CLOCK_DIFFERENCE, inspect_clock
from symid.data.quality.lost_samples import (
    FEWEST_LOST,
    dropped,
    repeated,
    restored,
    step_of,
    without_repeated_rows,
)
from symid.data.quality.stuck import inspect_spans, is_switched

__all__ = [
    "CLOCK_DIFFERENCE",
    "FEWEST_LOST",
    "constant_fault",
    "dropped",
    "inspect_clock",
    "inspect_finite",
    "inspect_spans",
    "is_switched",
    "jumps_of",
    "repeated",
    "restored",
    "step_of",
    "without_repeated_rows",
]
