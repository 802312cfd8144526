"""The sign of a recorded force: opposite to that of the predicted force, or lost in an absolute value."""

from dataclasses import replace

import numpy as np

from symid.arrays import FloatArray, unexplained_by
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.gauss_newton import fitted
from symid.diagnosis.fitting.state import first_state

_OPPOSITE = -0.5
"""Correlation of the measured with the predicted force below which a sign may be wrong."""
_MIRRORED = 0.3
"""Error with the opposite force relative to that with the recorded one, mean squares, below which the sign is wrong."""
_BOTH_SIGNS = 0.2
"""Least share of samples with each sign in a predicted force for a record of one sign to be suspicious."""
_FOLLOWS = 0.5
"""Share of the squares of a record, less its mean, that a course must explain for the record to follow it."""
_LEFT = 0.1
"""Share of the squares of a force whose signs are reidentified that the axis may leave."""
_ROUNDS = 4
"""Fits in which the signs of a force settle."""
_COASTS = 0.1
"""Share of the samples of a motion in which the force is exactly 0: the drive is off, and no sign is lost."""


def wrong_sign(initial: Fit, reidentified: Fit, last: Fit, drive: int) -> str:
    """Sentence if the force of a drive is opposite to the predicted one, or is its absolute value; otherwise empty.

    `reidentified` is the axis fitted to the log, `last` the same with all effects that were reidentified.
    """
    state, weighting = initial.state, initial.weighting
    record = state.prediction.record
    force = record.forces[drive]
    both = weighting.rows(np.stack([record.measured, state.prediction.outputs]))
    measured, predicted = both[:, drive, weighting.kept]
    opposite = float(np.corrcoef(measured, predicted)[0, 1]) < _OPPOSITE
    best = min(reidentified, last, key=lambda fit: fit.mean_square)
    if opposite and _fits_mirrored(initial, best, force):
        return (
            f"{force} is opposite to the force that the motion needs: its sign or that of a position is wrong"
        )
    logged = record.log[force]
    seen, asked = (
        record.rows(spectrum * record.taper)[weighting.kept]
        for spectrum in (record.measured[drive], state.prediction.outputs[drive])
    )
    one_sided = logged.min() >= 0 or logged.max() <= 0
    at = np.rint(record.row_time[weighting.kept] / record.log.sampling_period).astype(int)
    coasts = np.mean(logged[np.minimum(at, logged.size - 1)] == 0.0) > _COASTS
    if (one_sided and not coasts) and (
        _is_absolute(seen, asked) or (not reidentified.nominal and _is_rectified(initial, best, drive))
    ):
        return (
            f"{force} never changes its sign, though the motion asks for both: an absolute value was recorded"
        )
    return ""


def _fits_mirrored(initial: Fit, best: Fit, force: str) -> bool:
    """Whether the axis fits the force of opposite sign far better than the best model fits the recorded one.

    A weight or spring that the axis lacks and that exceeds the inertia also makes a force against the acceleration.
    """
    fit = _with_force(initial, force, -initial.state.prediction.record.log[force])
    return fit.mean_square < _MIRRORED * best.mean_square


def _is_rectified(initial: Fit, best: Fit, drive: int) -> bool:
    """Whether the axis fits the force far better with signs that it determines itself than the best model without.

    Without initial values the recorded force has spoiled them. The signs are first those of the speed or of the
    acceleration, then those of the force that the fit predicts. A force beside a weight that the model lacks fits as
    well once a constant is taken off.
    """
    record = initial.state.prediction.record
    force, speed = record.forces[drive], record.fine(1j * record.omega * record.motions[drive])
    logged = record.log[force]
    plain = min(best.mean_square, _with_force(initial, force, logged - logged.mean()).mean_square)

    def signed(course: FloatArray) -> FloatArray:
        return np.asarray(np.abs(logged) * np.sign(np.interp(record.log.time, record.fine_time, course)))

    for course in (speed, np.gradient(speed)):
        values = signed(course)
        for _ in range(_ROUNDS):
            fit = _with_force(initial, force, values)
            values = signed(record.fine(fit.state.prediction.outputs[drive]))
        both = min(np.mean(values > 0), np.mean(values < 0)) > _BOTH_SIGNS
        whole = fit.weighting.projected(
            fit.weighting.rows(fit.state.prediction.record.measured), fit.state.beginning
        )
        explains = fit.cost < _LEFT * float(whole @ whole)
        if both and explains and fit.mean_square < _MIRRORED * plain:
            return True
    return False


def _with_force(initial: Fit, force: str, values: FloatArray) -> Fit:
    """The axis fitted to other values of a force."""
    record = initial.state.prediction.record
    log = replace(record.log, signals={**record.log.signals, force: values})
    return fitted(*first_state(replace(record, log=log), initial.parameters, initial.weighting.allowed))


def _is_absolute(seen: FloatArray, asked: FloatArray) -> bool:
    """Whether a record follows the absolute value of the predicted force rather than the force, each plus a constant.

    The predicted force must have both signs: a weight that the model lacks can keep a force on one side too. A constant
    force follows neither.
    """
    if min(float(np.mean(asked > 0)), float(np.mean(asked < 0))) < _BOTH_SIGNS:
        return False

    def left(course: FloatArray) -> float:
        base = np.stack([np.ones(asked.size), course], axis=1)
        return float(np.sum(unexplained_by(base, seen) ** 2))

    varies = float(np.sum((seen - seen.mean()) ** 2))
    return left(np.abs(asked)) < min(left(asked), (1 - _FOLLOWS) * varies)
