"""Friction that a model may lack."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Iterable

import numpy as np

from symid.arrays import ComplexArray, FloatArray
from symid.axis import CoulombFriction as DeclaredCoulomb
from symid.axis import OffsetForce as DeclaredOffset
from symid.axis import ViscousFriction as DeclaredViscous
from symid.diagnosis.effects.base import (
    JointEffect,
    LinearEffect,
    Placed,
    Pull,
    Shape,
    joint_units,
    sampled,
)
from symid.diagnosis.march import Pointwise
from symid.diagnosis.scene import Joint, Scene
from symid.units import Unit

_SPEEDS = np.geomspace(0.006, 0.6, 12)
_REACHES = np.geomspace(2e-6, 6e-4, 10)
_STROKES = np.geomspace(0.15, 2.0, 12)
_WARM_UPS = (0.08, 0.2, 0.5, 2.0)
_SLOWEST_WARM_UP = 3.0
"""Times of a drift relative to the log: slower ones show no course."""


def _declared(scene: Scene, kind: type) -> set[str]:
    return {law.at.name for law in scene.axis.laws if isinstance(law, kind) and hasattr(law.at, "name")}


class ViscousFriction(LinearEffect):
    """Fv v where the model has none."""

    name = "viscous_friction"
    amplitudes = ("Fv",)
    positive = True

    def places(self, scene: Scene) -> Iterable[str]:
        return [name for name in scene.joints if name not in _declared(scene, DeclaredViscous)]

    def stiffness(self, omega: FloatArray, shape: Shape) -> ComplexArray:
        return np.asarray(1j * omega)

    def units(self, scene: Scene, place: str) -> tuple[str, ...]:
        force, length = joint_units(scene, place)
        return (str(force * Unit.of("s") / length),)


class CoulombFriction(JointEffect):
    """Fs sign(v) where the model has none."""

    name = "coulomb_friction"
    amplitudes = ("Fs",)
    positive = True

    def places(self, scene: Scene) -> Iterable[str]:
        return [name for name in scene.joints if name not in _declared(scene, DeclaredCoulomb)]

    def forces(self, scene: Scene, joint: Joint, shape: Shape) -> ComplexArray:
        return sampled(scene, np.sign(joint.v), joint=joint)

    def pointwise(self, scene: Scene, shape: Shape, amplitudes: tuple[float, ...]) -> Pointwise:
        (level,) = amplitudes
        return Pointwise(lambda k, q, v: level, dry=True)

    def units(self, scene: Scene, place: str) -> tuple[str, ...]:
        return (str(joint_units(scene, place)[0]),)


class StribeckFriction(JointEffect):
    """dF sign(v) exp(-(v/vs)^2): friction is higher at low speed."""

    name = "stribeck_friction"
    amplitudes = ("dF",)
    shape_names = ("vs",)
    positive = True

    def shapes(self, scene: Scene, place: str, pull: Pull) -> Iterable[Shape]:
        return [(float(x * scene.joints[place].top_speed),) for x in _SPEEDS]

    def forces(self, scene: Scene, joint: Joint, shape: Shape) -> ComplexArray:
        return sampled(scene, np.sign(joint.v) * np.exp(-((joint.v / shape[0]) ** 2)), joint=joint)

    def pointwise(self, scene: Scene, shape: Shape, amplitudes: tuple[float, ...]) -> Pointwise:
        (level,), (speed,) = amplitudes, shape
        return Pointwise(lambda k, q, v: level * math.exp(-((v / speed) ** 2)), dry=True)

    def units(self, scene: Scene, place: str) -> tuple[str, ...]:
        force, length = joint_units(scene, place)
        return str(force), str(length / Unit.of("s"))


class AsymmetricFriction(JointEffect):
    """Half the difference of the Coulomb and viscous coefficients of both directions: dFs + dFv abs(v)."""

    name = "asymmetric_friction"
    amplitudes: tuple[str, ...] = ("dFs", "dFv")

    def places(self, scene: Scene) -> Iterable[str]:
        return [name for name in scene.joints if name not in _declared(scene, DeclaredOffset)]

    def forces(self, scene: Scene, joint: Joint, shape: Shape) -> ComplexArray:
        return sampled(scene, scene.record.in_log.astype(float), np.abs(joint.v))

    def pointwise(self, scene: Scene, shape: Shape, amplitudes: tuple[float, ...]) -> Pointwise:
        constant, viscous = amplitudes
        return Pointwise(lambda k, q, v: constant + viscous * abs(v))

    def units(self, scene: Scene, place: str) -> tuple[str, ...]:
        force, length = joint_units(scene, place)
        return str(force), str(force * Unit.of("s") / length)


class CoulombAsymmetry(AsymmetricFriction):
    """Half the difference of the Coulomb levels of both directions: while the axis moves, a constant force."""

    amplitudes: tuple[str, ...] = ("dFs",)

    def forces(self, scene: Scene, joint: Joint, shape: Shape) -> ComplexArray:
        return sampled(scene, scene.record.in_log.astype(float))

    def pointwise(self, scene: Scene, shape: Shape, amplitudes: tuple[float, ...]) -> Pointwise:
        (constant,) = amplitudes
        return Pointwise(lambda k, q, v: constant)

    def units(self, scene: Scene, place: str) -> tuple[str, ...]:
        return (str(joint_units(scene, place)[0]),)


class ViscousAsymmetry(AsymmetricFriction):
    """Half the difference of the viscous coefficients of both directions, where a constant force is declared."""

    amplitudes: tuple[str, ...] = ("dFv",)

    def places(self, scene: Scene) -> Iterable[str]:
        return [name for name in scene.joints if name in _declared(scene, DeclaredOffset)]

    def forces(self, scene: Scene, joint: Joint, shape: Shape) -> ComplexArray:
        return sampled(scene, np.abs(joint.v))

    def pointwise(self, scene: Scene, shape: Shape, amplitudes: tuple[float, ...]) -> Pointwise:
        (viscous,) = amplitudes
        return Pointwise(lambda k, q, v: viscous * abs(v))

    def units(self, scene: Scene, place: str) -> tuple[str, ...]:
        force, length = joint_units(scene, place)
        return (str(force * Unit.of("s") / length),)


class PreslidingFriction(JointEffect):
    """Coulomb friction that builds up over a displacement (Dahl): Fs z, z(1) = (v - abs(v) z) / reach.

    Where Coulomb friction is declared, it takes that away: Fs (z - sign(v)).
    """

    name = "presliding_friction"
    amplitudes = ("Fs",)
    shape_names = ("reach",)
    positive = True

    def shapes(self, scene: Scene, place: str, pull: Pull) -> Iterable[Shape]:
        return [(float(x),) for x in _REACHES]

    def forces(self, scene: Scene, joint: Joint, shape: Shape) -> ComplexArray:
        state = dahl_state(joint.q, shape[0])
        declared = joint.name in _declared(scene, DeclaredCoulomb)
        return sampled(scene, state - np.sign(joint.v) if declared else state, joint=joint)

    def pointwise(self, scene: Scene, shape: Shape, amplitudes: tuple[float, ...]) -> Pointwise:
        (level,), (reach,) = amplitudes, shape
        state, before = 0.0, 0.0

        def force(k: int, q: float, v: float) -> float:
            nonlocal state, before
            decay = math.exp(-abs(q - before) / reach)
            state = 1 - (1 - state) * decay if q >= before else (1 + state) * decay - 1
            before = q
            return level * state

        return Pointwise(force)

    def units(self, scene: Scene, place: str) -> tuple[str, ...]:
        force, length = joint_units(scene, place)
        return str(force), str(length)


def dahl_state(q: FloatArray, reach: float) -> FloatArray:
    """State of Dahl's model for a course of displacements, from 0; exact where the motion between points is monotone.

    Examples
    --------
    >>> dahl_state(np.array([0.0, 1.0, 2.0, 1.0]), 1.0).round(3).tolist()
    [0.0, 0.632, 0.865, -0.314]
    """
    if not q.size:
        return np.zeros(0)
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


class LoadDependentFriction(JointEffect):
    """mu abs(drive force) sign(v); the drive force is that of the model, which the same friction is part of.

    The record of the drive, taken for the load, would explain itself: F = mu abs(F) sign(v) with mu = 1 wherever the
    force follows the velocity. The balance is solved by iteration, which converges for mu < 1.
    """

    name = "load_dependent_friction"
    amplitudes = ("mu",)
    positive = True

    def is_possible(self, scene: Scene, amplitudes: tuple[float, ...]) -> bool:
        return 0 <= amplitudes[0] < _LARGEST_COEFFICIENT

    def forces(self, scene: Scene, joint: Joint, shape: Shape) -> ComplexArray:
        drive = scene.record.fine(scene.predicted[0])
        return sampled(scene, np.abs(drive) * np.sign(joint.v), joint=joint)

    def pointwise(self, scene: Scene, shape: Shape, amplitudes: tuple[float, ...]) -> Pointwise:
        (coefficient,) = amplitudes
        levels = np.abs(coefficient * scene.record.fine(scene.predicted[0])).tolist()
        return Pointwise(lambda k, q, v: levels[k], dry=True)

    def units(self, scene: Scene, place: str) -> tuple[str, ...]:
        return ("1",)


class _AlongStroke(JointEffect):
    """Coulomb friction whose level varies along the stroke, with a mean level of its own where none is declared."""

    name = "position_dependent_friction"

    def __init__(self, *, level: bool) -> None:
        self.level = level
        self.amplitudes = ("Fs",) * level + self.varying

    varying: tuple[str, str]

    def places(self, scene: Scene) -> Iterable[str]:
        declared = _declared(scene, DeclaredCoulomb)
        return [name for name in scene.joints if (name not in declared) == self.level]

    def forces(self, scene: Scene, joint: Joint, shape: Shape) -> ComplexArray:
        sign = np.sign(joint.v)
        return sampled(scene, *[sign] * self.level, *(sign * x for x in self.variation(joint, shape)), joint=joint)

    @abstractmethod
    def variation(self, joint: Joint, shape: Shape) -> tuple[FloatArray, FloatArray]:
        """Level along the stroke for unit amplitudes."""


class SlopedFriction(_AlongStroke):
    """sign(v) (dF1 q + dF2 q^2)."""

    varying = ("dF1", "dF2")

    def variation(self, joint: Joint, shape: Shape) -> tuple[FloatArray, FloatArray]:
        return joint.q, joint.q**2

    def units(self, scene: Scene, place: str) -> tuple[str, ...]:
        force, length = joint_units(scene, place)
        return (*[str(force)] * self.level, str(force / length), str(force / length**2))


class SlopedViscousFriction(JointEffect):
    """v (dFv1 q + dFv2 q^2), with sign(v) (dFs1 q + dFs2 q^2) if all friction varies along the stroke.

    Parameters
    ----------
    coulomb : bool
        Whether the level of declared Coulomb friction varies too.
    """

    name = "position_dependent_friction"

    def __init__(self, *, coulomb: bool) -> None:
        self.coulomb = coulomb
        self.amplitudes = ("dFs1", "dFs2") * coulomb + ("dFv1", "dFv2")

    def places(self, scene: Scene) -> Iterable[str]:
        viscous, level = _declared(scene, DeclaredViscous), _declared(scene, DeclaredCoulomb)
        return [name for name in scene.joints if name in viscous and (name in level or not self.coulomb)]

    def forces(self, scene: Scene, joint: Joint, shape: Shape) -> ComplexArray:
        parts = [np.sign(joint.v)] * self.coulomb + [joint.v]
        return sampled(scene, *(part * joint.q**power for part in parts for power in (1, 2)), joint=joint)

    def pointwise(self, scene: Scene, shape: Shape, amplitudes: tuple[float, ...]) -> Pointwise:
        level = amplitudes[:2] if self.coulomb else (0.0, 0.0)
        viscous = amplitudes[-2:]

        def force(k: int, q: float, v: float) -> float:
            return q * (math.copysign(1.0, v) * (level[0] + level[1] * q) + v * (viscous[0] + viscous[1] * q))

        return Pointwise(force)

    def units(self, scene: Scene, place: str) -> tuple[str, ...]:
        force, length = joint_units(scene, place)
        parts = [force] * self.coulomb + [force * Unit.of("s") / length]
        return tuple(str(unit / length**power) for unit in parts for power in (1, 2))


class WavyFriction(_AlongStroke):
    """sign(v) (dFs sin(2 pi q/p) + dFc cos(2 pi q/p))."""

    varying = ("dFs", "dFc")
    shape_names = ("pitch",)

    def shapes(self, scene: Scene, place: str, pull: Pull) -> Iterable[Shape]:
        return [(float(x * scene.joints[place].stroke),) for x in _STROKES]

    def bounded(self, scene: Scene, place: str, shape: Shape) -> Shape:
        return (float(np.clip(shape[0], 0.02 * scene.joints[place].stroke, 4 * scene.joints[place].stroke)),)

    def variation(self, joint: Joint, shape: Shape) -> tuple[FloatArray, FloatArray]:
        phase = 2 * math.pi / shape[0] * joint.q
        return np.sin(phase), np.cos(phase)

    def pointwise(self, scene: Scene, shape: Shape, amplitudes: tuple[float, ...]) -> Pointwise:
        sine, cosine = amplitudes[-2:]
        mean, wave = (amplitudes[0] if self.level else 0.0), 2 * math.pi / shape[0]
        return Pointwise(
            lambda k, q, v: max(mean + sine * math.sin(wave * q) + cosine * math.cos(wave * q), 0.0), dry=True
        )

    def units(self, scene: Scene, place: str) -> tuple[str, ...]:
        force, length = joint_units(scene, place)
        return (*[str(force)] * len(self.amplitudes), str(length))


class FrictionDrift(JointEffect):
    """exp(-t/T) (dFs sign(v) + dFv v): coefficients of declared friction change while the axis warms up.

    Parameters
    ----------
    coulomb, viscous : bool
        Which coefficients change.
    """

    name = "friction_drift"
    shape_names = ("T",)
    per_log = True

    def is_plausible(self, scene: Scene, placed: Placed) -> bool:
        return placed.shape[0] < 0.99 * _SLOWEST_WARM_UP * scene.record.duration

    def __init__(self, *, coulomb: bool, viscous: bool) -> None:
        self.coulomb, self.viscous = coulomb, viscous
        self.amplitudes = ("dFs",) * coulomb + ("dFv",) * viscous

    def places(self, scene: Scene) -> Iterable[str]:
        both = _declared(scene, DeclaredCoulomb), _declared(scene, DeclaredViscous)
        wanted = [names for names, changes in zip(both, (self.coulomb, self.viscous), strict=True) if changes]
        return [name for name in scene.joints if all(name in names for names in wanted)]

    def shapes(self, scene: Scene, place: str, pull: Pull) -> Iterable[Shape]:
        return [(x * scene.record.duration,) for x in _WARM_UPS]

    def bounded(self, scene: Scene, place: str, shape: Shape) -> Shape:
        return (float(np.clip(shape[0], 0.02 * scene.record.duration, _SLOWEST_WARM_UP * scene.record.duration)),)

    def forces(self, scene: Scene, joint: Joint, shape: Shape) -> ComplexArray:
        fading = _fading(scene, shape[0])
        parts = [np.sign(joint.v)] * self.coulomb + [joint.v] * self.viscous
        return sampled(scene, *(part * fading for part in parts), joint=joint)

    def pointwise(self, scene: Scene, shape: Shape, amplitudes: tuple[float, ...]) -> Pointwise:
        fading = _fading(scene, shape[0]).tolist()
        level = amplitudes[0] if self.coulomb else 0.0
        viscous = amplitudes[-1] if self.viscous else 0.0
        return Pointwise(lambda k, q, v: fading[k] * (math.copysign(1.0, v) * level + viscous * v))

    def units(self, scene: Scene, place: str) -> tuple[str, ...]:
        force, length = joint_units(scene, place)
        of_viscous = str(force * Unit.of("s") / length)
        return (*[str(force)] * self.coulomb, *[of_viscous] * self.viscous, "s")


def _fading(scene: Scene, time: float) -> FloatArray:
    """exp(-t/T) within the log."""
    return np.where(scene.record.in_log, np.exp(-scene.record.fine_time / time), 0.0)


class QuadraticDrag(JointEffect):
    """c v abs(v)."""

    name = "quadratic_drag"
    amplitudes = ("c",)
    positive = True

    def forces(self, scene: Scene, joint: Joint, shape: Shape) -> ComplexArray:
        return sampled(scene, joint.v * np.abs(joint.v))

    def pointwise(self, scene: Scene, shape: Shape, amplitudes: tuple[float, ...]) -> Pointwise:
        (coefficient,) = amplitudes
        return Pointwise(lambda k, q, v: coefficient * v * abs(v))

    def units(self, scene: Scene, place: str) -> tuple[str, ...]:
        force, length = joint_units(scene, place)
        return (str(force * Unit.of("s") ** 2 / length**2),)
