"""Detection of a recorded force whose range ended before the force did.

A drive at its limit moves the axis by the force that is recorded: a model fitted to the rest of the log predicts that
force. Where it predicts more, differently from moment to moment while the record hardly changes, the record was cut.
"""

from __future__ import annotations

import numpy as np

from symid.data.quality.stuck import is_switched
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.gauss_newton import fitted
from symid.diagnosis.fitting.state import first_state
from symid.diagnosis.thresholds import THRESHOLDS
from symid.errors import LogError

_FLAT, _OF_NOISE = 0.002, 8.0
"""Width of a limit: part of the range of the force, and standard deviations of its noise."""
_LEAST = 0.005
"""Least share of the motion in which the force is at the limit."""
_REST = 0.1
"""Most mean square that the rest of the log leaves, relative to that of the whole: else the model lacks more."""
_BEYOND, _VARIES = 5.0, 3.0
"""Least mean and spread of what the prediction has beyond the limit, relative to its error in the rest of the log, and
to the spread of the record."""


def cut_force(found: Fit, drive: int) -> str:
    """Sentence if the range of a recorded force ended before the force did; empty if it did not."""
    record = found.state.prediction.record
    name = record.forces[drive]
    samples, width = record.log[name], _OF_NOISE * float(record.noise_of_outputs[drive])
    if found.squares[drive] < THRESHOLDS.fit_of_noise or is_switched(samples):
        return ""
    at = np.rint(record.fine_time / record.log.sampling_period).astype(int)
    force = samples[np.minimum(at, samples.size - 1)]
    moving = record.in_log & record.moves(record.speeds[drive])
    width = max(width, _FLAT * float(np.ptp(samples)))
    top, bottom = moving & (force > samples.max() - width), moving & (force < samples.min() + width)
    free = moving & ~(top | bottom)
    try:
        allowed = free if found.weighting.allowed is None else free & found.weighting.allowed
        rest = fitted(*first_state(record, found.parameters, allowed))
    except LogError:
        return ""
    if rest.squares[drive] > _REST * found.squares[drive]:
        return ""
    asked = record.fine(record.measured[drive] - rest.state.errors[drive])
    error = float(np.sqrt(np.mean((asked - force)[free] ** 2)))
    for sign, limited in ((1.0, top), (-1.0, bottom)):
        if np.sum(limited) < _LEAST * np.sum(moving):
            continue
        beyond = sign * (asked - force)[limited]
        varies = np.std(asked[limited]) > _VARIES * np.std(force[limited])
        if np.mean(beyond) > _BEYOND * error and varies:
            return (
                f"{name} ends at {np.mean(force[limited]):.4g} in {100 * np.sum(limited) / np.sum(moving):.2g} % of "
                f"the motion, which asks for up to {asked[limited][np.argmax(beyond)]:.4g} there: its record is "
                "clipped; record with a wider range, or cut those parts out"
            )
    return ""
