"""Time integration of hidden motion under strong nonlinear laws, driven by the measured motion.

An effect that stiffens or frees the spring of a hidden body, or holds the body, has a force that depends on the motion
it causes, and no iteration of frequency responses converges. The hidden equation of motion is then integrated in time:
its linear part exactly, with inputs and forces interpolated linearly between the points of the fine grid (Heun's rule
for the force). There is one hidden coordinate: that of two bodies of which the driven one is measured.

Friction that falls with the speed or holds a body at times, and play in which a body rattles, make motion that depends
on its beginning for ever: two runs of the machine itself would differ. Such motion is not predicted but observed: the
spring's deflection is drawn to the one that the measured drive force shows, and the laws act there. The outputs are the
linear response to their forces, so that the force explains nothing by itself.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Any, NamedTuple

import numpy as np
import scipy

from symid.arrays import BoolArray, ComplexArray, FloatArray, read_only
from symid.diagnosis.prediction.record import Record
from symid.simulation import Plant
from symid.simulation.postfix import Program, program

ARGUMENTS = ("q", "v", "_course", "_z", "_load")
"""First arguments of the programs of laws, written at each step; the values of the law follow."""
_MOST_ROUNDS = 8
"""Most rounds in which the level of dry friction and the speed in a step settle."""
_KEPT = 64
"""Number of cached directions and discretised equations, which derivatives by values of laws share."""
_OBSERVER_RATE, _OBSERVED_BAND, _LARGEST_CORRECTION = 0.3, 4.0, 0.3
"""Rate at which an error of the observed deflection decays, and band of the force that it follows, in multiples of the
natural frequency of the hidden body; largest share of the error that a step corrects. Stick-slip with a negative
damping of 15 % is followed from a rate of 0.2 on; a faster one follows noise (drawn worldly cases)."""
_NOTHING = 1e-9
"""Relative change of an equation below which it is rounding."""


@dataclass(frozen=True, eq=False)
class Pointwise:
    """A law point by point: the force that opposes the motion of a joint, or the level of dry friction.

    The integration determines the sign of dry friction, and whether it holds the joint.
    """

    # NumPy code in displacement q and velocity v of the joint, `_course`, Dahl's state `_z`, drive force `_load`
    # and `values`
    force: str
    values: Mapping[str, float]  # numbers by their names in `force`
    course: FloatArray | None = None  # shape (n_fine,): a factor as a function of time, on the fine grid
    reach: float = math.inf  # displacement over which Dahl's state z(1) = (v - abs(v) z) / reach builds up
    dry: bool = False  # whether it is dry friction

    @property
    def key(self) -> tuple[object, ...]:
        """What the force depends on, to be compared."""
        course = None if self.course is None else self.course.tobytes()
        return self.force, tuple(self.values.items()), course, self.reach, self.dry

    @property
    def program(self) -> Program:
        """The force as a program of `ARGUMENTS` and the values in their order."""
        return _program(self.force, tuple(self.values))


@cache
def _program(force: str, names: tuple[str, ...]) -> Program:
    return program(force, (*ARGUMENTS, *names))


@dataclass(frozen=True, eq=False)
class HiddenMotion:
    """The hidden coordinate of a plant whose driven position is measured."""

    free: FloatArray  # shape (n_bodies,): displacements of the bodies for a unit of the hidden coordinate
    # shape (n_bodies,): static displacements for a unit of the driven position, so that the hidden coordinate is a
    # pure deflection
    carried: FloatArray
    # shape (n_bodies,): combination of the equations of motion without the drive force
    balance: FloatArray


def hidden_motion(plant: Plant, driven: FloatArray) -> HiddenMotion:
    """The hidden coordinate of two bodies; `driven` is the sensor row of the driven position."""
    free, balance = _orthogonal_to(tuple(driven)), _orthogonal_to(tuple(plant.drive))
    carried = driven / (driven @ driven)
    stiffness = balance @ plant.stiffness @ free
    if stiffness:
        carried = carried - free * (balance @ plant.stiffness @ carried) / stiffness
    return HiddenMotion(free, carried, balance)


@lru_cache(maxsize=_KEPT)
def _orthogonal_to(row: tuple[float, ...]) -> FloatArray:
    """Unit vector orthogonal to a row of two entries."""
    return read_only(np.linalg.svd(np.array([row]))[2][-1])


def acts_on_hidden(plant: Plant, other: Plant, driven: FloatArray) -> bool:
    """Whether two plants differ in the equation of the hidden motion, not only in that of the drive."""
    balance = hidden_motion(plant, driven).balance
    kinds = ("mass", "damping", "stiffness", "constant")
    changes = [getattr(other, kind) - getattr(plant, kind) for kind in kinds]
    for law, moved in zip(plant.laws, other.laws, strict=True):
        by = (b.parameter - a.parameter for a, b in zip(law.terms, moved.terms, strict=True))
        changes += [law.direction * change for change in by]
    return any(np.abs(balance @ change).max() > _NOTHING * np.abs(change).max() for change in changes)


def integrated_motion(
    record: Record,
    plant: Plant,
    acting: ComplexArray,
    laws: Sequence[tuple[FloatArray, Pointwise]],
    *,
    follows: bool = False,
) -> tuple[ComplexArray, ComplexArray, tuple[ComplexArray, ...]]:
    """Spectra of the displacements of two bodies as predicted and observed, (2, n_bins), and of the force of each law.

    `acting` are other forces on the bodies, (n_bins, 2). Each law comes with the direction of its joint. Motion that
    `follows` the measured force is observed, other motion is the predicted one.
    """
    # The measured position fixes one combination of the two bodies; one coordinate is left. The measured motion enters
    # its equation as a known input, linear in courses that all models share: only this coordinate is integrated.
    hidden = hidden_motion(plant, plant.sensors[record.signals[0]][0])
    row, by_state = _drive_balance(plant, hidden)

    def balanced(row: FloatArray) -> FloatArray:
        """Course of a combination of the equations: forces less those of the motion without the hidden one."""
        force, matrices = acting @ row, (plant.stiffness, plant.damping, plant.mass)
        of_motion = [row @ m @ hidden.carried for m in matrices] @ record.driven_courses
        return np.asarray(record.fine(force) - of_motion if force.any() else -of_motion)

    pushed = balanced(hidden.balance)
    loaded = follows or any(law.program.asks_for(ARGUMENTS.index("_load")) for _, law in laws)
    load = -balanced(row) if loaded else np.zeros_like(pushed)
    mass, damping, stiffness = (
        float(hidden.balance @ m @ hidden.free) for m in (plant.mass, plant.damping, plant.stiffness)
    )
    step, (q, v, _) = record.period / record.n_fine, record.driven_courses
    natural = math.sqrt(abs(stiffness / mass)) if follows else 0.0
    rest, gain = _observer(record, load, natural, float(by_state[0]), step)
    equation = _discretised(mass, damping, stiffness, step)
    driven = _Driven(pushed, load, by_state, q, v, rest, gain)
    joints = np.array([(d @ hidden.carried, d @ hidden.free, hidden.balance @ d, row @ d) for d, _ in laws])
    acting_laws, n_log = [law for _, law in laws], math.ceil(record.duration / step)
    # Forces on the driven body alone change none of this: the motion is the last one.
    given = mass, damping, stiffness, *(x.tobytes() for x in (pushed, load, by_state, gain, joints))
    spectra = record.memory.of(
        "hidden motion",
        (*given, *(law.key for law in acting_laws)),
        lambda: record.from_grid(_periodic(equation, driven, joints, acting_laws, n_log)),
    )
    moved = [
        hidden.carried[:, None] * record.motion + hidden.free[:, None] * x for x in spectra[: -len(laws)]
    ]
    return moved[0], moved[-1], tuple(spectra[-len(laws) :])


def _observer(
    record: Record, load: FloatArray, natural: float, elastic: float, step: float
) -> tuple[FloatArray, FloatArray]:
    """Measured drive force less `load`, and the correction of the hidden coordinate for a unit that is left of it.

    `natural` is the natural frequency, rad/s, 0 where motion is not observed; `elastic` is the drive force for a unit
    of the coordinate. While the axis rests, its friction may be anything, and nothing is corrected.
    """
    if not (natural and elastic):
        return np.zeros_like(load), np.zeros_like(load)
    weight = 1 / (1 + (record.omega / (_OBSERVED_BAND * natural)) ** 4)
    rest = record.fine((record.measured[0] - record.from_grid(load)) * weight)
    share = min(_OBSERVER_RATE * natural * step, _LARGEST_CORRECTION)
    return rest, np.where(record.moves(record.speeds[0]) & record.in_log, share / elastic, 0.0)


class _Equation(NamedTuple):
    """Exact step of the hidden coordinate and its rate: transition, responses to falling, rising and held forces."""

    transition: FloatArray  # shape (2, 2)
    falling: FloatArray  # shape (2,): of a force that falls from 1 to 0
    rising: FloatArray
    held: FloatArray


class _Driven(NamedTuple):
    """Motion and forces that the measured motion determines, on the fine grid, each (n_fine,)."""

    pushed: FloatArray  # force on the hidden coordinate without that of laws
    load: FloatArray  # drive force without what the hidden coordinate and laws add
    by_state: FloatArray  # shape (2,): shares of the hidden coordinate and its rate in the drive force
    q: FloatArray  # driven position
    v: FloatArray  # its velocity
    rest: FloatArray  # measured drive force less `load`
    gain: FloatArray  # correction of the hidden coordinate for a unit of force that is left


class _JointLaws(NamedTuple):
    """Laws in joints, each (n_laws,) unless stated, and their concatenated programs."""

    by_driven: FloatArray  # displacement of the joint for a unit of the driven position
    by_hidden: FloatArray  # displacement for a unit of the hidden coordinate
    on_hidden: FloatArray  # share of the force in that on the hidden coordinate
    on_drive: FloatArray  # share in the drive force
    reach: FloatArray  # of Dahl's state
    dry: BoolArray
    # most rounds in which its level and the speed in a step settle: one for a level that has no speed in it
    rounds: np.ndarray[Any, np.dtype[np.int64]]
    courses: FloatArray  # shape (n_laws, n_fine): factors as functions of time
    operations: np.ndarray[Any, np.dtype[np.int64]]
    operands: FloatArray
    ends: np.ndarray[Any, np.dtype[np.int64]]
    arguments: FloatArray  # shape (n_laws, 5 + n_values): the first five are written by the steps
    stack: FloatArray  # space for the programs


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


def _periodic(
    equation: _Equation, driven: _Driven, joints: FloatArray, laws: Sequence[Pointwise], n_log: int
) -> FloatArray:
    """Hidden coordinate as predicted, as observed where it is, and the force of each law, as periodic courses."""
    # A log begins at rest or in an unknown state, for which the rows allow: the deflection begins at 0. On the way back
    # from the end of the log to its beginning courses return to their first values, which closes the period.
    predicted, observed, forces = _stepped(equation, driven, joints, laws)
    if not np.isfinite(predicted).all():
        raise OverflowError("the hidden motion grows without bound")
    courses = np.stack([predicted, *([observed] if driven.gain.any() else []), *forces])
    back = 0.5 - 0.5 * np.cos(np.pi * np.linspace(0, 1, driven.q.size - n_log))
    courses[:, n_log:] += back * (courses[:, :1] - courses[:, n_log:])
    return courses


def _stepped(
    equation: _Equation, driven: _Driven, joints: FloatArray, laws: Sequence[Pointwise]
) -> tuple[FloatArray, FloatArray, list[FloatArray]]:
    """The same on the fine grid, from rest on."""
    from symid.diagnosis.prediction.hidden_steps import (
        integrate_steps,  # numba takes 0.3 s, and most axes need none
    )

    programs, own = [law.program for law in laws], len(ARGUMENTS)
    arguments = np.zeros((len(laws), own + max(len(law.values) for law in laws)))
    courses = np.ones((len(laws), driven.q.size))
    for i, law in enumerate(laws):
        arguments[i, own : own + len(law.values)] = list(law.values.values())
        if law.course is not None:
            courses[i] = law.course
    by_driven, by_hidden, on_hidden, on_drive = joints.T.copy()
    in_joints = _JointLaws(
        by_driven,
        by_hidden,
        on_hidden,
        on_drive,
        np.array([law.reach for law in laws]),
        np.array([law.dry for law in laws]),
        np.array([_MOST_ROUNDS if p.asks_for(ARGUMENTS.index("v")) else 1 for p in programs]),
        courses,
        np.concatenate([p.operations for p in programs]),
        np.concatenate([p.operands for p in programs]),
        np.cumsum([0, *(p.operations.size for p in programs)]),
        arguments,
        np.zeros(max(p.depth for p in programs)),
    )
    predicted, observed, forces = integrate_steps(equation, driven, in_joints)
    for force, law in zip(forces, laws, strict=True):
        if law.dry:
            force[:] = (force + np.append(force[1:], 0.0)) / 2
    return predicted, observed, list(forces)


@lru_cache(maxsize=_KEPT)
def _discretised(mass: float, damping: float, stiffness: float, step: float) -> _Equation:
    system = np.zeros((4, 4))
    system[0, 1] = 1.0
    system[1] = [-stiffness / mass, -damping / mass, 1 / mass, 0.0]
    system[2, 3] = 1 / step
    with np.errstate(over="ignore", invalid="ignore"):
        whole = scipy.linalg.expm(system * step)
    if not np.isfinite(whole).all():
        raise OverflowError("the hidden motion grows without bound")
    held, ramp = whole[:2, 2], whole[:2, 3]
    return _Equation(whole[:2, :2], held - ramp, ramp, held)
