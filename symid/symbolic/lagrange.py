"""Lagrange's equations of a declared axis.

Coordinates are those of the declaration: the displacement of each body relative to the body it is on.
Signal values of nonlinear laws stand in the equations as inputs (`LawInput`), so that the equations are
polynomial in the parameters and linear in everything else; `InverseDynamicModel.equations` shows them written out.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import sympy as sp

from symid.axis import (
    GROUND,
    Axis,
    Between,
    Body,
    Damper,
    Ground,
    Joint,
    Law,
    PendulumWeight,
    Sensor,
    Spring,
    Weight,
)
from symid.signals import derivative_name
from symid.symbolic.expressions import law_expression, parameter_symbol

ONE = sp.Integer(1)
ONE_INPUT = sp.Symbol("input_one")
"""Stands for the constant 1, so that constant forces are inputs like the other laws."""


@dataclass(frozen=True)
class LawInput:
    """The value of a nonlinear law in a joint, an input of the otherwise linear equations.

    `symbol` stands for it there; `expression` is in q and v of the joint, `element` its name in messages.
    """

    symbol: sp.Symbol
    expression: sp.Expr
    joint: Joint
    element: str


@dataclass(frozen=True)
class InverseDynamicModel:
    """Lagrange's equations d/dt dT/dq(1) - dT/dq + dV/dq + dD/dq(1) - Q = 0, one for each free body.

    Parameters
    ----------
    axis : Axis
        The declaration.
    coordinates : tuple of str
        Name of each free body's coordinate; ``q_motor_d2`` is its second derivative.
    constants : mapping of str to float
        Known numbers that stand in the equations as symbols: ratios and gravity.
    known : mapping of str to float
        Parameters that are known and not 0, which stand in the equations as symbols too.
    kinetic_energy, potential_energy, dissipation : sympy.Expr
        T, V and Rayleigh's D.
    balances : tuple of sympy.Expr
        Left-hand sides, with the values of nonlinear laws as symbols.
    inputs : tuple of LawInput
        These symbols with the expressions they represent.
    """

    axis: Axis
    coordinates: tuple[str, ...]
    constants: Mapping[str, float]
    known: Mapping[str, float]
    kinetic_energy: sp.Expr
    potential_energy: sp.Expr
    dissipation: sp.Expr
    balances: tuple[sp.Expr, ...]
    inputs: tuple[LawInput, ...]

    @property
    def numbers(self) -> dict[str, float]:
        """All symbols of the equations that stand for known numbers."""
        return {**self.constants, **self.known}

    @property
    def equations(self) -> tuple[sp.Eq, ...]:
        """Equations of motion with the force on the left, laws written out."""
        kinematics = Kinematics(self.axis)
        values = {}
        for entry in self.inputs:
            displacement = kinematics.displacement(entry.joint)
            arguments = {sp.Symbol("q"): displacement, sp.Symbol("v"): kinematics.rate(displacement, 1)}
            values[entry.symbol] = entry.expression.xreplace(arguments)
        drives = {sp.Symbol(drive.signal) for drive in self.axis.drives}
        written = []
        for balance in self.balances:
            motion = balance.xreplace(values)
            forces = sp.Add(
                *(term for term in sp.Add.make_args(motion.expand()) if term.free_symbols & drives)
            )
            written.append(sp.Eq(-forces, sp.expand(motion - forces), evaluate=False))
        return tuple(written)


class Kinematics:
    """Displacements of bodies and joints in the coordinates of an axis."""

    def __init__(self, axis: Axis) -> None:
        self.coordinates = {body: f"q_{body.name}" for body in axis.free_bodies}
        self.constants: dict[str, float] = {}
        self._absent = {name for name, value in axis.known_parameters.items() if value == 0}

    def symbol(self, body: Body, order: int = 0) -> sp.Symbol:
        """Coordinate of a free body, or its derivative."""
        return sp.Symbol(derivative_name(self.coordinates[body], order))

    def parameter(self, name: str) -> sp.Expr:
        """Symbol of a physical parameter; 0 if it is known to be that."""
        return sp.Integer(0) if name in self._absent else parameter_symbol(name)

    def constant(self, name: str, value: float) -> sp.Expr:
        """Exact number if it is whole, else a symbol that stands for it."""
        if float(value).is_integer():
            return sp.Integer(int(value))
        self.constants[name] = float(value)
        return sp.Symbol(name)

    def displacement(self, joint: Joint) -> sp.Expr:
        """Displacement in a joint."""
        if isinstance(joint, Between):
            ratio = self.constant(f"ratio_{joint.first.name}_{joint.second.name}", joint.ratio)
            return sp.expand(self.absolute(joint.second) - ratio * self.absolute(joint.first))
        if joint.geared is None:
            return self.symbol(joint)
        return sp.expand(
            sp.Add(
                *(
                    self.constant(f"ratio_{gear.to.name}_{joint.name}", gear.ratio)
                    * self.displacement(gear.to)
                    for gear in joint.gears
                )
            )
        )

    def absolute(self, body: Body | Ground) -> sp.Expr:
        """Displacement of a body against the ground; a turning body on a sliding one turns by its own coordinate."""
        if isinstance(body, Ground):
            return sp.Integer(0)
        carried = isinstance(body.on, Body) and body.on.turns == body.turns
        return self.displacement(body) + (self.absolute(body.on) if carried else 0)

    def reading(self, sensor: Sensor) -> sp.Expr:
        """Displacement that a sensor measures, or measures a derivative of."""
        if sensor.relative_to is None:
            return self.displacement(sensor.body)
        return (self.absolute(sensor.body) - self.absolute(sensor.reference)).expand()

    def metres_per_radian(self, axis: Axis) -> sp.Expr:
        """A known ratio in metres per radian; 1 where the axis has none."""
        pairs = [(gear.to, body, gear.ratio) for body in axis.bodies for gear in body.gears]
        joints = [getattr(element, "at", None) for element in (*axis.elements, *axis.drives)]
        pairs += [
            (joint.first, joint.second, joint.ratio)
            for joint in joints
            if isinstance(joint, Between) and isinstance(joint.first, Body) and isinstance(joint.second, Body)
        ]
        for first, second, value in pairs:
            if first.turns != second.turns:
                ratio = self.constant(f"ratio_{first.name}_{second.name}", value)
                return ratio if first.turns else 1 / ratio
        return ONE

    def rate(self, displacement: sp.Expr, order: int) -> sp.Expr:
        """Time derivative of a displacement, which is linear in the coordinates."""
        return displacement.xreplace(
            {self.symbol(body): self.symbol(body, order) for body in self.coordinates}
        )


def inverse_dynamics(axis: Axis) -> InverseDynamicModel:
    """Lagrange's equations of an axis: the paper's [3] and [4], for any axis.

    Examples
    --------
    >>> from symid.axis import load_axis
    >>> print(inverse_dynamics(load_axis("rigid_1m")).equations[0])
    Eq(F, Fs*sign(q_motor_d1) + Fv*q_motor_d1 + M*q_motor_d2)
    """
    kinematics = Kinematics(axis)
    kinetic = sp.Add(
        *(
            kinematics.parameter(b.inertial) * kinematics.rate(kinematics.absolute(b), 1) ** 2
            for b in axis.bodies
        )
    )
    kinetic /= 2
    potential = _potential_energy(axis, kinematics)
    dissipation = _dissipation(axis, kinematics)
    inputs, work = _virtual_power(axis, kinematics)
    balances = []
    for body in axis.free_bodies:
        q, v = kinematics.symbol(body), kinematics.symbol(body, 1)
        momentum = sp.diff(kinetic, v)
        inertia = sp.Add(
            *(sp.diff(momentum, kinematics.symbol(b, 1)) * kinematics.symbol(b, 2) for b in axis.free_bodies)
        )
        balances.append(
            sp.expand(inertia + sp.diff(potential, q) + sp.diff(dissipation, v) - sp.diff(work, v))
        )
    return InverseDynamicModel(
        axis=axis,
        coordinates=tuple(kinematics.coordinates.values()),
        constants=dict(sorted(kinematics.constants.items())),
        known={name: value for name, value in axis.known_parameters.items() if value},
        kinetic_energy=kinetic,
        potential_energy=potential,
        dissipation=dissipation,
        balances=tuple(balances),
        inputs=inputs,
    )


def _potential_energy(axis: Axis, kinematics: Kinematics) -> sp.Expr:
    """Springs, laws linear in q, and weights of constant force. Pendulum weights are inputs: sin q is not linear."""
    energy = sp.Integer(0)
    for element in axis.elements:
        if isinstance(element, Spring):
            energy += (
                kinematics.parameter(element.named("stiffness"))
                * kinematics.displacement(element.at) ** 2
                / 2
            )
        elif isinstance(element, Weight):
            gravity = kinematics.constant(f"gravity_{element.body.name}", element.acceleration)
            energy += (
                kinematics.parameter(element.body.inertial)
                * gravity
                * kinematics.absolute(element.body)
                * ONE_INPUT
            )
        elif isinstance(element, Law):
            for term in element.terms():
                if term.expression == "q":
                    energy += (
                        kinematics.parameter(term.parameter) * kinematics.displacement(element.at) ** 2 / 2
                    )
    return energy


def _dissipation(axis: Axis, kinematics: Kinematics) -> sp.Expr:
    """Rayleigh's function of the dampers and of friction linear in velocity."""
    dampers: list[tuple[str, Joint]] = []
    for element in axis.elements:
        if isinstance(element, (Spring, Damper)) and element.damping is not None:
            dampers.append((element.named("damping"), element.at))
        elif isinstance(element, Law):
            dampers += [(term.parameter, element.at) for term in element.terms() if term.expression == "v"]
    rates = (
        (kinematics.parameter(name), kinematics.rate(kinematics.displacement(at), 1)) for name, at in dampers
    )
    return sp.Add(*(coefficient * rate**2 for coefficient, rate in rates)) / 2


