"""Forward dynamics of an axis as expressions: what `symid.simulation.forward_dynamics` holds as numbers.

M x(2) = B F + c - C x(1) - K x - sum_j d_j f_j(d_j x, d_j x(1)), x being the absolute displacements of the free
bodies. Balances and laws are those from which the regressors come.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import sympy as sp

from symid.axis import Axis
from symid.errors import SettingError
from symid.export.imperfect_terms import Imperfect, Memory, added, of_force
from symid.symbolic.equations import by_power
from symid.symbolic.lagrange import Kinematics, inverse_dynamics
from symid.symbolic.operators import OperatorModel, operator_model

DISPLACEMENT, VELOCITY = sp.Symbol("joint_q_"), sp.Symbol("joint_v_")
"""Of a joint, in the force of its laws; no parameter's name ends with an underscore."""
_OF_JOINT = {sp.Symbol("q"): DISPLACEMENT, sp.Symbol("v"): VELOCITY}
_Row: TypeAlias = tuple[tuple[str, sp.Expr], ...]


@dataclass(frozen=True, eq=False)
class LawJoint:
    """All nonlinear laws that act along one direction, given by the coefficients of the bodies' absolute displacements.

    `force` opposes the motion, in parameters, `DISPLACEMENT` and `VELOCITY`; of imperfections also in what they need.
    """

    name: str
    displacement: Mapping[str, sp.Expr]
    force: sp.Expr
    memories: tuple[Memory, ...] = ()

    @property
    def jumps(self) -> bool:
        """Whether the force jumps where the joint reverses, so that it can stick."""
        jumps = (f for f in self.force.atoms(sp.Function) if str(f.func) in ("sign", "positive"))
        return any(VELOCITY in f.free_symbols for f in jumps)


@dataclass(frozen=True, eq=False)
class SymbolicDynamics:
    """The terms of the equation above.

    Parameters
    ----------
    axis : Axis
        The declaration.
    bodies : tuple of str
        Free bodies, in the order of the displacements.
    mass, damping, stiffness : sympy.Matrix of shape (n, n)
        M, C and K in the physical parameters.
    drives : sympy.Matrix of shape (n, n_drives)
        B.
    constant : sympy.Matrix of shape (n, 1)
        c.
    joints : tuple of LawJoint
        Nonlinear laws by joint.
    sensors : mapping of str to (mapping, int)
        For each signal the coefficients of the bodies' displacements and the order of derivative.
    constants : mapping of str to float
        Known numbers that stand in the terms as symbols: ratios and gravity.
    imperfect : Imperfect
        Imperfections; their forces in joints, and the masses that they add, are in the terms.
    """

    axis: Axis
    bodies: tuple[str, ...]
    mass: sp.Matrix
    damping: sp.Matrix
    stiffness: sp.Matrix
    drives: sp.Matrix
    constant: sp.Matrix
    joints: tuple[LawJoint, ...]
    sensors: Mapping[str, tuple[Mapping[str, sp.Expr], int]]
    constants: Mapping[str, float]
    imperfect: Imperfect

    @property
    def n_states(self) -> int:
        """Displacements, velocities, and what imperfections remember."""
        return 2 * len(self.bodies) + len(self.imperfect.states)


def symbolic_dynamics(axis: Axis) -> SymbolicDynamics:
    """Forward dynamics of an axis as expressions.

    Examples
    --------
    >>> from symid.axis import load_axis
    >>> dynamics = symbolic_dynamics(load_axis("rigid_1m"))
    >>> dynamics.mass, dynamics.joints[0].force
    (Matrix([[M]]), Fs*sign(joint_v_))
    """
    if len(axis.drives) > 1 and (disturbing := [e for e in axis.imperfections if of_force(e)]):
        raise SettingError(
            f"axis {axis.name!r} has several drives and {type(disturbing[0]).__name__}, which cannot be exported "
            "together: leave it out"
        )
    operators = operator_model(inverse_dynamics(axis))
    bodies = tuple(operators.motion)
    powers = [[by_power(operators.motion[b].get(x)) for x in bodies] for b in bodies]
    stiffness, damping, mass = (
        sp.Matrix([[_expression(entry.get(order)) for entry in row] for row in powers]) for order in range(3)
    )
    ones = [str(w.symbol) for w in operators.source.inputs if not w.expression.free_symbols]
    kinematics, imperfect = Kinematics(axis), Imperfect(axis, 2 * sum(map(any, mass.tolist())))
    masses = {sp.Symbol(change.body.inertial): added(change) for change in imperfect.changes}
    grown = {mass: mass + more for mass, more in masses.items()}
    dynamics = SymbolicDynamics(
        axis=axis,
        bodies=bodies,
        mass=mass.xreplace(grown),
        damping=damping,
        stiffness=stiffness,
        drives=sp.Matrix(
            [[-_expression(operators.force[b].get(d.signal)) for d in axis.drives] for b in bodies]
        ),
        constant=sp.Matrix(
            [-sp.Add(*(_expression(operators.inputs[b].get(one)) for one in ones)) for b in bodies]
        ).xreplace(grown),
        joints=_joints(operators, kinematics, imperfect),
        sensors={
            sensor.signal: (_row(operators, kinematics.reading(sensor)), sensor.derivative)
            for sensor in axis.sensors
        },
        constants={**operators.source.numbers, **kinematics.constants},
        imperfect=imperfect,
    )
    return _without_nodes(dynamics) if any(not any(row) for row in mass.tolist()) else dynamics


