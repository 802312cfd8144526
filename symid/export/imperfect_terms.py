"""Imperfections of an axis as expressions: of the drive, in time, with memory, of a reading."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

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
from symid.axis.elements import joint_label
from symid.axis.imperfections import in_order
from symid.symbolic.expressions import (
    FORCE,
    MEMORY,
    TIME,
    imperfection_law,
    imperfection_rate,
    parameter_symbol,
)

ACTING, NOW = sp.Symbol("force_"), sp.Symbol("now_")
"""The force that acts, and the time, in expressions; no parameter's name ends with an underscore."""


@dataclass(frozen=True, eq=False)
class Memory:
    """State of an imperfection with memory, z(1) = gain - decay z, in `ACTING`, or in q and v of its joint.

    `symbol` stands for the state in C.
    """

    name: str
    symbol: sp.Symbol
    gain: sp.Expr
    decay: sp.Expr

    @property
    def rate(self) -> sp.Expr:
        """Derivative of the state, z(1)."""
        return self.gain - self.decay * self.symbol


@dataclass(frozen=True, eq=False)
class Imperfect:
    """The imperfections of an axis; `first` is the place in the state of the first memory."""

    axis: Axis
    first: int

    @cached_property
    def memories(self) -> tuple[Memory | None, ...]:
        """For each imperfection of the drive, then of the joints, what it remembers, in the order of the state."""
        found: list[Memory | None] = []
        for element in (*self.drive, *self.in_joints):
            place = self.first + sum(memory is not None for memory in found)
            found.append(_memory(element, sp.Symbol(f"x[{place}]")) if element.rate else None)
        return tuple(found)

    @property
    def remembering(self) -> tuple[Memory, ...]:
        """Memories of the effects that have one."""
        return tuple(memory for memory in self.memories if memory is not None)

    @property
    def of_drive(self) -> tuple[tuple[DriveImperfection, Memory | None], ...]:
        """Imperfections of the drive with their memories."""
        return tuple(zip(self.drive, self.memories, strict=False))

    @cached_property
    def drive(self) -> tuple[DriveImperfection, ...]:
        """Imperfections of the drive without its delay, in the order in which a force passes them."""
        items = in_order(e for e in self.axis.elements if isinstance(e, DriveImperfection))
        return tuple(item for item in items if not isinstance(item, ActuatorDelay))

    @cached_property
    def in_joints(self) -> tuple[JointImperfection, ...]:
        """Imperfections that act as forces in joints."""
        return tuple(e for e in self.axis.elements if isinstance(e, JointImperfection))

    @cached_property
    def delay(self) -> float:
        """Delay of the drive, s."""
        return sum(e.seconds for e in self.axis.elements if isinstance(e, ActuatorDelay))

    @cached_property
    def changes(self) -> tuple[PayloadChange, ...]:
        """Changes of masses over time."""
        return tuple(e for e in self.axis.elements if isinstance(e, PayloadChange))

    @cached_property
    def is_timed(self) -> bool:
        """Whether anything depends on the time, which then is a state."""
        return bool(self.changes) or any(NOW in law.free_symbols for law in self.laws)

    @property
    def clock(self) -> str:
        """C expression of the time."""
        return f"x[{self.first + len(self.remembering)}]"

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states that the imperfections add."""
        return (*(memory.name for memory in self.remembering), *(("t",) if self.is_timed else ()))

    @cached_property
    def laws(self) -> tuple[sp.Expr, ...]:
        """Forces in joints, in q, v, `ACTING`, `NOW` and the states of memories."""
        memories = self.memories[len(self.drive) :]
        return tuple(self._law(e, memory) for e, memory in zip(self.in_joints, memories, strict=True))

    def _law(self, element: JointImperfection, memory: Memory | None) -> sp.Expr:
        law = imperfection_law(element)
        if isinstance(element, PreslidingFriction):  # at most the level that is declared
            levels = [w for w in self.axis.laws if isinstance(w, CoulombFriction) and w.at == element.at]
            declared = sp.Add(*(parameter_symbol(w.named("level")) for w in levels))
            law = law / element.level * sp.Min(element.level, declared)
        known = {FORCE: ACTING, TIME: NOW} | ({MEMORY: memory.symbol} if memory else {})
        return law.xreplace(known)


def of_force(element: Imperfection) -> bool:
    """Whether an imperfection is one of the drive, or a law that feels its force."""
    return isinstance(element, DriveImperfection) or (
        isinstance(element, JointImperfection) and FORCE in imperfection_law(element).free_symbols
    )


def sent(element: DriveImperfection) -> sp.Expr:
    """The force that leaves an imperfection of the drive for one that enters it."""
    return imperfection_law(element).xreplace({FORCE: ACTING})


def added(change: PayloadChange) -> sp.Symbol:
    """Increase of a mass."""
    return sp.Symbol(f"added_{change.body.inertial}_")


def _memory(element: Imperfection, symbol: sp.Symbol) -> Memory:
    rate = sp.expand(imperfection_rate(element).xreplace({FORCE: ACTING}))
    decay = -rate.coeff(MEMORY)
    place = joint_label(element.at) if isinstance(element, JointImperfection) else "drive"
    return Memory(f"z_{place}", symbol, sp.expand(rate + decay * MEMORY), decay)
