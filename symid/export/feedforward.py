"""Feed-forward force of a motion, for the axis as a rigid body whose springs do not deflect.

Let x = r q, where r is the motion of all bodies in which no spring deflects, scaled such that B r = 1 for a unit force,
and q the displacement along which the drive acts. Then

    F = r M r q(2) + r C r q(1) + r K r q - r c + sum_j (d_j r) f_j(d_j r q, d_j r q(1)).
"""

from dataclasses import dataclass

import sympy as sp
from sympy.polys.matrices import DomainMatrix

from symid.axis import Axis
from symid.errors import SettingError
from symid.export.dynamics import DISPLACEMENT, VELOCITY, symbolic_dynamics
from symid.symbolic import positive

POSITION, SPEED, ACCELERATION = sp.symbols("position_ velocity_ acceleration_")
"""Motion of the drive; no name of a parameter ends with an underscore."""


@dataclass(frozen=True, eq=False)
class Feedforward:
    """Force of the drive in terms of `POSITION`, `SPEED` and `ACCELERATION`, and the part of it that is friction."""

    force: sp.Expr
    friction: sp.Expr


def feedforward(axis: Axis) -> Feedforward:
    """Feed-forward force for a motion of the drive.

    >>> from symid.axis import load_axis
    >>> feedforward(load_axis("direct_2m1s")).force
    Fsm*sign(velocity_) + Fvm*velocity_ + Mm*acceleration_
    """
    _ = axis.only_drive  # several are refused
    dynamics = symbolic_dynamics(axis)
    known = {sp.Symbol(name): sp.nsimplify(value) for name, value in dynamics.constants.items()}
    mass, damping, stiffness, drive, constant = (
        term.xreplace(known)
        for term in (dynamics.mass, dynamics.damping, dynamics.stiffness, dynamics.drives, dynamics.constant)
    )
    free = [sp.Matrix([1])] if len(dynamics.bodies) == 1 else _nullspace(_of_springs(axis).xreplace(known))
    works = [sp.cancel((drive.T * motion)[0]) for motion in free]
    if len(free) != 1 or works[0] == 0:
        raise SettingError(
            f"axis {axis.name!r} has {len(free)} motions in which no spring deflects: a feed-forward needs one"
        )
    # B also contains the constant of the drive if that is a parameter; it scales the force, not the motion.
    gain = works[0] / works[0].subs(dict.fromkeys(works[0].free_symbols, 1))
    rigid = (free[0] * gain / works[0]).applyfunc(sp.cancel)

    def along(matrix: sp.Matrix) -> sp.Expr:
        return sp.cancel((rigid.T * matrix * rigid)[0])

    friction = along(damping) * SPEED
    inertial = along(mass) * ACCELERATION + along(stiffness) * POSITION - sp.cancel((rigid.T * constant)[0])
    for joint in dynamics.laws:
        share = (joint.direction.xreplace(known) @ rigid)[0]
        law = joint.force.xreplace(known)
        force = sp.expand(share * law.subs({DISPLACEMENT: share * POSITION, VELOCITY: share * SPEED}))
        for term in sp.Add.make_args(force.replace(lambda e: isinstance(e, (sp.sign, positive)), _at_drive)):
            friction, inertial = (
                (friction + term, inertial) if term.has(SPEED) else (friction, inertial + term)
            )
    allowed = {*map(sp.Symbol, axis.physical_parameters), POSITION, SPEED, ACCELERATION}
    if strange := (friction + inertial).free_symbols - allowed:
        raise SettingError(
            f"a feed-forward of axis {axis.name!r} would depend on {min(map(str, strange))!r}, which no motion "
            "determines: leave out imperfections with memory or time"
        )
    return Feedforward((friction + inertial) / gain, friction / gain)


def _of_springs(axis: Axis) -> sp.Matrix:
    """Stiffness of the springs, without laws of the position (a cable chain, for instance): their force moves along."""
    along_stroke = [e for e in axis.laws if not e.in_spring and any(t.expression == "q" for t in e.terms())]
    return symbolic_dynamics(axis.without(*along_stroke)).stiffness


def _nullspace(matrix: sp.Matrix) -> list[sp.Matrix]:
    """Basis of the null space, the last entry of each vector 1, over rational functions, where zero needs no search."""
    rows = DomainMatrix.from_Matrix(matrix).to_field().nullspace().to_Matrix()
    lasts = (next(entry for entry in reversed(list(rows.row(i))) if entry != 0) for i in range(rows.rows))
    return [(rows.row(i).T / last).applyfunc(sp.cancel) for i, last in enumerate(lasts)]


def _at_drive(jump: sp.Expr) -> sp.Expr:
    """A jump in terms of the sign of the drive's speed, if its argument is proportional to that."""
    ratio = sp.cancel(jump.args[0] / SPEED)
    sign = sp.sign(ratio) * sp.sign(SPEED) if ratio.is_number else sp.sign(jump.args[0])
    return sign if isinstance(jump, sp.sign) else (1 + sign) / 2
