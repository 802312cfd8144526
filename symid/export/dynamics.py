"""Forward dynamics of an axis as expressions, imperfections included; a `Plant` holds them as numbers.

M x(2) = B F + c - C x(1) - K x - sum_j d_j f_j(d_j x, d_j x(1)), see `symid.symbolic.forward_terms`.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import sympy as sp
from sympy.polys.rings import PolyElement

from symid.axis import Axis, Drive, Joint, Sensor
from symid.errors import SettingError
from symid.export.imperfect_terms import Imperfect, Memory, added, imperfections_of
from symid.simulation.plants import condensed
from symid.symbolic import ForwardTerms, Functional, Kinematics, by_power, forward_terms

DISPLACEMENT, VELOCITY = sp.Symbol("joint_q_"), sp.Symbol("joint_v_")
"""Motion of a joint in the force of its laws; no parameter's name ends with an underscore."""
_OF_JOINT = {sp.Symbol("q"): DISPLACEMENT, sp.Symbol("v"): VELOCITY}


@dataclass(frozen=True, eq=False)
class LawJoint:
    """All nonlinear laws that act along one direction, a row on the bodies' absolute displacements.

    `force` opposes the motion, in parameters, `DISPLACEMENT` and `VELOCITY`; of imperfections also in time, memory and
    drive force.
    """

    name: str
    direction: sp.ImmutableMatrix
    force: sp.Expr
    memories: tuple[Memory, ...] = ()

    @property
    def jumps(self) -> bool:
        """Whether the force jumps where the joint reverses, so that it can stick."""
        jumps = (f for f in self.force.atoms(sp.Function) if str(f.func) in ("sign", "positive"))
        return any(VELOCITY in f.free_symbols for f in jumps)


class SymbolicReading(NamedTuple):
    """Reading of a sensor, as `SensorRow` with SymPy's matrices."""

    row: sp.Matrix
    order: int | None
    motion: sp.Matrix
    drives: sp.Matrix
    constant: sp.Expr
    # reading per unit of the laws of the spring that is read; 0 without such laws
    per_force: sp.Expr = sp.Integer(0)


@dataclass(frozen=True, eq=False)
class SymbolicDynamics:
    """The terms of the equation above: as those of `Plant`, but SymPy's matrices and rows in the physical parameters.

    `constants` are known numbers that stand in the terms as symbols: ratios and gravity. The forces of the
    imperfections in joints, and the masses that they add, are in the terms.
    """

    axis: Axis
    bodies: tuple[str, ...]
    mass: sp.Matrix
    damping: sp.Matrix
    stiffness: sp.Matrix
    drives: sp.Matrix
    constant: sp.Matrix
    laws: tuple[LawJoint, ...]
    sensors: Mapping[str, SymbolicReading]
    constants: Mapping[str, float]
    imperfect: Imperfect

    @property
    def n_states(self) -> int:
        """Number of displacements, velocities and states of imperfections."""
        return 2 * len(self.bodies) + len(self.imperfect.states)


def symbolic_dynamics(axis: Axis) -> SymbolicDynamics:
    """Forward dynamics of an axis as expressions.

    >>> from symid.axis import load_axis
    >>> dynamics = symbolic_dynamics(load_axis("rigid_1m"))
    >>> dynamics.mass, dynamics.laws[0].force
    (Matrix([[M]]), Fs*sign(joint_v_))
    """
    terms = forward_terms(axis)
    is_node = [not any(row) for row in terms.mass]
    imperfect = imperfections_of(axis, first=2 * is_node.count(False))
    parts = _Parts(terms, Kinematics(axis), imperfect)
    masses = {sp.Symbol(change.body.inertial): added(change) for change in imperfect.changes}
    grown = {mass: mass + more for mass, more in masses.items()}
    dynamics = SymbolicDynamics(
        axis=axis,
        bodies=terms.bodies,
        mass=_matrix(terms.mass).xreplace(grown),
        damping=_matrix(terms.damping),
        stiffness=_matrix(terms.stiffness),
        drives=_matrix(terms.drives),
        constant=_matrix(terms.constant).xreplace(grown),
        laws=parts.joints(),
        sensors={sensor.signal: parts.reading(sensor, axis.drives) for sensor in axis.sensors},
        constants={**terms.constants, **parts.kinematics.constants},
        imperfect=imperfect,
    )
    return _without_nodes(dynamics, is_node) if any(is_node) else dynamics


def _matrix(entries: Sequence[Sequence[PolyElement]]) -> sp.Matrix:
    return sp.Matrix([[entry.as_expr() for entry in row] for row in entries])


