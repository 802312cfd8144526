"""Friction that a model may lack."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from symid.arrays import ComplexArray, FloatArray
from symid.axis import CoulombFriction as DeclaredCoulomb
from symid.axis import ViscousFriction as DeclaredViscous
from symid.diagnosis.effects.base import JointEffect, Pull, Shape, joint_units, sampled
from symid.diagnosis.effects.from_law import joints_with as _declared
from symid.diagnosis.march import Pointwise
from symid.diagnosis.scene import Joint, Scene
from symid.units import Unit

_REACHES = np.geomspace(2e-6, 6e-4, 10)
_WARM_UPS = (0.08, 0.2, 0.5, 3.0)


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
        return sampled(scene, state - np.sign(joint.v) if declared else state)

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
    z, state = [], 0.0
    decays = np.exp(-np.abs(np.diff(q, prepend=q[0])) / reach).tolist()
    for forward, decay in zip((np.diff(q, prepend=q[0]) >= 0).tolist(), decays, strict=True):
        state = 1 - (1 - state) * decay if forward else (1 + state) * decay - 1
        z.append(state)
    return np.array(z)


class LoadDependentFriction(JointEffect):
    """mu abs(drive force) sign(v)."""

    name = "load_dependent_friction"
    amplitudes = ("mu",)
    positive = True

    def forces(self, scene: Scene, joint: Joint, shape: Shape) -> ComplexArray:
        drive = scene.record.fine(scene.record.measured[0])
        return sampled(scene, np.abs(drive) * np.sign(joint.v))

    def pointwise(self, scene: Scene, shape: Shape, amplitudes: tuple[float, ...]) -> Pointwise:
        (coefficient,) = amplitudes
        levels = np.abs(coefficient * scene.record.fine(scene.record.measured[0])).tolist()
        return Pointwise(lambda k, q, v: levels[k], dry=True)

    def units(self, scene: Scene, place: str) -> tuple[str, ...]:
        return ("1",)


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
        return (float(np.clip(shape[0], 0.02 * scene.record.duration, 20 * scene.record.duration)),)

    def forces(self, scene: Scene, joint: Joint, shape: Shape) -> ComplexArray:
        fading = _fading(scene, shape[0])
        parts = [np.sign(joint.v)] * self.coulomb + [joint.v] * self.viscous
        return sampled(scene, *(part * fading for part in parts))

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
