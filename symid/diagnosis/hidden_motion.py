"""Hidden motion under strong nonlinear laws: one step after the other, driven by the measured motion.

Where an effect bends or frees the spring of a hidden body, or holds it, its force depends on the motion that it makes,
and no iteration of frequency responses converges. The hidden equation of motion is then integrated: the linear part
exactly, inputs and forces as straight lines between the points of the fine grid (Heun's rule for the force). One
hidden coordinate is treated, which two bodies and a measured drive have.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
import scipy
import sympy as sp

from symid.arrays import ComplexArray, FloatArray
from symid.diagnosis.record import Record
from symid.simulation import Plant
from symid.simulation.postfix import Program, program

_POINTS_PER_ROW = 2
"""Of the integration: the band ends at a quarter of that rate."""
_NOTHING = 1e-9
"""Share of a change that rounding leaves in an equation in which it does not stand."""


@dataclass(frozen=True, eq=False)
class Pointwise:
    """A law point by point: the force that opposes a joint; of dry friction its level.

    The sign of dry friction follows from the motion, and it holds the joint where it can.

    Parameters
    ----------
    force : sympy expression
        In displacement q and velocity v of the joint, `_course`, Dahl's state `_z`, and `values`.
    values : mapping of str to float
        Numbers by their names in `force`.
    course : array of shape (n_fine,), optional
        A factor that follows the time, on the fine grid.
    reach : float, optional
        Displacement over which Dahl's state z(1) = (v - abs(v) z) / reach builds up.
    dry : bool
        Whether it is dry friction.
    """

    force: sp.Expr
    values: Mapping[str, float]
    course: FloatArray | None = None
    reach: float = math.inf
    dry: bool = False

    @property
    def program(self) -> Program:
        """The force as a program of q, v, course, z and the values in their order."""
        return _program(self.force, tuple(self.values))


@cache
def _program(force: sp.Expr, names: tuple[str, ...]) -> Program:
    return program(force, ("q", "v", "_course", "_z", *names))


@dataclass(frozen=True, eq=False)
class HiddenMotion:
    """The hidden coordinate of a plant whose driven position is measured.

    Parameters
    ----------
    free : array of shape (n_bodies,)
        Displacements of the bodies for a unit of the hidden coordinate.
    carried : array of shape (n_bodies,)
        Displacements for a unit of the driven position held at rest, so that the hidden coordinate is but a deflection.
    balance : array of shape (n_bodies,)
        Combination of the bodies' balances that the drive does not enter.
    """

    free: FloatArray
    carried: FloatArray
    balance: FloatArray


def hidden_motion(plant: Plant, driven: FloatArray) -> HiddenMotion:
    """The hidden coordinate for the row of the driven position; two bodies."""
    free = np.linalg.svd(driven[None])[2][-1]
    balance = np.linalg.svd(plant.drive[None])[2][-1]
    carried = driven / (driven @ driven)
    stiffness = balance @ plant.stiffness @ free
    if stiffness:
        carried = carried - free * (balance @ plant.stiffness @ carried) / stiffness
    return HiddenMotion(free, carried, balance)


def acts_on_hidden(plant: Plant, other: Plant, driven: FloatArray) -> bool:
    """Whether two plants differ in the equation of the hidden motion, and not in that of the drive alone."""
    balance = hidden_motion(plant, driven).balance
    kinds = ("mass", "damping", "stiffness", "constant")
    changes = [getattr(other, kind) - getattr(plant, kind) for kind in kinds]
    for law, moved in zip(plant.laws, other.laws, strict=True):
        by = (after - before for (before, _), (after, _) in zip(law.terms, moved.terms, strict=True))
        changes += [law.direction * change for change in by]
    return any(np.abs(balance @ change).max() > _NOTHING * np.abs(change).max() for change in changes)


def integrated_motion(
    record: Record,
    plant: Plant,
    known: ComplexArray,
    laws: Sequence[tuple[FloatArray, Pointwise]],
) -> tuple[ComplexArray, tuple[ComplexArray, ...]]:
    """Displacements of the bodies, and the forces of laws that act on hidden motion.

    Parameters
    ----------
    record : Record
        The log.
    plant : Plant
        The linear part of the axis: two bodies.
    known : array of shape (n_bins, 2)
        Spectra of other forces on the bodies.
    laws : sequence of (array, Pointwise)
        Direction of the joint and force of each law.

    Returns
    -------
    tuple
        Displacements of shape (2, n_bins) and the spectrum of each law's force.
    """
    driven = plant.sensors[record.signals[0]][0]
    hidden, s = hidden_motion(plant, driven), 1j * record.omega
    carried = np.stack([m @ hidden.carried for m in (plant.stiffness, plant.damping, plant.mass)])
    inertia = (
        np.tensordot(np.stack([np.ones_like(s), s, s**2]), carried, axes=(0, 0)) * record.motion[:, None]
    )
    n_points, stride = record.n_rows * _POINTS_PER_ROW, record.fine_per_row // _POINTS_PER_ROW
    pushed = record.grid((known - inertia) @ hidden.balance, n_points)
    mass, damping, stiffness = (
        float(hidden.balance @ m @ hidden.free) for m in (plant.mass, plant.damping, plant.stiffness)
    )
    q, v = record.grid(record.motion, n_points), record.grid(s * record.motion, n_points)
    joints = [
        (float(d @ hidden.carried), float(d @ hidden.free), float(hidden.balance @ d), law) for d, law in laws
    ]
    step = record.period / n_points
    z, forces = _periodic(
        (mass, damping, stiffness), pushed, q, v, joints, step, math.ceil(record.duration / step), stride
    )
    displacement = np.multiply.outer(hidden.carried, record.motion) + np.multiply.outer(
        hidden.free, record.from_grid(z)
    )
    return displacement, tuple(record.from_grid(f) for f in forces)


def _periodic(
    coefficients: tuple[float, float, float],
    pushed: FloatArray,
    q: FloatArray,
    v: FloatArray,
    joints: Sequence[tuple[float, float, float, Pointwise]],
    step: float,
    n_log: int,
    stride: int,
) -> tuple[FloatArray, list[FloatArray]]:
    """Hidden coordinate and forces on the fine grid; the way back from end to beginning is run twice, so that the
    course is periodic."""
    transition, first, second = _discretised(*coefficients, step)
    given = np.outer(first, pushed) + np.outer(second, np.roll(pushed, -1))
    order = np.concatenate([np.arange(n_log, q.size), np.arange(q.size)])
    states, courses = _stepped(transition, first + second, second, given, q, v, joints, order, stride)
    if not np.isfinite(states).all():
        raise OverflowError("the hidden motion grows without bound")
    back = q.size - n_log
    blend = np.linspace(0, 1, back)

    def closed(course: FloatArray) -> FloatArray:
        last = (1 - blend) * course[q.size :] + blend * course[:back]
        return np.concatenate([course[back : q.size], last])

    return closed(states), [closed(course) for course in courses]


def _stepped(
    transition: FloatArray,
    whole: FloatArray,
    second: FloatArray,
    given: FloatArray,
    q: FloatArray,
    v: FloatArray,
    joints: Sequence[tuple[float, float, float, Pointwise]],
    order: np.ndarray[tuple[int], np.dtype[np.int64]],
    stride: int,
) -> tuple[FloatArray, list[FloatArray]]:
    """States and forces in the order of the points, each `stride` points of the fine grid from the last."""
    from symid.diagnosis.hidden_steps import steps  # numba takes 0.3 s to import, and most axes need none

    carried, hidden, balance, laws = zip(*joints, strict=True)
    programs = [law.program for law in laws]
    arguments = np.zeros((len(laws), 4 + max(len(law.values) for law in laws)))
    courses = np.ones((len(laws), q.size))
    for i, law in enumerate(laws):
        arguments[i, 4 : 4 + len(law.values)] = list(law.values.values())
        if law.course is not None:
            courses[i] = law.course[::stride]
    states, forces = steps(
        transition,
        np.stack([whole, second]),
        given,
        np.multiply.outer(carried, q),
        np.multiply.outer(carried, v),
        courses,
        np.array([hidden, balance, [law.reach for law in laws]]),
        np.array([law.dry for law in laws]),
        np.concatenate([p.operations for p in programs]),
        np.concatenate([p.operands for p in programs]),
        np.cumsum([0, *(p.operations.size for p in programs)]),
        arguments,
        np.zeros(max(p.depth for p in programs)),
        order,
    )
    for force, law in zip(forces, laws, strict=True):
        if law.dry:
            force[:] = (force + np.append(force[1:], 0.0)) / 2
    return states, list(forces)


def _discretised(
    mass: float, damping: float, stiffness: float, step: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Transition over a step, and effects of a force at its beginning and at its end, straight in between."""
    system = np.zeros((4, 4))
    system[0, 1] = 1.0
    system[1] = [-stiffness / mass, -damping / mass, 1 / mass, 0.0]
    system[2, 3] = 1 / step
    whole = scipy.linalg.expm(system * step)
    held, ramp = whole[:2, 2], whole[:2, 3]
    return whole[:2, :2], held - ramp, ramp
