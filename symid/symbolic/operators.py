"""Equations of motion as a matrix of polynomials in s = d/dt, in absolute coordinates.

In absolute coordinates each row is the force balance of one free body, and a spring joins two bodies only. The matrix
is as sparse as the axis, so elimination is fast (a chain becomes a three-term recursion). The paper's [17] follows
directly: its second equation is the balance of the structure alone.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import sympy as sp
from sympy import QQ
from sympy.polys.rings import PolyElement, PolyRing

from symid.axis import Axis
from symid.symbolic.expressions import exact
from symid.symbolic.lagrange import InverseDynamicModel, Kinematics

Row = dict[str, PolyElement]
"""Polynomial entries by column; absent entries are zero."""
Functional: TypeAlias = Mapping[str, Any]
"""A displacement as coefficients of the bodies' absolute displacements, elements of the ring's domain."""


@dataclass(frozen=True)
class OperatorModel:
    """sum_b A[i, b](s) x_b + sum_w N[i, w] w + sum_k B[i, k] F_k = 0 for the balance of each free body i."""

    source: InverseDynamicModel  # Lagrange's equations
    ring: (
        PolyRing  # in s, the first generator, and the physical parameters, over the field of known constants
    )
    motion: Mapping[str, Row]  # operators on the absolute displacements, by balance and body
    inputs: Mapping[str, Row]  # coefficients of the nonlinear laws, by balance and input symbol
    force: Mapping[str, Row]  # coefficients of the drive forces, by balance and signal
    numbers: Mapping[sp.Symbol, sp.Rational] = field(default_factory=dict)  # constants held as numbers

    def element(self, expression: sp.Expr) -> Any:
        """A known number, or an expression of ratios, as an element of the coefficient field."""
        return self.ring.domain.from_sympy(sp.sympify(expression).xreplace(self.numbers))

    def functional(self, displacement: sp.Expr) -> dict[str, Any]:
        """A displacement as coefficients (elements of the ring's domain) of absolute displacements, by body."""
        axis, kinematics = self.source.axis, Kinematics(self.source.axis)
        relative = {
            body.name: self.element(coefficient)
            for body in axis.free_bodies
            if (coefficient := displacement.coeff(kinematics.symbol(body))) != 0
        }
        return relative_to_absolute(relative, parents(axis))


def operator_model(model: InverseDynamicModel, numbers: Sequence[str] = ()) -> OperatorModel:
    """Balances of the free bodies as operator rows in absolute coordinates x = T q: T^-T times Lagrange's equations.

    The coefficients hold constants in `numbers` as numbers, not as symbols.
    """
    axis, parent_of = model.axis, parents(model.axis)
    values = {sp.Symbol(name): exact(model.constants[name]) for name in numbers}
    constants = [sp.Symbol(name) for name in model.constants if name not in numbers]
    names = [name for name in axis.parameter_units if axis.known_parameters.get(name) != 0]
    domain = QQ.frac_field(*constants) if constants else QQ
    ring = PolyRing((sp.Symbol("s"), *map(sp.Symbol, names)), domain)
    lagrange = {
        body.name: _split(balance.xreplace(values), ring, model)
        for body, balance in zip(axis.free_bodies, model.balances, strict=True)
    }
    motion: dict[str, Row] = {}
    inputs: dict[str, Row] = {}
    force: dict[str, Row] = {}
    # Lagrange's equation of a body contains the forces on what it carries; subtracting those leaves its own balance.
    for body in parent_of:
        balance = lagrange[body]
        for carried in (child for child, parent in parent_of.items() if parent == body):
            balance = add(balance, lagrange[carried], ring(-1))
        motion[body] = relative_to_absolute({b: balance[b] for b in parent_of if b in balance}, parent_of)
        inputs[body] = {
            str(w.symbol): balance[str(w.symbol)] for w in model.inputs if str(w.symbol) in balance
        }
        force[body] = {d.signal: balance[d.signal] for d in axis.drives if d.signal in balance}
    return OperatorModel(model, ring, motion, inputs, force, values)


def add(row: Mapping[Any, Any], other: Mapping[Any, Any], factor: Any) -> dict[Any, Any]:
    """row + factor * other, without zero entries."""
    total = dict(row)
    for column, entry in other.items():
        value = total[column] + factor * entry if column in total else factor * entry
        if value:
            total[column] = value
        else:
            del total[column]
    return total


def by_power(entry: PolyElement | None) -> dict[int, PolyElement]:
    """Coefficients of a polynomial by powers of s, as polynomials in the parameters."""
    if entry is None:
        return {}
    powers: dict[int, dict[tuple[int, ...], Any]] = {}
    for monomial, value in entry.terms():
        powers.setdefault(monomial[0], {})[(0, *monomial[1:])] = value
    return {power: entry.ring.from_dict(terms) for power, terms in powers.items()}


def parents(axis: Axis) -> dict[str, str | None]:
    """For each free body, the free body that carries it if their displacements add up, else None."""
    return {body.name: body.parent.name if body.parent else None for body in axis.free_bodies}


def relative_to_absolute(relative: Mapping[str, Any], parent_of: Mapping[str, str | None]) -> dict[str, Any]:
    """Coefficients of absolute coordinates from those of relative ones: q_b = x_b - x_parent."""
    absolute: dict[str, Any] = {}
    for body, coefficient in relative.items():
        absolute = add(absolute, {body: coefficient}, 1)
        parent = parent_of[body]
        if parent is not None:
            absolute = add(absolute, {parent: coefficient}, -1)
    return absolute


def _split(balance: sp.Expr, ring: PolyRing, model: InverseDynamicModel) -> Row:
    """One of Lagrange's equations by column: body (a polynomial in s), law input, drive."""
    kinematics = Kinematics(model.axis)
    columns: dict[sp.Symbol, tuple[str, int]] = {
        kinematics.symbol(body, order): (body.name, order)
        for body in model.axis.free_bodies
        for order in range(3)
    }
    columns.update({w.symbol: (str(w.symbol), 0) for w in model.inputs})
    columns.update({sp.Symbol(drive.signal): (drive.signal, 0) for drive in model.axis.drives})
    parameters = ring.symbols[1:]
    polynomial = PolyRing((*parameters, *columns), ring.domain).from_expr(balance)
    places = list(columns.values())
    row: Row = {}
    for monomial, coefficient in polynomial.terms():
        powers, signals = monomial[: len(parameters)], monomial[len(parameters) :]
        name, order = places[signals.index(1)]
        row = add(row, {name: ring({(order, *powers): coefficient})}, ring.one)
    return row
