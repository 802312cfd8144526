"""Imperfections of an axis as expressions: in its drives, in time, with memory."""

from dataclasses import dataclass
from typing import NamedTuple

import sympy as sp

from symid.axis import (
    ActuatorDelay,
    Axis,
    CoulombFriction,
    Drive,
    DriveImperfection,
    Imperfection,
    Joint,
    JointImperfection,
    PayloadChange,
    PreslidingFriction,
    imperfections_in_order,
    joint_label,
    ripples_of,
)
from symid.symbolic import FORCE, MEMORY, TIME, imperfection_law, imperfection_rate, parameter_symbol

NOW = sp.Symbol("now_")
"""The time in expressions; no name of a parameter ends with an underscore."""


def acting(drive: Drive) -> sp.Symbol:
    """The force of a drive that acts, in expressions."""
    return sp.Symbol(f"force_{drive.signal}_")


@dataclass(frozen=True, eq=False)
class Memory:
    """State of an imperfection with memory: z(1) = gain - decay z, in the acting force, or in q and v of its joint."""

    name: str
    symbol: sp.Symbol  # the state in C
    gain: sp.Expr
    decay: sp.Expr

    @property
    def rate(self) -> sp.Expr:
        """Derivative of the state, z(1)."""
        return self.gain - self.decay * self.symbol


class JointForce(NamedTuple):
    """An imperfection in a joint: its force in terms of q, v, acting forces, `NOW` and the state of its memory."""

    at: Joint
    law: sp.Expr
    memory: Memory | None


class DrivePath(NamedTuple):
    """The chain from the force that a drive is sent to the one that acts."""

    drive: Drive
    elements: tuple[tuple[DriveImperfection, Memory | None], ...]  # in signal-flow order, with their states
    delay: float  # which follows them, s


@dataclass(frozen=True, eq=False)
class Imperfect:
    """The imperfections of an axis."""

    drives: tuple[DrivePath, ...]
    joints: tuple[JointForce, ...]  # those that act as forces in joints
    memories: tuple[Memory, ...]  # all states, in order
    changes: tuple[PayloadChange, ...]  # changes of masses over time
    clock: str  # C expression of the time, a state of the axis if anything depends on it; else empty

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states that the imperfections add."""
        return (*(memory.name for memory in self.memories), *(("t",) if self.clock else ()))


def imperfections_of(axis: Axis, first: int) -> Imperfect:
    """The imperfections of an axis as expressions; `first` is the index of the first memory in the state."""
    memories: list[Memory] = []

    def remembered(element: Imperfection, place: str, force: sp.Expr = FORCE) -> Memory | None:
        if not element.rate:
            return None
        rate = sp.expand(imperfection_rate(element).xreplace({FORCE: force}))
        decay, symbol = -rate.coeff(MEMORY), sp.Symbol(f"x[{first + len(memories)}]")
        memories.append(Memory(f"z_{place}", symbol, sp.expand(rate + decay * MEMORY), decay))
        return memories[-1]

    def force(element: JointImperfection) -> JointForce:
        law, memory = imperfection_law(element), remembered(element, joint_label(element.at))
        if isinstance(element, PreslidingFriction):  # limited to the declared Coulomb level
            levels = [w for w in axis.laws if isinstance(w, CoulombFriction) and w.at == element.at]
            declared = sp.Add(*(parameter_symbol(w.named("level")) for w in levels))
            law = law / element.level * sp.Min(element.level, declared)
        known = {FORCE: load, TIME: NOW} | ({MEMORY: memory.symbol} if memory else {})
        return JointForce(element.at, law.xreplace(known), memory)

    def path(drive: Drive) -> DrivePath:
        passed, place = (
            imperfections_in_order(axis.imperfections_of(drive)),
            drive.signal if several else "drive",
        )
        late = sum(e.seconds for e in passed if isinstance(e, ActuatorDelay))
        kept = (e for e in passed if not isinstance(e, ActuatorDelay))
        return DrivePath(drive, tuple((e, remembered(e, place, acting(drive))) for e in kept), late)

    several = len(axis.drives) > 1
    # friction that grows with the load feels the sum of the sizes of all forces
    forces = [_per_unit(d) * acting(d) for d in axis.drives]
    load = sp.Add(*map(sp.Abs, forces)) if several else forces[0]
    drives = tuple(map(path, axis.drives))
    joints = [force(e) for e in axis.elements if isinstance(e, JointImperfection)]
    joints += [_ripple(drive, e) for drive in axis.drives for e in ripples_of(axis.imperfections_of(drive))]
    changes = tuple(e for e in axis.elements if isinstance(e, PayloadChange))
    is_timed = bool(changes) or any(NOW in joint.law.free_symbols for joint in joints)
    return Imperfect(
        drives=drives,
        joints=tuple(joints),
        memories=tuple(memories),
        changes=changes,
        clock=f"x[{first + len(memories)}]" if is_timed else "",
    )


def _per_unit(drive: Drive) -> sp.Expr:
    """Force of a drive per unit of its signal."""
    return parameter_symbol(drive.constant) if drive.constant else sp.Integer(1)


def _ripple(drive: Drive, element: Imperfection) -> JointForce:
    law = imperfection_law(element).xreplace({FORCE: acting(drive)})
    return JointForce(drive.at, _per_unit(drive) * law, None)


def sent(element: DriveImperfection, drive: Drive) -> sp.Expr:
    """Output force of an imperfection in a drive, in terms of its input force."""
    return imperfection_law(element).xreplace({FORCE: acting(drive)})


def added(change: PayloadChange) -> sp.Symbol:
    """Mass that a declared change adds to a body over time."""
    return sp.Symbol(f"added_{change.body.inertial}_")