def _virtual_power(axis: Axis, kinematics: Kinematics) -> tuple[tuple[LawInput, ...], sp.Expr]:
    """Nonlinear laws as inputs; the power of the drives and of the laws, whose derivative by a velocity is a force."""
    inputs: dict[tuple[sp.Expr, sp.Expr], LawInput] = {}
    power = sp.Integer(0)
    for drive in axis.drives:
        gain = ONE if drive.constant is None else kinematics.parameter(drive.constant)
        power += gain * sp.Symbol(drive.signal) * kinematics.rate(kinematics.displacement(drive.at), 1)

    def resist(
        parameter: sp.Expr, expression: sp.Expr, joint: Joint, displacement: sp.Expr, element: str
    ) -> None:
        nonlocal power
        constant = not expression.free_symbols
        key = (ONE, ONE) if constant else (expression, displacement)
        if key not in inputs:
            symbol = ONE_INPUT if constant else sp.Symbol(f"input_{len(inputs)}")
            inputs[key] = LawInput(symbol, ONE if constant else expression, joint, element)
        factor = expression if constant else ONE
        power -= parameter * factor * inputs[key].symbol * kinematics.rate(displacement, 1)

    for element in axis.elements:
        if isinstance(element, Law):
            label = f"{type(element).__name__} at {_joint_name(element.at)}"
            for term in element.terms():
                if not term.is_linear:
                    displacement = kinematics.displacement(element.at)
                    resist(
                        kinematics.parameter(term.parameter),
                        law_expression(term.expression),
                        element.at,
                        displacement,
                        label,
                    )
        elif isinstance(element, PendulumWeight):
            gravity = kinematics.constant(f"gravity_{element.body.name}", element.acceleration)
            at = Between(first=GROUND, second=element.body)
            label = f"PendulumWeight of {element.body.name!r}"
            angle = kinematics.absolute(element.body)
            resist(
                kinematics.parameter(element.named("moment")) * gravity,
                sp.sin(sp.Symbol("q")),
                at,
                angle,
                label,
            )
        elif isinstance(element, Weight):
            inputs.setdefault(
                (ONE, ONE), LawInput(ONE_INPUT, ONE, element.body, f"Weight of {element.body.name!r}")
            )
    return tuple(inputs.values()), power


def _joint_name(joint: Joint) -> str:
    return (
        f"{joint.first.name!r} and {joint.second.name!r}" if isinstance(joint, Between) else repr(joint.name)
    )
