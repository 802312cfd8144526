"""Lagrange's equations of a declared axis.

Coordinates are those of the declaration: the displacement of each body relative to the body it is on. The values of
nonlinear laws are inputs of the equations (`LawInput`), which are then polynomial in the parameters and linear in
everything else. `InverseDynamicModel.equations` writes the laws out.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

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
    Spring,
    Weight,
    carrier_of,
)
from symid.signal_names import derivative_name
from symid.symbolic.expressions import law_expression, parameter_symbol

ONE = sp.Integer(1)
ONE_INPUT = sp.Symbol("input_one")
"""Stands for the constant 1, so that constant forces are inputs like the other laws."""


@dataclass(frozen=True)
class LawInput:
    """The value of a nonlinear law in a joint, an input of the otherwise linear equations."""

    symbol: sp.Symbol  # the value in the equations
    expression: sp.Expr  # in q and v of the joint
    joint: Joint
    element: str  # name of the law in messages


@dataclass(frozen=True)
class InverseDynamicModel:
    """Lagrange's equations d/dt dT/dq(1) - dT/dq + dV/dq + dD/dq(1) - Q = 0, one for each free body."""

    axis: Axis  # the declaration
    constants: Mapping[str, float]  # ratios and gravity, which the equations hold as symbols
    known: Mapping[str, float]  # known parameters other than 0, which the equations hold as symbols
    balances: tuple[sp.Expr, ...]  # left-hand sides, with the values of nonlinear laws as symbols
    inputs: tuple[LawInput, ...]  # these symbols with the expressions they represent

    @property
    def numbers(self) -> dict[str, float]:
        """All known numbers that the equations hold as symbols."""
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
    """Displacements of bodies and joints in the coordinates of an axis; ``q_motor_d2`` is a second derivative."""

    def __init__(self, axis: Axis) -> None:
        self.coordinates = {body: f"q_{body.name}" for body in axis.free_bodies}
        self.constants: dict[str, float] = {}
        self._values = _values_of_constants(axis)
        self._absent = {name for name, value in axis.known_parameters.items() if value == 0}

    def symbol(self, body: Body, order: int = 0) -> sp.Symbol:
        """Coordinate of a free body, or its derivative."""
        return sp.Symbol(derivative_name(self.coordinates[body], order))

    def parameter(self, name: str) -> sp.Expr:
        """Symbol of a physical parameter; 0 if the parameter is known to be 0."""
        return sp.Integer(0) if name in self._absent else parameter_symbol(name)

    def constant(self, name: str, value: float) -> sp.Expr:
        """Exact number if it is an integer, else a symbol for it."""
        if float(value).is_integer():
            return sp.Integer(int(value))
        # Another ratio between the same bodies, or acceleration, has its own name, the same in every process.
        name += "_" * self._values.get(name, [value]).index(value)
        self.constants[name] = float(value)
        return sp.Symbol(name)

    def displacement(self, joint: Joint) -> sp.Expr:
        """Displacement in a joint."""
        if isinstance(joint, Between):
            ratio = self.constant(f"ratio_{joint.first.name}_{joint.second.name}", joint.ratio)
            pairs = ((joint.first, joint.second), (joint.second, joint.first))
            first, second = (self.absolute(b) - self.absolute(carrier_of(b, other)) for b, other in pairs)
            return sp.expand(second - ratio * first)
        if joint.geared is None:
            return self.symbol(joint)
        ratios = ((self.constant(f"ratio_{g.to.name}_{joint.name}", g.ratio), g.to) for g in joint.gears)
        return sp.expand(sp.Add(*(ratio * self.displacement(body) for ratio, body in ratios)))

    def absolute(self, body: Body | Ground) -> sp.Expr:
        """Displacement of a body relative to the ground; on a sliding body, a turning one turns by its coordinate."""
        if isinstance(body, Ground):
            return sp.Integer(0)
        carried = isinstance(body.on, Body) and body.on.turns == body.turns
        return self.displacement(body) + (self.absolute(body.on) if carried else 0)

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


def _values_of_constants(axis: Axis) -> dict[str, list[float]]:
    """Different ratios between two bodies, and accelerations of weights, by the name of their constant."""
    joints = (getattr(holder, "at", None) for holder in (*axis.elements, *axis.drives))
    pairs = [(gear.to.name, body.name, gear.ratio) for body in axis.bodies for gear in body.gears]
    pairs += [
        (joint.first.name, joint.second.name, joint.ratio)
        for joint in (*joints, *(sensor.joint for sensor in axis.sensors))
        if isinstance(joint, Between)
    ]
    named = [(f"ratio_{first}_{second}", ratio) for first, second, ratio in pairs]
    named += [("gravity", e.acceleration) for e in axis.elements if isinstance(e, (Weight, PendulumWeight))]
    by_name: dict[str, list[float]] = {}
    for name, value in named:
        values = by_name.setdefault(name, [])
        if value not in values:
            values.append(value)
    return by_name


