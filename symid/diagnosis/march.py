"""Hidden motion under strong nonlinear laws: one step after the other, driven by the measured motion.

Where an effect bends or frees the spring of a hidden body, or holds it, its force depends on the motion that it makes,
and no iteration of frequency responses converges. The hidden equation of motion is then integrated: the linear part
exactly, inputs and forces as straight lines between the points of the fine grid (Heun's rule for the force). One
hidden coordinate is treated, which two bodies and a measured drive have.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from symid.arrays import ComplexArray, FloatArray
from symid.diagnosis.record import Record
from symid.simulation import Plant

_POINTS_PER_ROW = 2
"""Of the integration: the band ends at a quarter of that rate."""


@dataclass(frozen=True, eq=False)
class Pointwise:
    """A law point by point.

    Parameters
    ----------
    force : callable
        For a point of the fine grid, displacement and velocity of the joint: the force that opposes it; of dry
        friction the level, whose sign the motion sets and which holds the joint where it can.
    dry : bool
        Whether it is dry friction.
    """

    force: Callable[[int, float, float], float]
    dry: bool = False


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


def marched(
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
    laws : sequence of (array, callable)
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
    z, forces = _integrated(
        (mass, damping, stiffness), pushed, q, v, joints, step, math.ceil(record.duration / step), stride
    )
    displacement = np.multiply.outer(hidden.carried, record.motion) + np.multiply.outer(
        hidden.free, record.from_grid(z)
    )
    return displacement, tuple(record.from_grid(f) for f in forces)


def _integrated(
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
    mass, damping, stiffness = coefficients
    transition, first, second = _discretised(mass, damping, stiffness, step)
    after = np.roll(pushed, -1)
    given = (np.outer(pushed, first) + np.outer(after, second)).T.tolist()
    moved = [((c * q).tolist(), (c * v).tolist(), h, w, law) for c, h, w, law in joints]
    order = [*range(n_log, q.size), *range(n_log), *range(n_log, q.size)]
    z, forces = np.zeros(q.size), [np.zeros(q.size) for _ in joints]
    try:
        place, states, pushes = _loop(transition, first + second, second, given, moved, order, stride)
    except ValueError as error:  # a sine of what has grown without bound
        raise OverflowError("the hidden motion grows without bound") from error
    back = q.size - n_log
    z[place[back : back + n_log]] = states[back : back + n_log]
    blend = np.linspace(0, 1, back)
    z[n_log:] = (1 - blend) * states[back + n_log :] + blend * states[:back]
    for force, course in zip(forces, pushes, strict=True):
        force[:n_log] = course[back : back + n_log]
        force[n_log:] = (1 - blend) * course[back + n_log :] + blend * course[:back]
    return z, forces


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


def _loop(
    transition: FloatArray,
    whole: FloatArray,
    second: FloatArray,
    given: list[list[float]],
    moved: Sequence[tuple[list[float], list[float], float, float, Pointwise]],
    order: Sequence[int],
    stride: int,
) -> tuple[list[int], FloatArray, list[FloatArray]]:
    """States and forces in the order of the points, each `stride` points of the fine grid from the last.

    Smooth forces by Heun's rule, dry friction held over each step.
    """
    (a00, a01), (a10, a11) = transition.tolist()
    (b0, b1), (c0, c1) = whole.tolist(), second.tolist()
    g0, g1 = given
    x = rate = force = 0.0
    last = order[0]
    states: list[float] = []
    pushes: list[list[float]] = [[] for _ in moved]
    smooth = [(*m[:4], m[4].force, p) for m, p in zip(moved, pushes, strict=True) if not m[4].dry]
    dry = [(*m[:4], m[4].force, p) for m, p in zip(moved, pushes, strict=True) if m[4].dry]
    for k in order:
        if states:
            x, rate = (
                a00 * x + a01 * rate + g0[last] - b0 * force,
                a10 * x + a11 * rate + g1[last] - b1 * force,
            )
        total = 0.0
        for qs, vs, h, w, law, pushed in smooth:
            own = law(k * stride, qs[k] + h * x, vs[k] + h * rate)
            pushed.append(own)
            total += w * own
        x -= c0 * (total - force)
        rate -= c1 * (total - force)
        for qs, vs, h, w, law, pushed in dry:
            speed = vs[k] + h * rate
            level = law(k * stride, qs[k] + h * x, speed)
            own = speed / (h * b1 * w)
            own = level if own > level else -level if own < -level else own
            pushed.append(own)
            x -= b0 * w * own
            rate -= b1 * w * own
        force, last = total, k
        states.append(x)
    courses = [np.array(course) for course in pushes]
    for i, m in enumerate(moved):
        if m[4].dry:
            courses[i] = (courses[i] + np.append(courses[i][1:], 0.0)) / 2
    return list(order), np.array(states), courses