@dataclass(frozen=True)
class _Parts:
    """Laws and readings of an axis, from polynomials of its operators to expressions."""

    terms: ForwardTerms
    kinematics: Kinematics
    imperfect: Imperfect

    def joints(self) -> tuple[LawJoint, ...]:
        """Forces of laws and imperfections, summed over those of a joint."""
        forces: dict[sp.ImmutableMatrix, list[sp.Expr]] = {}
        memories: dict[sp.ImmutableMatrix, list[Memory]] = {}
        for law in self.terms.laws:
            force = sp.cancel(law.parameter.as_expr()) * law.expression.xreplace(_OF_JOINT)
            forces.setdefault(self._row(law.displacement), []).append(force)
        for at, force, memory in self.imperfect.joints:
            direction = self._direction(at)
            forces.setdefault(direction, []).append(force.xreplace(_OF_JOINT))
            if memory is not None:
                gain, decay = (rate.xreplace(_OF_JOINT) for rate in (memory.gain, memory.decay))
                memories.setdefault(direction, []).append(replace(memory, gain=gain, decay=decay))
        return tuple(
            LawJoint(name, direction, sp.Add(*forces[direction]), tuple(memories.get(direction, ())))
            for name, direction in self._named(forces).items()
        )

    def _named(self, directions: Iterable[sp.ImmutableMatrix]) -> dict[str, sp.ImmutableMatrix]:
        """Directions by the names of the bodies that move along them, with a number where these repeat."""
        named: dict[str, sp.ImmutableMatrix] = {}
        for direction in directions:
            shares = zip(self.terms.bodies, direction, strict=True)
            name = "_".join(sorted(body for body, share in shares if share))
            named[f"{name}_{len(named)}" if name in named else name] = direction
        return named

    def reading(self, sensor: Sensor, drives: Sequence[Drive]) -> SymbolicReading:
        """Reading of a sensor: (motion + drives - offset) / gain."""
        read, zero = self.terms.readings[sensor.signal], self.terms.operators.ring.zero
        gain = read.gain.as_expr()
        motion = [[by_power(read.motion.get(b)).get(k, zero) for b in self.terms.bodies] for k in range(3)]
        shares = [read.drives.get(drive.signal, zero).as_expr() / gain for drive in drives]
        return SymbolicReading(
            self._direction(sensor.joint),
            sensor.derivative,
            _matrix(motion) / gain,
            sp.Matrix([shares]),
            -read.offset.as_expr() / gain,
            1 / gain if read.laws else sp.Integer(0),
        )

    def _direction(self, joint: Joint) -> sp.ImmutableMatrix:
        """Displacement of a joint as a row over the bodies."""
        return self._row(self.terms.operators.functional(self.kinematics.displacement(joint)))

    def _row(self, functional: Functional) -> sp.ImmutableMatrix:
        field = self.terms.operators.ring.domain
        shares = (field.to_sympy(field.convert(functional.get(body, 0))) for body in self.terms.bodies)
        return sp.ImmutableMatrix([list(shares)])


def _without_nodes(dynamics: SymbolicDynamics, is_node: list[bool]) -> SymbolicDynamics:
    """The dynamics without massless bodies, which are where the springs beside them balance: x = T x_heavy."""
    nodes = [i for i, massless in enumerate(is_node) if massless]
    heavy = [i for i, massless in enumerate(is_node) if not massless]
    others = (
        dynamics.damping,
        dynamics.drives,
        dynamics.constant,
        *(law.direction.T for law in dynamics.laws),
    )
    springs = dynamics.stiffness.extract(nodes, nodes)
    if any(any(matrix.row(i)) for matrix in others for i in nodes) or sp.cancel(springs.det()) == 0:
        names = ", ".join(dynamics.bodies[i] for i in nodes)
        raise SettingError(
            f"axis {dynamics.axis.name!r} has bodies without mass ({names}) that carry more than springs, "
            "or none, which cannot be exported: give each a small mass; with springs K and dampers D in all beside a "
            "body, a mass of D^2/(100 K) changes its relaxation by 1 % and takes steps below D/(100 K)"
        )
    # 0 = K_nn x_n + K_nh x_h gives the nodes by the heavy bodies: x_n = -K_nn^-1 K_nh x_h (static condensation).
    balanced = (-springs.LUsolve(dynamics.stiffness.extract(nodes, heavy))).applyfunc(sp.cancel)
    T = sp.zeros(len(is_node), len(heavy))
    for k, i in enumerate(heavy):
        T[i, k] = 1
    for k, i in enumerate(nodes):
        T[i, :] = balanced.row(k)
    reduced: SymbolicDynamics = condensed(dynamics, T, tuple(dynamics.bodies[i] for i in heavy))
    return replace(
        reduced,
        stiffness=reduced.stiffness.applyfunc(sp.cancel),
        sensors={s: r._replace(motion=r.motion.applyfunc(sp.cancel)) for s, r in reduced.sensors.items()},
    )
