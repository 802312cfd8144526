"""The effect of friction that builds up over a displacement."""

from collections.abc import Iterable
from dataclasses import replace
from itertools import product

import numpy as np

from symid.arrays import ComplexArray, FloatArray
from symid.axis import CoulombFriction as DeclaredCoulomb
from symid.data.quality import step_of
from symid.diagnosis.effects.effect import JointEffect, MatchedFilter, Placed, Shape, joint_units, sampled
from symid.diagnosis.effects.from_law import HOLDING, joints_with as _declared
from symid.diagnosis.prediction.hidden_motion import Pointwise
from symid.diagnosis.prediction.joint import RecordedJoint
from symid.diagnosis.prediction.prediction import Prediction

_REACHES = np.array([2e-6, 6e-4])
"""Least and largest reach of presliding to try in a slide, m."""
_OF_STROKE = np.array([0.003, 0.3])
"""The same where they are smaller relative to the stroke, as in a structure that a spring holds."""
_HIDDEN_REACHES = (0.03, 0.15)
"""Reaches of friction that holds a hidden joint, relative to its largest deflection, with which a fit may begin."""
_TURNED = np.geomspace(1e-5, 1e-2, 12)
"""Reaches to try in a turning joint, relative to its stroke: gears and bearings differ by more than slides do."""
_SAMPLES = 2.0
"""Least reach above a step of the encoder, in distances that a sample passes after a reversal: the instant at which the
friction jumps is known to a fraction of a sample, the position at it to a step."""
_ONE_WAY = 0.02
"""Share of the motion backward below which a joint moves one way only: its friction builds up once."""


class PreslidingFrictionEffect(JointEffect):
    """Coulomb friction that builds up over a displacement (Dahl): Fs z, z(1) = (v - abs(v) z) / reach.

    If Coulomb friction is declared, it replaces that friction: Fs (z - sign(v)).

    Parameters
    ----------
    of_found : bool
        Whether it replaces Coulomb friction that is not declared but was found.
    """

    name = "presliding_friction"
    refines = ("coulomb_friction",)
    amplitudes = ("Fs",)
    shape_names = ("reach",)
    positive = True

    def __init__(self, *, of_found: bool = False) -> None:
        self.of_found = of_found

    def shapes(self, prediction: Prediction, place: str, matched_filter: MatchedFilter) -> Iterable[Shape]:
        stroke, slides = prediction.joints[place].stroke, str(joint_units(prediction, place)[1]) == "m"
        least, most = np.minimum(_REACHES, stroke * _OF_STROKE)
        reaches = np.geomspace(least, most, 10) if slides else stroke * _TURNED
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
        driven = record.log[record.driven[prediction.drive_of(joint)]]
        step = step_of(driven) * joint.stroke / float(np.ptp(driven))  # as the joint passes it, behind a gear
        return placed.shape[0] > _SAMPLES * float(np.median(passed)) + step

    def forces(self, prediction: Prediction, joint: RecordedJoint, shape: Shape) -> ComplexArray:
        state = dahl_state(joint.q, shape[0])
        replaces = self.of_found or joint.name in _declared(prediction, DeclaredCoulomb)
        return sampled(prediction, state - np.sign(joint.v) if replaces else state, joint=joint)

    def strong_starts(
        self, spring: RecordedJoint, stiffness: float
    ) -> Iterable[tuple[Shape, tuple[float, ...]]]:
        largest = max(map(abs, spring.range))
        return [((x * largest,), (y * stiffness * largest,)) for x, y in product(_HIDDEN_REACHES, HOLDING)]

    def pointwise(self, prediction: Prediction, shape: Shape, amplitudes: tuple[float, ...]) -> Pointwise:
        return Pointwise("amplitude * _z", {"amplitude": amplitudes[0]}, reach=shape[0])

    def units(self, prediction: Prediction, place: str) -> tuple[str, ...]:
        force, length = joint_units(prediction, place)
        return str(force), str(length)


_PART = PreslidingFrictionEffect(of_found=True)


def is_presliding_part(item: Placed, whole: Placed) -> bool:
    """Whether an effect is presliding friction and the other one Coulomb friction in the same joint."""
    is_pair = item.effect.name == PreslidingFrictionEffect.name and whole.key == ("coulomb_friction", item.at)
    return is_pair and not (item.integrated or whole.integrated)


def with_presliding_parts(placed: Iterable[Placed]) -> tuple[Placed, ...]:
    """The same effects, with presliding friction replacing part of the Coulomb friction found in the same joint.

    The prediction is the same; the level of the Coulomb friction becomes the total one, as that of a declared law.
    """
    found = list(placed)
    for at, item in enumerate(found):
        for i, whole in enumerate(found[:at]):
            if is_presliding_part(item, whole):
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
