"""Force that a motion needs: the axis as one rigid motion, without the deflection of its springs.

With x = r q, r being the motion of all bodies in which no spring deflects, and q the displacement along which the drive
acts (B r = 1, for a force of 1), F = r M r q(2) + r C r q(1) + r K r q - r c + sum_j (d_j r) f_j(d_j r q, d_j r q(1)).
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from symid.axis import Axis
from symid.errors import SettingError
from symid.export.dynamics import DISPLACEMENT, VELOCITY, symbolic_dynamics

POSITION, SPEED, ACCELERATION = sp.symbols("position_ velocity_ acceleration_")
"""Of the drive; no parameter's name ends with an underscore."""


@dataclass(frozen=True, eq=False)
class Feedforward:
    """Force of the drive along a motion in `POSITION`, `SPEED` and `ACCELERATION`, and its part that is friction."""

    force: sp.Expr
    friction: sp.Expr


def feedforward(axis: Axis) -> Feedforward:
    """Force that a motion of the drive needs.

    >>> from symid.axis import load_axis
    >>> feedforward(load_axis("direct_2m1s")).force
    Fsm*sign(velocity_) + Fvm*velocity_ + Mm*acceleration_
    """
    axis.require_one_drive()
    dynamics = symbolic_dynamics(axis)
    known = {sp.Symbol(name): sp.nsimplify(value) for name, value in dynamics.constants.items()}
    mass, damping, stiffness, drive, constant = (
        term.xreplace(known)
        for term in (dynamics.mass, dynamics.damping, dynamics.stiffness, dynamics.drives, dynamics.constant)
    )
    free = [sp.Matrix([1])] if len(dynamics.bodies) == 1 else stiffness.nullspace()
    works = [sp.cancel((drive.T * motion)[0]) for motion in free]
    if len(free) != 1 or works[0] == 0:
        raise SettingError(
            f"axis {axis.name!r} has {len(free)} motions in which no spring deflects: a feed-forward needs one"
        )
    # A constant of the drive that is a parameter stands in B too; it scales the force and not the motion.
    gain = works[0] / works[0].subs(dict.fromkeys(works[0].free_symbols, 1))
    rigid = (free[0] * gain / works[0]).applyfunc(sp.cancel)

    def along(matrix: sp.Matrix) -> sp.Expr:
        return sp.cancel((rigid.T * matrix * rigid)[0])

    friction = along(damping) * SPEED
    other = along(mass) * ACCELERATION + along(stiffness) * POSITION - sp.cancel((rigid.T * constant)[0])
    for joint in dynamics.laws:
        share = (joint.direction.xreplace(known) @ rigid)[0]
        law = joint.force.xreplace(known)
        force = sp.expand(share * law.subs({DISPLACEMENT: share * POSITION, VELOCITY: share * SPEED}))
        for term in sp.Add.make_args(force.replace(_is_step, _step)):
            friction, other = (friction + term, other) if term.has(SPEED) else (friction, other + term)
    allowed = {*map(sp.Symbol, axis.physical_parameters), POSITION, SPEED, ACCELERATION}
    if strange := (friction + other).free_symbols - allowed:
        raise SettingError(
            f"a feed-forward of axis {axis.name!r} would depend on {min(map(str, strange))!r}, which no motion "
            "determines: leave out imperfections with memory or time"
        )
    return Feedforward((friction + other) / gain, friction / gain)


def _is_step(expression: sp.Expr) -> bool:
    return isinstance(expression, sp.Function) and str(expression.func) in ("sign", "positive")


def _step(expression: sp.Expr) -> sp.Expr:
    """Sign of a speed, or whether it is positive, by the sign of the drive's speed where they go together."""
    ratio = sp.cancel(expression.args[0] / SPEED)
    sign = sp.sign(ratio) * sp.sign(SPEED) if ratio.is_number else sp.sign(expression.args[0])
    return sign if str(expression.func) == "sign" else (1 + sign) / 2