def inverse_dynamics(axis: Axis) -> InverseDynamicModel:
    """Lagrange's equations of an axis: the paper's [3] and [4], for any axis.

    >>> from symid.axis import load_axis
    >>> print(inverse_dynamics(load_axis("rigid_1m")).equations[0])
    Eq(F, Fs*sign(q_motor_d1) + Fv*q_motor_d1 + M*q_motor_d2)
    """
    kinematics = Kinematics(axis)
    speeds = ((b.inertial, kinematics.rate(kinematics.absolute(b), 1)) for b in axis.bodies)
    kinetic = sp.Add(*(kinematics.parameter(name) * speed**2 for name, speed in speeds)) / 2
    potential = _quadratic(axis, kinematics, "q") + _weights(axis, kinematics)
    dissipation = _quadratic(axis, kinematics, "v")
    for sensor in axis.sensors:
        kinematics.displacement(sensor.joint)  # its ratio is a constant of the axis
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
        constants=dict(sorted(kinematics.constants.items())),
        known={name: value for name, value in axis.known_parameters.items() if value},
        balances=tuple(balances),
        inputs=inputs,
    )


def _quadratic(axis: Axis, kinematics: Kinematics, quantity: Literal["q", "v"]) -> sp.Expr:
    """Potential energy of forces linear in displacement ("q"), or Rayleigh's dissipation function ("v")."""
    forces: list[tuple[str, Joint]] = []
    for element in axis.elements:
        if isinstance(element, Law):
            forces += [(t.parameter, element.at) for t in element.terms() if t.expression == quantity]
        elif quantity == "q" and isinstance(element, Spring):
            forces.append((element.named("stiffness"), element.at))
        elif quantity == "v" and isinstance(element, (Spring, Damper)) and element.damping is not None:
            forces.append((element.named("damping"), element.at))
    order = "qv".index(quantity)
    motions = ((name, kinematics.rate(kinematics.displacement(at), order)) for name, at in forces)
    return sp.Add(*(kinematics.parameter(name) * motion**2 for name, motion in motions)) / 2


def _weights(axis: Axis, kinematics: Kinematics) -> sp.Expr:
    """Potential energy of constant weights. Those of pendulums are inputs, since sin q is not linear."""
    energy = sp.Integer(0)
    for element in axis.elements:
        if isinstance(element, Weight):
            gravity = kinematics.constant("gravity", element.acceleration)
            height = kinematics.absolute(element.body)
            energy += kinematics.parameter(element.body.inertial) * gravity * height * ONE_INPUT
    return energy


def _virtual_power(axis: Axis, kinematics: Kinematics) -> tuple[tuple[LawInput, ...], sp.Expr]:
    """Nonlinear laws as inputs, and the power of drives and laws, whose derivative by a velocity is a force."""
    inputs: dict[tuple[sp.Expr, sp.Expr], LawInput] = {}
    power = sp.Integer(0)
    for drive in axis.drives:
        gain = ONE if drive.constant is None else kinematics.parameter(drive.constant)
        power += gain * sp.Symbol(drive.signal) * kinematics.rate(kinematics.displacement(drive.at), 1)

    # Each nonlinear expression of a joint's motion is one input of the linear equations, whatever laws it stands in.
    # Its parameter is a coefficient; constant forces share the input 1.
    def resist(parameter: sp.Expr, expression: sp.Expr, joint: Joint, element: str) -> None:
        nonlocal power
        if parameter == 0:  # a known number
            return
        constant, displacement = not expression.free_symbols, kinematics.displacement(joint)
        key = (ONE, ONE) if constant else (expression, displacement)
        if key not in inputs:
            symbol = ONE_INPUT if constant else sp.Symbol(f"input_{len(inputs)}")
            inputs[key] = LawInput(symbol, ONE if constant else expression, joint, element)
        factor = expression if constant else ONE
        power -= parameter * factor * inputs[key].symbol * kinematics.rate(displacement, 1)

    for element in axis.elements:
        if isinstance(element, Law):
            at = element.at
            ends = (at.first.name, at.second.name) if isinstance(at, Between) else (at.name,)
            label = f"{type(element).__name__} at {' and '.join(map(repr, ends))}"
            for term in element.terms():
                if not term.is_linear:
                    resist(kinematics.parameter(term.parameter), law_expression(term.expression), at, label)
        elif isinstance(element, PendulumWeight):
            gravity = kinematics.constant("gravity", element.acceleration)
            moment = kinematics.parameter(element.named("moment")) * gravity
            at, label = Between(first=GROUND, second=element.body), f"PendulumWeight of {element.body.name!r}"
            resist(moment, sp.sin(sp.Symbol("q")), at, label)
        elif isinstance(element, Weight):
            weight = LawInput(ONE_INPUT, ONE, element.body, f"Weight of {element.body.name!r}")
            inputs.setdefault((ONE, ONE), weight)
    for sensor in axis.sensors:
        if sensor.offset is not None:
            offset = LawInput(ONE_INPUT, ONE, sensor.joint, f"offset of {sensor.signal!r}")
            inputs.setdefault((ONE, ONE), offset)
    return tuple(inputs.values()), power
