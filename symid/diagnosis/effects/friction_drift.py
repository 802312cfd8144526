"""Effects of friction that changes over a log."""

from collections.abc import Iterable

import numpy as np

from symid.arrays import ComplexArray, FloatArray
from symid.axis import CoulombFriction as DeclaredCoulomb, ViscousFriction as DeclaredViscous
from symid.diagnosis.effects.declared_friction import declared_level
from symid.diagnosis.effects.effect import JointEffect, MatchedFilter, Placed, Shape, joint_units, sampled
from symid.diagnosis.effects.from_law import joints_with as _declared
from symid.diagnosis.prediction.hidden_motion import Pointwise
from symid.diagnosis.prediction.joint import RecordedJoint
from symid.diagnosis.prediction.prediction import Prediction
from symid.units import Unit

_DRIFTING = "_course * (amplitude * np.sign(v) + viscous * v)"
_WARM_UPS = (0.08, 0.2, 0.5, 2.0)
_SLOWEST_WARM_UP = 3.0
"""Time constants of a drift, relative to the log: of slower ones the log shows the rate alone."""
_MOST_CHANGED = 3.0
"""Change of a declared friction by a drift within the log, relative to its level."""


class FrictionDriftEffect(JointEffect):
    """exp(-t/T) (dFs sign(v) + dFv v): coefficients of declared friction change while the axis warms up.

    Parameters
    ----------
    coulomb, viscous : bool
        Which coefficients change.
    """

    name = "friction_drift"
    shape_names: tuple[str, ...] = ("T",)
    per_log = True

    def __init__(self, *, coulomb: bool, viscous: bool) -> None:
        self.coulomb, self.viscous = coulomb, viscous
        self.amplitudes = ("dFs",) * coulomb + ("dFv",) * viscous

    def is_plausible(self, prediction: Prediction, placed: Placed) -> bool:
        """The log shows the curvature of the drift, which changes declared friction by a limited factor."""
        if placed.shape[0] > 0.99 * _SLOWEST_WARM_UP * prediction.record.duration:
            return False
        return self.is_moderate(prediction, placed, 1.0)

    def is_moderate(self, prediction: Prediction, placed: Placed, time: float) -> bool:
        """Whether amplitudes times `time` change declared friction, at the highest speed, by a limited factor."""
        top = prediction.joints[placed.at].top_speed
        kinds = ((DeclaredCoulomb, 1.0),) * self.coulomb + ((DeclaredViscous, top),) * self.viscous
        changed = sum(abs(c) * v for c, (_, v) in zip(placed.amplitudes, kinds, strict=True)) * time
        level = sum(declared_level(prediction, placed.at, kind) * v for kind, v in kinds)
        return changed < _MOST_CHANGED * level

    def places(self, prediction: Prediction) -> Iterable[str]:
        both = _declared(prediction, DeclaredCoulomb), _declared(prediction, DeclaredViscous)
        wanted = [names for names, changes in zip(both, (self.coulomb, self.viscous), strict=True) if changes]
        return [name for name in prediction.joints if all(name in names for names in wanted)]

    def shapes(self, prediction: Prediction, place: str, matched_filter: MatchedFilter) -> Iterable[Shape]:
        return [(x * prediction.record.duration,) for x in _WARM_UPS]

    def bounded(self, prediction: Prediction, place: str, shape: Shape) -> Shape:
        duration = prediction.record.duration
        return (float(np.clip(shape[0], 0.02 * duration, _SLOWEST_WARM_UP * duration)),)

    def course(self, prediction: Prediction, shape: Shape) -> FloatArray:
        """Factor of the change over time: exp(-t/T) within the log."""
        return np.where(prediction.record.in_log, np.exp(-prediction.record.fine_time / shape[0]), 0.0)

    def forces(self, prediction: Prediction, joint: RecordedJoint, shape: Shape) -> ComplexArray:
        return sampled(prediction, *self._parts(prediction, joint, shape), joint=joint)

    def force_over_time(self, prediction: Prediction, placed: Placed) -> FloatArray:
        """Change of the friction of its joint, on the fine grid."""
        parts = self._parts(prediction, prediction.joints[placed.at], placed.shape)
        return np.asarray(np.tensordot(placed.amplitudes, parts, 1))

    def _parts(self, prediction: Prediction, joint: RecordedJoint, shape: Shape) -> list[FloatArray]:
        """Forces of unit amplitudes."""
        fading = self.course(prediction, shape)
        kinds = [np.sign(joint.v)] * self.coulomb + [joint.v] * self.viscous
        return [np.asarray(kind * fading) for kind in kinds]

    def pointwise(self, prediction: Prediction, shape: Shape, amplitudes: tuple[float, ...]) -> Pointwise:
        values = {
            "amplitude": amplitudes[0] if self.coulomb else 0.0,
            "viscous": amplitudes[-1] if self.viscous else 0.0,
        }
        return Pointwise(_DRIFTING, values, self.course(prediction, shape))

    def units(self, prediction: Prediction, place: str) -> tuple[str, ...]:
        force, length = joint_units(prediction, place)
        of_viscous = str(force * Unit.of("s") / length)
        return (*[str(force)] * self.coulomb, *[of_viscous] * self.viscous, "s")


class SteadyFrictionDriftEffect(FrictionDriftEffect):
    """t (dFs/dt sign(v) + dFv/dt v): friction that changes linearly throughout the log.

    If the time constant of an exponential far exceeds the log, the log determines its rate, but neither time constant
    nor final value.
    """

    shape_names = ()

    def __init__(self, *, coulomb: bool, viscous: bool) -> None:
        super().__init__(coulomb=coulomb, viscous=viscous)
        self.amplitudes = tuple(f"{name}/dt" for name in self.amplitudes)

    def is_plausible(self, prediction: Prediction, placed: Placed) -> bool:
        """It changes declared friction by a limited factor within the log."""
        return self.is_moderate(prediction, placed, prediction.record.duration)

    def shapes(self, prediction: Prediction, place: str, matched_filter: MatchedFilter) -> Iterable[Shape]:
        return [()]

    def bounded(self, prediction: Prediction, place: str, shape: Shape) -> Shape:
        return shape

    def course(self, prediction: Prediction, shape: Shape) -> FloatArray:
        """Factor of the change over time: the time since the log began, s."""
        return np.where(prediction.record.in_log, prediction.record.fine_time, 0.0)

    def units(self, prediction: Prediction, place: str) -> tuple[str, ...]:
        *changes, time = super().units(prediction, place)
        return tuple(str(Unit.of(change) / Unit.of(time)) for change in changes)