def _without_nodes(dynamics: SymbolicDynamics) -> SymbolicDynamics:
    """The dynamics without massless bodies, which are where the springs beside them balance: x = T x_heavy."""
    n = len(dynamics.bodies)
    nodes = [i for i in range(n) if not any(dynamics.mass.row(i))]
    heavy = [i for i in range(n) if i not in nodes]
    names = [dynamics.bodies[i] for i in nodes]
    others = (dynamics.damping, dynamics.drives, dynamics.constant)
    springs = dynamics.stiffness.extract(nodes, nodes)
    if (
        any(any(matrix.row(i)) for matrix in others for i in nodes)
        or any(joint.displacement.keys() & set(names) for joint in dynamics.joints)
        or sp.cancel(springs.det()) == 0
    ):
        raise SettingError(
            f"axis {dynamics.axis.name!r} has bodies without mass ({', '.join(names)}) that carry more than springs, "
            "or none, which cannot be exported: give each a mass"
        )
    balanced = (-springs.LUsolve(dynamics.stiffness.extract(nodes, heavy))).applyfunc(sp.cancel)
    T = sp.Matrix(
        [
            balanced.row(nodes.index(i)) if i in nodes else sp.eye(len(heavy)).row(heavy.index(i))
            for i in range(n)
        ]
    )
    bodies = tuple(dynamics.bodies[i] for i in heavy)

    def read(row: Mapping[str, sp.Expr]) -> dict[str, sp.Expr]:
        whole = sp.Matrix([[row.get(body, 0) for body in dynamics.bodies]]) * T
        return {body: sp.cancel(share) for body, share in zip(bodies, whole, strict=True) if share != 0}

    return replace(
        dynamics,
        bodies=bodies,
        mass=dynamics.mass.extract(heavy, heavy),
        damping=dynamics.damping.extract(heavy, heavy),
        stiffness=(T.T * dynamics.stiffness * T).applyfunc(sp.cancel),
        drives=dynamics.drives.extract(heavy, list(range(dynamics.drives.cols))),
        constant=dynamics.constant.extract(heavy, [0]),
        sensors={signal: (read(row), order) for signal, (row, order) in dynamics.sensors.items()},
    )


def _expression(polynomial: Any) -> sp.Expr:
    return polynomial.as_expr() if polynomial else sp.Integer(0)


def _row(operators: OperatorModel, displacement: sp.Expr) -> dict[str, sp.Expr]:
    """A displacement as coefficients of the bodies' absolute displacements."""
    field = operators.ring.domain
    return {
        body: field.to_sympy(field.convert(value))
        for body, value in operators.functional(displacement).items()
    }


def _joints(operators: OperatorModel, kinematics: Kinematics, imperfect: Imperfect) -> tuple[LawJoint, ...]:
    joints = _Joints()
    for entry in operators.source.inputs:
        if entry.expression.free_symbols:
            row = _row(operators, kinematics.displacement(entry.joint))
            # In the balance of a body the law's parameter stands times the share of that body in the displacement.
            body, share = next(iter(row.items()))
            parameter = _expression(operators.inputs[body][str(entry.symbol)]) / share
            joints.add(row, sp.cancel(parameter), entry.expression)
    for element, law in zip(imperfect.in_joints, imperfect.laws, strict=True):
        joints.add(_row(operators, kinematics.displacement(element.at)), sp.Integer(1), law)
    memories = imperfect.memories[len(imperfect.drive) :]
    for element, memory in zip(imperfect.in_joints, memories, strict=True):
        if memory is not None:
            joints.remember(_row(operators, kinematics.displacement(element.at)), memory)
    return joints.found()


class _Joints:
    """Laws by the direction in which they act."""

    def __init__(self) -> None:
        self.names: dict[_Row, str] = {}
        self.forces: dict[_Row, sp.Expr] = {}
        self.memories: dict[_Row, list[Memory]] = {}

    def add(self, row: dict[str, sp.Expr], parameter: sp.Expr, law: sp.Expr) -> None:
        """Add a law that acts along a row."""
        key = tuple(sorted(row.items()))
        if key not in self.names:
            name = "_".join(sorted(row))
            self.names[key] = name if name not in self.names.values() else f"{name}_{len(self.names)}"
        self.forces[key] = self.forces.get(key, sp.Integer(0)) + parameter * law.xreplace(_OF_JOINT)

    def remember(self, row: dict[str, sp.Expr], memory: Memory) -> None:
        """One more memory of a law that was added."""
        gain, decay = (e.xreplace(_OF_JOINT) for e in (memory.gain, memory.decay))
        known = replace(memory, gain=gain, decay=decay)
        self.memories.setdefault(tuple(sorted(row.items())), []).append(known)

    def found(self) -> tuple[LawJoint, ...]:
        """Joints with their laws and memories."""
        return tuple(
            LawJoint(name, dict(key), self.forces[key], tuple(self.memories.get(key, ())))
            for key, name in self.names.items()
        )
