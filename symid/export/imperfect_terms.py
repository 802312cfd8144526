"""Imperfections of an axis as expressions: in the drive, in time, with memory."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import sympy as sp

from symid.axis import (
    ActuatorDelay,
    Axis,
    CoulombFriction,
    DriveImperfection,
    Imperfection,
    JointImperfection,
    PayloadChange,
    PreslidingFriction,
)
from symid.axis.drive_imperfections import in_order
from symid.axis.elements import joint_label
from symid.symbolic.expressions import (
    FORCE,
    MEMORY,
    TIME,
    imperfection_law,
    imperfection_rate,
    parameter_symbol,
)

ACTING, NOW = sp.Symbol("force_"), sp.Symbol("now_")
"""The acting force and the time in expressions; no name of a parameter ends with an underscore."""


@dataclass(frozen=True, eq=False)
class Memory:
    """State of an imperfection with memory: z(1) = gain - decay z, in `ACTING`, or in q and v of its joint."""

    name: str
    symbol: sp.Symbol  # the state in C
    gain: sp.Expr
    decay: sp.Expr

    @property
    def rate(self) -> sp.Expr:
        """Derivative of the state, z(1)."""
        return self.gain - self.decay * self.symbol


class JointForce(NamedTuple):
    """An imperfection in a joint: its force in terms of q, v, `ACTING`, `NOW` and the state of its memory."""

    element: JointImperfection
    law: sp.Expr
    memory: Memory | None


@dataclass(frozen=True, eq=False)
class Imperfect:
    """The imperfections of an axis."""

    # those of the drive except its delay, in signal-flow order, with their states
    drive: tuple[tuple[DriveImperfection, Memory | None], ...]
    joints: tuple[JointForce, ...]  # those that act as forces in joints
    memories: tuple[Memory, ...]  # all states, in order
    delay: float  # delay of the drive, s
    changes: tuple[PayloadChange, ...]  # changes of masses over time
    clock: str  # C expression of the time, a state of the axis if anything depends on it; else empty

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states that the imperfections add."""
        return (*(memory.name for memory in self.memories), *(("t",) if self.clock else ()))


def imperfections_of(axis: Axis, first: int) -> Imperfect:
    """The imperfections of an axis as expressions; `first` is the index of the first memory in the state."""
    memories: list[Memory] = []

    def remembered(element: Imperfection) -> Memory | None:
        if not element.rate:
            return None
        rate = sp.expand(imperfection_rate(element).xreplace({FORCE: ACTING}))
        decay, symbol = -rate.coeff(MEMORY), sp.Symbol(f"x[{first + len(memories)}]")
        place = joint_label(element.at) if isinstance(element, JointImperfection) else "drive"
        memories.append(Memory(f"z_{place}", symbol, sp.expand(rate + decay * MEMORY), decay))
        return memories[-1]

    def force(element: JointImperfection) -> JointForce:
        law, memory = imperfection_law(element), remembered(element)
        if isinstance(element, PreslidingFriction):  # limited to the declared Coulomb level
            levels = [w for w in axis.laws if isinstance(w, CoulombFriction) and w.at == element.at]
            declared = sp.Add(*(parameter_symbol(w.named("level")) for w in levels))
            law = law / element.level * sp.Min(element.level, declared)
        known = {FORCE: ACTING, TIME: NOW} | ({MEMORY: memory.symbol} if memory else {})
        return JointForce(element, law.xreplace(known), memory)

    passed = in_order(e for e in axis.elements if isinstance(e, DriveImperfection))
    drive = tuple((e, remembered(e)) for e in passed if not isinstance(e, ActuatorDelay))
    joints = tuple(force(e) for e in axis.elements if isinstance(e, JointImperfection))
    changes = tuple(e for e in axis.elements if isinstance(e, PayloadChange))
    is_timed = bool(changes) or any(NOW in joint.law.free_symbols for joint in joints)
    return Imperfect(
        drive=drive,
        joints=joints,
        memories=tuple(memories),
        delay=sum(e.seconds for e in passed if isinstance(e, ActuatorDelay)),
        changes=changes,
        clock=f"x[{first + len(memories)}]" if is_timed else "",
    )


def of_force(element: Imperfection) -> bool:
    """Whether an imperfection is in the drive, or a law that depends on the drive force."""
    return isinstance(element, DriveImperfection) or (
        isinstance(element, JointImperfection) and FORCE in imperfection_law(element).free_symbols
    )


def sent(element: DriveImperfection) -> sp.Expr:
    """Output force of an imperfection in the drive, in terms of its input force `ACTING`."""
    return imperfection_law(element).xreplace({FORCE: ACTING})


def added(change: PayloadChange) -> sp.Symbol:
    """Mass that a declared change adds to a body over time."""
    return sp.Symbol(f"added_{change.body.inertial}_")
