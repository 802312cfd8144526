"""Time integration of hidden motion under strong nonlinear laws, driven by the measured motion.

The force of a law that stiffens a hidden spring, leaves it play, or holds the body depends strongly on the motion that
it causes: an iteration of frequency responses would not converge. The equation of the hidden coordinate is integrated
in time instead: the linear part exactly, with inputs and forces interpolated linearly between the points of the fine
grid (Heun's rule for the force). There is one hidden coordinate, of two bodies of which the driven one is measured.

Stick-slip, and play in which a body rattles, never forget their initial state: two runs of the same machine would
differ. Such motion is observed instead of predicted. A Luenberger observer corrects the deflection of the spring by the
measured drive force, and the laws are evaluated there. The outputs are the linear response to the forces of the laws,
so that the measured force does not explain itself.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from symid.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from symid.diagnosis.prediction.hidden_equation import (
    Equation,
    MassChange,
    by_phase,
    equation_of,
    hidden_motion,
    in_the_step,
    phase_of,
)
from symid.diagnosis.prediction.record import Record
from symid.simulation import Plant
from symid.simulation.plants import Program, program

ARGUMENTS = ("q", "v", "_course", "_z", "_load")
"""First arguments of the programs of laws, written at each step; the values of the law follow."""
_MOST_ROUNDS = 8
"""Most rounds in which the level of dry friction and the speed in a step settle."""
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
        """The values that the force depends on, to be compared."""
        course = None if self.course is None else self.course.tobytes()
        return self.force, tuple(self.values.items()), course, self.reach, self.dry

    @property
    def program(self) -> Program:
        """The force as a program of `ARGUMENTS` and the values in their order."""
        return _program(self.force, tuple(self.values))


@dataclass(frozen=True, eq=False)
class IntegratedEffects:
    """Laws and effects with which hidden motion is integrated."""

    laws: Sequence[tuple[FloatArray, Pointwise]]  # each with the direction of its joint over the bodies
    mass_change: MassChange | None = None  # of a body
    follows: bool = False  # whether the motion is observed, and not predicted
    # shape (n_bins,) each: change of the drive force by other effects, and error of the driven position
    force_change: ComplexArray | None = None
    misread: ComplexArray | None = None


@cache
def _program(force: str, names: tuple[str, ...]) -> Program:
    return program(force, (*ARGUMENTS, *names))


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
    effects: IntegratedEffects,
) -> tuple[ComplexArray, ComplexArray, tuple[ComplexArray, ...]]:
    """Spectra of the displacements of two bodies as predicted and observed, (2, n_bins), and of the force of each law.

    `acting` are other forces on the bodies, (n_bins, 2).
    """
    laws, change, follows = effects.laws, effects.mass_change, effects.follows
    # The measured position fixes one combination of the two bodies; one coordinate is left. The measured motion enters
    # its equation as a known input, linear in courses that all models share: only this coordinate is integrated.
    step, motion, courses = record.period / record.n_fine, record.motion, record.driven_courses
    if effects.misread is not None:
        motion, courses = motion - effects.misread, courses - record.courses(effects.misread)
    q, v, _ = courses
    hidden = hidden_motion(plant, plant.sensors[record.signals[0]][0])
    loaded = follows or any(law.program.asks_for(ARGUMENTS.index("_load")) for _, law in laws)
    first = phase_of(record, plant, acting, hidden, courses, loaded=loaded)
    phases, phase = [first], np.zeros(record.n_fine, dtype=np.intp)
    if change is not None:
        heavier = change.after(plant, acting, record.n_extended)
        last = phase_of(record, *heavier, hidden, courses, loaded=loaded)
        phase, share = change.phases(step, record.n_fine)
        mass, part = in_the_step(share, first.mass, last.mass)
        known_force = (1 - part) * first.known_force + part * last.known_force
        phases += [replace(last, mass=mass, known_force=known_force), last]
    damping, stiffness = (float(hidden.balance @ m @ hidden.free) for m in (plant.damping, plant.stiffness))
    load, by_state = by_phase([own.load for own in phases], phase), np.stack([own.by_state for own in phases])
    if loaded and effects.force_change is not None:
        load = load + record.fine(effects.force_change)
    natural = math.sqrt(abs(stiffness / first.mass)) if follows else 0.0
    rest, gain = _observer(record, load, natural, float(first.by_state[0]), step)
    equation = equation_of([own.mass for own in phases], damping, stiffness, step)
    ends = by_phase([own.known_force for own in phases], phase)
    begins = by_phase([np.roll(own.known_force, 1) for own in phases], phase)
    driven = _Driven(phase, begins, ends, load, by_state, q, v, rest, gain)
    joints = np.array([(d @ hidden.static, d @ hidden.free, hidden.balance @ d) for d, _ in laws])
    on_drive = np.array([[own.row @ d for d, _ in laws] for own in phases])
    acting_laws, n_log = [law for _, law in laws], math.ceil(record.duration / step)
    # Forces on the driven body alone change none of this: the motion is the last one.
    arrays = (q, first.known_force, load, by_state, gain, joints, on_drive)
    given = first.mass, damping, stiffness, *(x.tobytes() for x in arrays), change and change.key
    spectra = record.memory.of(
        "hidden motion",
        (*given, *(law.key for law in acting_laws)),
        lambda: record.from_grid(_periodic(equation, driven, joints, on_drive, acting_laws, n_log)),
    )
    moved = [hidden.static[:, None] * motion + hidden.free[:, None] * x for x in spectra[: -len(laws)]]
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


class _Driven(NamedTuple):
    """Motion and forces that the measured motion determines, on the fine grid, each (n_fine,)."""

    phase: IntArray  # entry of the equation for the step that ends at each point
    begins: FloatArray  # force on the hidden coordinate without that of laws, at the beginning of the step
    ends: FloatArray  # at its end
    load: FloatArray  # drive force without the parts of the hidden coordinate and of laws
    # shape (n_phases, 2): shares of the hidden coordinate and its rate in the drive force
    by_state: FloatArray
    q: FloatArray  # driven position
    v: FloatArray  # its velocity
    rest: FloatArray  # measured drive force less `load`
    gain: FloatArray  # correction of the hidden coordinate for a unit of force that is left


class _JointLaws(NamedTuple):
    """Laws in joints, each (n_laws,) unless stated, and their concatenated programs."""

    by_driven: FloatArray  # displacement of the joint for a unit of the driven position
    by_hidden: FloatArray  # displacement for a unit of the hidden coordinate
    on_hidden: FloatArray  # share of the force in that on the hidden coordinate
    on_drive: FloatArray  # shape (n_phases, n_laws): share in the drive force
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


def _periodic(
    equation: Equation,
    driven: _Driven,
    joints: FloatArray,
    on_drive: FloatArray,
    laws: Sequence[Pointwise],
    n_log: int,
) -> FloatArray:
    """Hidden coordinate as predicted, as observed where it is, and the force of each law, as periodic courses."""
    # A log begins at rest or in an unknown state, for which the rows allow: the deflection begins at 0. On the way back
    # from the end of the log to its beginning courses return to their first values, which closes the period.
    predicted, observed, forces = _stepped(equation, driven, joints, on_drive, laws)
    if not np.isfinite(predicted).all():
        raise OverflowError("the hidden motion grows without bound")
    courses = np.stack([predicted, *([observed] if driven.gain.any() else []), *forces])
    back = 0.5 - 0.5 * np.cos(np.pi * np.linspace(0, 1, driven.q.size - n_log))
    courses[:, n_log:] += back * (courses[:, :1] - courses[:, n_log:])
    return courses


def _stepped(
    equation: Equation, driven: _Driven, joints: FloatArray, on_drive: FloatArray, laws: Sequence[Pointwise]
) -> tuple[FloatArray, FloatArray, list[FloatArray]]:
    """As `_periodic`, on the fine grid from rest on."""
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
    by_driven, by_hidden, on_hidden = joints.T.copy()
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
