"""The effect of friction proportional to the force of the drive."""

from collections.abc import Iterable

import numpy as np

from symid.arrays import ComplexArray
from symid.diagnosis.effects.effect import JointEffect, Placed, Shape, sampled
from symid.diagnosis.prediction.drive_force import denoised_force
from symid.diagnosis.prediction.hidden_motion import Pointwise
from symid.diagnosis.prediction.joint import RecordedJoint
from symid.diagnosis.prediction.prediction import Prediction

_LARGEST_COEFFICIENT = 0.5
_COEFFICIENTS = (0.02, 0.06, 0.15, 0.35)  # initial coefficients in a hidden joint


class LoadDependentFrictionEffect(JointEffect):
    """mu abs(drive force) sign(v), with the modelled drive force, which contains this friction and changes of masses.

    Where the modelled force is mostly noise, the recorded one stands for it: the absolute value would rectify noise.

    With the recorded force as load, the effect would explain the record by itself: F = mu abs(F) sign(v) holds with
    mu = 1 wherever the force has the sign of the velocity. The implicit equation is solved by iteration, which
    converges for mu < 1 with a given motion; in hidden joints it is part of each integration step.
    """

    name = "load_dependent_friction"
    amplitudes = ("mu",)
    positive = True
    implicit = True

    def is_possible(self, prediction: Prediction, placed: Placed) -> bool:
        return 0 <= placed.amplitudes[0] < _LARGEST_COEFFICIENT

    def forces(self, prediction: Prediction, joint: RecordedJoint, shape: Shape) -> ComplexArray:
        k = prediction.drive_of(joint)
        drive = _force_per_unit(prediction, k) * denoised_force(prediction, k)
        load = prediction.record.resampled(np.abs(drive))
        return sampled(prediction, load * np.sign(joint.v), joint=joint)

    def strong_starts(
        self, spring: RecordedJoint, stiffness: float
    ) -> Iterable[tuple[Shape, tuple[float, ...]]]:
        return [((), (mu,)) for mu in _COEFFICIENTS]

    def pointwise(self, prediction: Prediction, shape: Shape, amplitudes: tuple[float, ...]) -> Pointwise:
        share = amplitudes[0] * _force_per_unit(prediction, 0)
        return Pointwise("amplitude * np.abs(_load)", {"amplitude": share}, dry=True)

    def units(self, prediction: Prediction, place: str) -> tuple[str, ...]:
        return ("1",)


def _force_per_unit(prediction: Prediction, drive: int) -> float:
    """Force of a drive per unit of its signal."""
    constant = prediction.axis.drives[drive].constant
    return {**prediction.axis.known_parameters, **prediction.parameters}[constant] if constant else 1.0
