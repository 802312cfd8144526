"""Effects of friction with memory, load dependence or drift that may be missing from a model."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from itertools import product

import numpy as np

from symid.arrays import ComplexArray, FloatArray
from symid.axis import CoulombFriction as DeclaredCoulomb
from symid.axis import Law
from symid.axis import ViscousFriction as DeclaredViscous
from symid.data.lost_samples import step_of
from symid.diagnosis.effects.effect import JointEffect, MatchedFilter, Placed, Shape, joint_units, sampled
from symid.diagnosis.effects.from_law import HOLDING
from symid.diagnosis.effects.from_law import joints_with as _declared
from symid.diagnosis.prediction.hidden_motion import Pointwise
from symid.diagnosis.prediction.joint import Joint
from symid.diagnosis.prediction.prediction import Prediction
from symid.units import Unit

_DRIFTING = "_course * (amplitude * np.sign(v) + viscous * v)"
_REACHES = np.geomspace(2e-6, 6e-4, 10)
"""Reaches of presliding to try in a slide, m."""
_HIDDEN_REACHES = (0.03, 0.15)
"""Reaches of friction that holds a hidden joint, relative to its largest deflection, with which a fit may begin."""
_TURNED = np.geomspace(1e-5, 1e-2, 12)
"""Reaches to try in a turning joint, relative to its stroke: gears and bearings differ by more than slides do."""
_SAMPLES = 2.0
"""Least reach, in distances that a sample passes after a reversal: the instant at which the friction jumps
is known to a fraction of a sample."""
_ONE_WAY = 0.02
"""Share of the motion backward below which a joint moves one way only: its friction builds up once."""
_WARM_UPS = (0.08, 0.2, 0.5, 2.0)
_SLOWEST_WARM_UP = 3.0
"""Time constants of a drift, relative to the log: of slower ones the log shows the rate alone."""
_TOGETHER = 0.99
"""Correlation of the velocities of joints that move in proportion."""
_MOST_CHANGED = 3.0
"""Change of a declared friction by a drift within the log, relative to its level."""


class PreslidingFrictionEffect(JointEffect):
    """Coulomb friction that builds up over a displacement (Dahl): Fs z, z(1) = (v - abs(v) z) / reach.

    If Coulomb friction is declared, it replaces that friction: Fs (z - sign(v)).

    Parameters
    ----------
    of_found : bool
        Whether it replaces Coulomb friction that is not declared but was found.
    """

    name = "presliding_friction"
    imitates = ("coulomb_friction",)
    amplitudes = ("Fs",)
    shape_names = ("reach",)
    positive = True

    def __init__(self, *, of_found: bool = False) -> None:
        self.of_found = of_found

    def shapes(self, prediction: Prediction, place: str, matched_filter: MatchedFilter) -> Iterable[Shape]:
        slides = str(joint_units(prediction, place)[1]) == "m"
        reaches = _REACHES if slides else prediction.joints[place].stroke * _TURNED
        return [(float(x),) for x in reaches]

    def is_plausible(self, prediction: Prediction, placed: Placed) -> bool:
        """The samples and the steps of the encoder resolve the build-up of friction, in both directions."""
        joint, record = prediction.joints[placed.at], prediction.record
        moving = np.flatnonzero(joint.moving)
        forward = float(np.mean(joint.v[moving] > 0)) if moving.size else 0.0
        if not _ONE_WAY < forward < 1 - _ONE_WAY:
            return False
        begins = moving[1:][np.diff(np.sign(joint.v[moving])) != 0]
        ahead = max(1, round(record.log.sampling_period / record.fine_time[1]))
        begins = begins[begins + ahead < joint.q.size]
        if not begins.size:
            return False
        passed = np.abs(joint.q[begins + ahead] - joint.q[begins])
        step = step_of(record.log[record.driven[prediction.drive_of(joint)]])
        return placed.shape[0] > max(_SAMPLES * float(np.median(passed)), step)

    def forces(self, prediction: Prediction, joint: Joint, shape: Shape) -> ComplexArray:
        state = dahl_state(joint.q, shape[0])
        replaces = self.of_found or joint.name in _declared(prediction, DeclaredCoulomb)
        return sampled(prediction, state - np.sign(joint.v) if replaces else state, joint=joint)

    def strong(self, spring: Joint, stiffness: float) -> Iterable[tuple[Shape, tuple[float, ...]]]:
        largest = max(map(abs, spring.range))
        return [((x * largest,), (y * stiffness * largest,)) for x, y in product(_HIDDEN_REACHES, HOLDING)]

    def pointwise(self, prediction: Prediction, shape: Shape, amplitudes: tuple[float, ...]) -> Pointwise:
        return Pointwise("amplitude * _z", {"amplitude": amplitudes[0]}, reach=shape[0])

    def units(self, prediction: Prediction, place: str) -> tuple[str, ...]:
        force, length = joint_units(prediction, place)
        return str(force), str(length)


_PART = PreslidingFrictionEffect(of_found=True)


def is_part(item: Placed, whole: Placed) -> bool:
    """Whether an effect is presliding friction and the other one Coulomb friction in the same joint."""
    is_pair = item.effect.name == PreslidingFrictionEffect.name and whole.key == ("coulomb_friction", item.at)
    return is_pair and not (item.integrated or whole.integrated)


def with_parts(placed: Iterable[Placed]) -> tuple[Placed, ...]:
    """The same effects, with presliding friction replacing part of the Coulomb friction found in the same joint.

    The prediction is the same; the level of the Coulomb friction becomes the total one, as that of a declared law.
    """
    found = list(placed)
    for at, item in enumerate(found):
        for i, whole in enumerate(found[:at]):
            if is_part(item, whole):
                found[i] = replace(whole, amplitudes=(whole.amplitudes[0] + item.amplitudes[0],))
                found[at] = replace(item, effect=_PART)
    return tuple(found)


def dahl_state(q: FloatArray, reach: float) -> FloatArray:
    """State of Dahl's model for a series of displacements, from 0; exact for monotone motion between points.

    >>> dahl_state(np.array([0.0, 1.0, 2.0, 1.0]), 1.0).round(3).tolist()
    [0.0, 0.632, 0.865, -0.314]
    """
    if not q.size:
        return np.zeros(0)
    # Between two reversals, sign(v) z approaches 1 exponentially with the distance. The loop runs over the reversals
    # only, to carry the state on; the points between them follow in one array operation.
    path = np.diff(q, prepend=q[0])
    forward = path >= 0
    turns = np.flatnonzero(np.diff(forward.astype(np.int8), prepend=2))
    travelled = np.add.reduceat(np.abs(path), turns)
    beginnings, state = [], 0.0
    for ahead, decay in zip(forward[turns].tolist(), np.exp(-travelled / reach).tolist(), strict=True):
        beginnings.append(state)
        state = 1 - (1 - state) * decay if ahead else (1 + state) * decay - 1
    lengths = np.diff(turns, append=q.size)
    since = np.cumsum(np.abs(path))
    since -= np.repeat(since[turns] - np.abs(path)[turns], lengths)
    sides = np.where(forward, 1.0, -1.0)
    return np.asarray(sides * (1 - (1 - sides * np.repeat(beginnings, lengths)) * np.exp(-since / reach)))


_LARGEST_COEFFICIENT = 0.5
_COEFFICIENTS = (0.02, 0.06, 0.15, 0.35)  # initial coefficients in a hidden joint


class LoadDependentFrictionEffect(JointEffect):
    """mu abs(drive force) sign(v), with the modelled drive force, which contains this friction.

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

    def forces(self, prediction: Prediction, joint: Joint, shape: Shape) -> ComplexArray:
        drive = prediction.record.fine(prediction.outputs[prediction.drive_of(joint)])
        return sampled(prediction, np.abs(drive) * np.sign(joint.v), joint=joint)

    def strong(self, spring: Joint, stiffness: float) -> Iterable[tuple[Shape, tuple[float, ...]]]:
        return [((), (mu,)) for mu in _COEFFICIENTS]

    def pointwise(self, prediction: Prediction, shape: Shape, amplitudes: tuple[float, ...]) -> Pointwise:
        return Pointwise("amplitude * np.abs(_load)", {"amplitude": amplitudes[0]}, dry=True)

    def units(self, prediction: Prediction, place: str) -> tuple[str, ...]:
        return ("1",)


