"""The linear equation of motion of a hidden coordinate, discretised exactly, and a mass that changes at a moment."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import scipy

from symid.arrays import ComplexArray, FloatArray, IntArray, read_only
from symid.diagnosis.prediction.record import Record
from symid.simulation import Plant

_KEPT = 64
"""Number of cached directions and discretised equations, which derivatives by values of laws share."""


@dataclass(frozen=True, eq=False)
class HiddenMotion:
    """The hidden coordinate of a plant whose driven position is measured."""

    free: FloatArray  # shape (n_bodies,): displacements of the bodies for a unit of the hidden coordinate
    # shape (n_bodies,): static displacements for a unit of the driven position, so that the hidden coordinate is a
    # pure deflection
    static: FloatArray
    # shape (n_bodies,): combination of the equations of motion without the drive force
    balance: FloatArray


def hidden_motion(plant: Plant, driven: FloatArray) -> HiddenMotion:
    """The hidden coordinate of two bodies; `driven` is the sensor row of the driven position."""
    free, balance = _orthogonal_to(tuple(driven)), _orthogonal_to(tuple(plant.drive))
    static = driven / (driven @ driven)
    stiffness = balance @ plant.stiffness @ free
    if stiffness:
        static = static - free * (balance @ plant.stiffness @ static) / stiffness
    return HiddenMotion(free, static, balance)


@lru_cache(maxsize=_KEPT)
def _orthogonal_to(row: tuple[float, ...]) -> FloatArray:
    """Unit vector orthogonal to a row of two entries."""
    return read_only(np.linalg.svd(np.array([row]))[2][-1])


@dataclass(frozen=True, eq=False)
class Phase:
    """Known forces and coefficients of the hidden coordinate before or after a change of a mass."""

    mass: float
    known_force: FloatArray  # shape (n_fine,): force on the hidden coordinate without that of laws
    row: FloatArray  # shape (n_bodies,): combination of the equations, see `_drive_balance`
    by_state: FloatArray
    load: FloatArray  # shape (n_fine,): drive force without the parts of the hidden coordinate and of laws


def phase_of(
    record: Record,
    plant: Plant,
    acting: ComplexArray,
    hidden: HiddenMotion,
    driven: FloatArray,
    *,
    loaded: bool,
) -> Phase:
    """The courses of a plant under `driven` motion, (3, n_fine); the drive force only where it is `loaded`."""

    def balanced(row: FloatArray) -> FloatArray:
        """Course of a combination of the equations: forces less those of the motion without the hidden one."""
        force, matrices = acting @ row, (plant.stiffness, plant.damping, plant.mass)
        of_motion = [row @ m @ hidden.static for m in matrices] @ driven
        return np.asarray(record.fine(force) - of_motion if force.any() else -of_motion)

    row, by_state = _drive_balance(plant, hidden)
    known_force = balanced(hidden.balance)
    load = -balanced(row) if loaded else np.zeros_like(known_force)
    return Phase(float(hidden.balance @ plant.mass @ hidden.free), known_force, row, by_state, load)


def by_phase(courses: Sequence[FloatArray], phase: IntArray) -> FloatArray:
    """At each point the course of its phase, shape (n_fine,)."""
    return courses[0] if len(courses) == 1 else np.choose(phase, courses)


def _drive_balance(plant: Plant, hidden: HiddenMotion) -> tuple[FloatArray, FloatArray]:
    """Combination of the equations of motion with drive force 1 and without the hidden acceleration.

    Returns a row over the bodies, and the shares of the hidden coordinate and its rate in the drive force.
    """
    body = int(np.argmax(np.abs(plant.drive)))
    row = np.eye(len(plant.bodies))[body]
    row = row - hidden.balance * (row @ plant.mass @ hidden.free) / (
        hidden.balance @ plant.mass @ hidden.free
    )
    row = row / plant.drive[body]
    return row, np.array([row @ plant.stiffness @ hidden.free, row @ plant.damping @ hidden.free])


class Equation(NamedTuple):
    """Exact step of the hidden coordinate and its rate: transition, responses to falling, rising and held forces.

    Each array has one entry for each phase: before a change of a mass, in the step of the change, and after it.
    """

    transition: FloatArray  # shape (n_phases, 2, 2)
    falling: FloatArray  # shape (n_phases, 2): of a force that falls from 1 to 0
    rising: FloatArray
    held: FloatArray


@dataclass(frozen=True, eq=False)
class MassChange:
    """A body that is heavier from a moment on; its speed and the forces on it do not jump."""

    body: FloatArray  # shape (n_bodies,): 1 for the body
    mass: float  # kg or kg m^2 more
    gravity: float  # acceleration by which the body weighs against its positive direction, m/s^2
    moment: float  # s

    @property
    def key(self) -> tuple[object, ...]:
        """The values that the motion depends on, to be compared."""
        return self.body.tobytes(), self.mass, self.gravity, self.moment

    def after(self, plant: Plant, acting: ComplexArray, extended: int) -> tuple[Plant, ComplexArray]:
        """The plant after the change and the forces on it; `extended` is the spectrum of 1 at zero frequency."""
        forces = acting.copy()
        forces[0] -= self.mass * self.gravity * extended * self.body
        return replace(plant, mass=plant.mass + self.mass * np.outer(self.body, self.body)), forces

    def phases(self, step: float, n: int) -> tuple[IntArray, float]:
        """Phase (0, 1 or 2) of the step that ends at each of `n` points, and share of step 1 after the change."""
        at = min(max(math.ceil(self.moment / step), 1), n - 1)
        phase = np.zeros(n, dtype=np.intp)
        phase[at:], phase[at + 1 :] = 1, 2
        return phase, min(max(at - self.moment / step, 0.0), 1.0)


def equation_of(masses: Sequence[float], damping: float, stiffness: float, step: float) -> Equation:
    """The discretised equation for each of some masses.

    Raises
    ------
    OverflowError
        If the motion grows without bound.
    """
    phases = [_discretised(mass, damping, stiffness, step) for mass in masses]
    return Equation(*(np.stack(own) for own in zip(*phases, strict=True)))


def in_the_step(share: float, before: float, after: float) -> tuple[float, float]:
    """Mass in the step of its change, whose inverse is the mean over the step, and the part of it after the change.

    A force is divided between the forces before and after in proportion to their accelerations.

    >>> in_the_step(0.5, 1.0, 2.0)
    (1.3333333333333333, 0.3333333333333333)
    """
    inverse = (1 - share) / before + share / after
    return 1 / inverse, share / after / inverse


@lru_cache(maxsize=_KEPT)
def _discretised(
    mass: float, damping: float, stiffness: float, step: float
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Transition, and responses to falling, rising and held forces, over a step."""
    system = np.zeros((4, 4))
    system[0, 1] = 1.0
    system[1] = [-stiffness / mass, -damping / mass, 1 / mass, 0.0]
    system[2, 3] = 1 / step
    with np.errstate(over="ignore", invalid="ignore"):
        whole = scipy.linalg.expm(system * step)
    if not np.isfinite(whole).all():
        raise OverflowError("the hidden motion grows without bound")
    held, ramp = whole[:2, 2], whole[:2, 3]
    return whole[:2, :2], held - ramp, ramp, held
