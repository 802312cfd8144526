"""A delay or a lag of the force has one time: in data that took no part in its choice too.

Where a controller counteracts a force that the model lacks, the record of the drive follows the motion as it would
behind a delay, and its time depends on the motion: the clock of a recorder and a current loop do not.
"""

import numpy as np

from symid.diagnosis.effects import LATE_FORCES, time_of
from symid.diagnosis.findings.comparison import Comparison
from symid.diagnosis.fitting.deviations import standard_deviations
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.gauss_newton import ITERATIONS, fitted
from symid.diagnosis.thresholds import THRESHOLDS
from symid.errors import SymidError


def timing_that_varies(found: Fit, comparison: Comparison) -> int | None:
    """Index of the first delay or lag of a fit that has clearly another time on the data of a comparison.

    Unless it explains these: recorders that are started anew may be late by another time.
    """
    state = comparison.states[-1]
    if state is None or not any(item.effect.name in LATE_FORCES for item in found.state.placed):
        return None
    try:
        own = fitted(state, comparison.weighting, ITERATIONS)
        deviations = [standard_deviations(fit) for fit in (found, own)]
    except (SymidError, ArithmeticError, np.linalg.LinAlgError):
        return None
    if own.mean_square < THRESHOLDS.clear_gap:
        return None
    for i, (item, here) in enumerate(zip(found.state.placed, own.state.placed, strict=True)):
        if item.effect.name not in LATE_FORCES:
            continue
        time, other = time_of(item), time_of(here)
        at = found.state.values_of[i].stop - 1
        deviation = np.hypot(*(each[at] for each in deviations))
        if abs(other - time) > max(THRESHOLDS.other_time * deviation, THRESHOLDS.far_other_time * abs(time)):
            return i
    return None