def declared_level(prediction: Prediction, place: str, kind: type[Law]) -> float:
    """Coefficient of the declared friction of a kind in a joint; 0 if none is declared."""
    laws = (
        law
        for law in prediction.axis.laws
        if isinstance(law, kind) and getattr(law.at, "name", None) == place
    )
    values = prediction.axis.with_known_values(prediction.parameters)
    return sum(abs(values[term.parameter]) for law in laws for term in law.terms())


def moving_along(prediction: Prediction, place: str) -> dict[str, float]:
    """Joints that move in proportion to one, including itself, with the factor of their friction there.

    For a motor and its load, whose motions differ by vibrations only, a log shows the sum of their dry frictions.
    """
    own, inside = prediction.joints[place], prediction.record.in_log
    return {
        name: joint.top_speed / own.top_speed
        for name, joint in prediction.joints.items()
        if joint is own or abs(np.corrcoef(joint.v[inside], own.v[inside])[0, 1]) > _TOGETHER
    }


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

    def forces(self, prediction: Prediction, joint: Joint, shape: Shape) -> ComplexArray:
        fading = self.course(prediction, shape)
        parts = [np.sign(joint.v)] * self.coulomb + [joint.v] * self.viscous
        return sampled(prediction, *(part * fading for part in parts), joint=joint)

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
