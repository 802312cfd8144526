"""The minimal model y = D X: outputs, regressor and minimal parameters.

Each equation is divided by the coefficient of the force of lowest derivative, which becomes its output. The
coefficients that remain are functions of the physical parameters; a basis of the space they span (over the numbers)
are the minimal parameters. Physical parameters that lie in that space are taken into the basis first, so that a
model that is linear in them is identified in them directly, as by [17] and [18]. The constant 1 comes first: terms
whose parameters are all known belong to the output.

Two orders of the parameters follow the paper. An equation linear in the physical parameters lists them by falling
order of derivative, as [8] and [18]; any other lists the derivatives of the force first, then the motion by rising
order, as [15].
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import prod
from typing import Any

import sympy as sp

from symid.axis import Axis
from symid.errors import EliminationError
from symid.signal_names import derivative_name, split_derivative
from symid.symbolic.elimination import InputOutputModel
from symid.symbolic.equations import InputOutputEquation
from symid.symbolic.expressions import exact
from symid.symbolic.parameter_function import ParameterFunction
from symid.symbolic.span import Span
from symid.units import Unit

_AFTER_ALL_DERIVATIVES = 1000
_ONE = 0
"""Place of the constant 1 in a basis."""


@dataclass(frozen=True)
class MinimalParameter:
    """One minimal parameter X_j."""

    name: str
    function: ParameterFunction
    unit: Unit


@dataclass(frozen=True)
class MinimalModel:
    """y = D X for each equation, D being the regressor and X the minimal parameters."""

    source: InputOutputModel  # the eliminated equations
    parameters: tuple[MinimalParameter, ...]  # X, in the paper's order
    output: tuple[sp.Expr, ...]  # y, one for each equation: a signal, less the terms of known parameters
    output_names: tuple[str, ...]  # flat name of that signal, with its sign
    regressor: tuple[tuple[sp.Expr, ...], ...]  # D, in flat signal names

    @property
    def written(self) -> tuple[str, ...]:
        """Each equation as text: y = X1*(column) + ..."""
        names = [parameter.name for parameter in self.parameters]
        return tuple(
            f"{y} = " + " + ".join(f"{name}*({e})" for name, e in zip(names, row, strict=True) if e != 0)
            for y, row in zip(self.output, self.regressor, strict=True)
        )


@dataclass(frozen=True)
class _Column:
    """One signal term with the function of the parameters that multiplies it, and its shares of the basis."""

    expression: sp.Expr
    order: int
    smooth: bool
    of_force: bool
    function: ParameterFunction
    shares: Mapping[int, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class _Row:
    """An equation: its output, and the columns that sum up to it."""

    output: sp.Expr
    columns: tuple[_Column, ...]


def minimise(model: InputOutputModel) -> MinimalModel:
    """Minimal parameters and regressor of the eliminated equations.

    >>> from symid.axis import load_axis
    >>> from symid.symbolic.elimination import eliminate
    >>> from symid.symbolic.lagrange import inverse_dynamics
    >>> axis = load_axis("direct_2m1s")
    >>> minimal = minimise(eliminate(inverse_dynamics(axis), axis.measured(("q2",))))
    >>> print(minimal.regressor[0])
    (-Fm_d2, -Fm_d1, q2_d1, sign(q2_d1), q2_d2, q2_d3, q2_d4)
    >>> print(minimal.parameters[4].function.expression)
    Fvm*Fvs/Ks + Mm
    """
    # Coefficients that are linear combinations of others need no parameter of their own: a basis of their span over the
    # numbers gives the minimal parameters, and each column is written in that basis.
    differentiated = {signal for e in model.equations for order, signal in e.force if order}
    axis = model.source.axis
    named = [*(drive.signal for drive in axis.drives), *(sensor.signal for sensor in axis.sensors)]
    drives = sorted(named, key=lambda signal: signal not in differentiated)
    basis, rows = _basis(model, [_with_output(equation, drives) for equation in model.equations])
    order = sorted(range(1, len(basis)), key=lambda j: _place(j, basis, rows))
    parameters = tuple(
        MinimalParameter(f"X{i + 1}", basis[j], _unit(j, basis, rows, axis)) for i, j in enumerate(order)
    )
    if not parameters:
        raise EliminationError(f"axis {axis.name!r}: the sensors do not depend on any unknown parameter")
    domain = model.operators.ring.domain

    def entry(row: _Row, j: int) -> sp.Expr:
        """Signal expression that basis function j multiplies in an equation."""
        held = ((column.shares[j], column.expression) for column in row.columns if j in column.shares)
        return sp.Add(*(domain.to_sympy(domain.convert(share)) * signal for share, signal in held))

    return MinimalModel(
        model,
        parameters,
        output=tuple(row.output - entry(row, _ONE) for row in rows),
        output_names=tuple(str(row.output) for row in rows),
        regressor=tuple(tuple(entry(row, j) for j in order) for row in rows),
    )


def _with_output(equation: InputOutputEquation, drives: Sequence[str]) -> _Row:
    """An equation divided by the coefficient of the force of lowest derivative, which becomes its output.

    Of several forces that enter so, one with a number for its coefficient goes first, then one that another equation
    differentiates: friction beside a drive is taken off its force where that is an output. Where this coefficient is
    a number, the sign of the equation is free: the highest derivative gets a positive one. An equation without force
    fixes its parameters up to a factor only: its highest derivative becomes its output.
    """
    ring = next(iter((*equation.force.values(), *(term.coefficient for term in equation.motion)))).ring
    positive = ring.domain.is_positive
    lowest = min(
        equation.force,
        key=lambda of: (of[0], not equation.force[of].is_ground, drives.index(of[1])),
        default=(0, ""),
    )
    divisor, sign = equation.force.get(lowest, ring.one), 1
    if divisor.is_ground:
        leading = max(equation.motion, key=lambda term: (term.smooth, term.order), default=None)
        flip = 1 if leading is None or any(map(positive, leading.coefficient.coeffs())) else -1
        sign = flip if positive(divisor.LC) else -flip
        divisor = divisor * sign
    columns = [
        _Column(
            -sp.Symbol(derivative_name(drive, order)),
            order,
            True,
            True,
            ParameterFunction.quotient(c, divisor),
        )
        for (order, drive), c in equation.force.items()
        if (order, drive) != lowest
    ]
    columns += [
        _Column(t.expression, t.order, t.smooth, False, ParameterFunction.quotient(t.coefficient, divisor))
        for t in equation.motion
    ]
    if equation.force:  # divided already: the columns are quotients by the coefficient of this force
        order, drive = lowest
        return _Row(sign * sp.Symbol(derivative_name(drive, order)), tuple(columns))
    leader = max((column for column in columns if column.smooth), key=lambda column: column.order)
    divisor = leader.function.numerator
    rest = (
        replace(c, function=ParameterFunction.quotient(-c.function.numerator, divisor))
        for c in columns
        if c is not leader
    )
    return _Row(leader.expression, tuple(rest))


def _basis(model: InputOutputModel, rows: Sequence[_Row]) -> tuple[list[ParameterFunction], list[_Row]]:
    """Functions that span all coefficients, the constant 1 first, and the rows with their shares of these."""
    ring, values = model.operators.ring, model.source.known
    known = {
        i: ring.domain.from_sympy(exact(values[str(symbol)]))
        for i, symbol in enumerate(ring.symbols)
        if str(symbol) in values
    }
    one = ParameterFunction(ring.one, ring.one)
    of_columns = [column.function for row in rows for column in row.columns]
    # The space that the coefficients span over the numbers is fixed; only its basis is a choice. Physical parameters
    # that lie in it go first, so that a model linear in them is identified in them; the coefficients fill up the rest.
    whole, span = Span(), Span()
    for function in (one, *of_columns):
        whole.add(function.coordinates(known))
    unknown = [generator for i, generator in enumerate(ring.gens) if i and i not in known]
    physical = (ParameterFunction(ring(generator), ring.one) for generator in unknown)
    candidates = [f for f in physical if whole.coordinates(f.coordinates(known)) is not None]
    others = (_without_constant(function, known) for function in of_columns)
    basis = [f for f in (one, *candidates, *others) if span.add(f.coordinates(known))]

    def with_shares(column: _Column) -> _Column:
        return replace(column, shares=span.coordinates(column.function.coordinates(known)) or {})

    return basis, [replace(row, columns=tuple(map(with_shares, row.columns))) for row in rows]


def _without_constant(function: ParameterFunction, known: Mapping[int, Any]) -> ParameterFunction:
    """A function less the terms in which all parameters are known."""
    if not known or not function.denominator.is_term:
        return function
    ((below, _),) = function.denominator.terms()
    terms = {
        m: c
        for m, c in function.numerator.terms()
        if any(a != b for i, (a, b) in enumerate(zip(m, below, strict=True)) if i not in known)
    }
    return ParameterFunction(function.numerator.ring.from_dict(terms), function.denominator)


def _unit(j: int, basis: Sequence[ParameterFunction], rows: Sequence[_Row], axis: Axis) -> Unit:
    """Unit of basis function j: that of an output over its column there.

    Where the function holds ratios, as J + r^2 M does, the units of its factors do not determine its own. They do for a
    physical parameter, and for a column in which numbers have units, such as the derivative of a cogging.
    """
    function, signals = basis[j], axis.signal_units
    if not function.is_parameter:
        columns = ((row, c.expression) for row in rows for c in row.columns if c.shares.get(j) == 1)
        for row, expression in columns:
            output, column = unit_of(row.output, signals), unit_of(expression, signals)
            if output and column:
                return output / column
    return function.unit(axis.parameter_units)


def _place(j: int, basis: Sequence[ParameterFunction], rows: Sequence[_Row]) -> tuple[int, ...]:
    """Sort key of basis function j: its first equation, and its place there."""
    i, row = next((i, row) for i, row in enumerate(rows) if any(j in c.shares for c in row.columns))
    holders = [column for column in row.columns if j in column.shares]
    if all(basis[k].is_linear for column in row.columns for k in column.shares if k != _ONE):
        return i, 0, *min((-c.order, int(not c.smooth)) for c in holders), j
    rising = (
        (0, -c.order, 0)
        if c.of_force
        else (1, c.order if c.order >= 0 else _AFTER_ALL_DERIVATIVES, int(not c.smooth))
        for c in holders
    )
    return i, *min(rising), j


def unit_of(expression: sp.Expr, signals: Mapping[str, Unit]) -> Unit | None:
    """Unit of an expression in flat signal names; None if a number in it has a unit, such as that of a pitch.

    >>> v = sp.Symbol("q_d1")
    >>> str(unit_of(v * sp.Abs(v) * sp.sign(v), {"q": Unit.of("m")}))
    'm^2/s^2'
    >>> unit_of(12.6 * v**2 * sp.sin(12.6 * sp.Symbol("q")) + sp.Symbol("q_d2"), {"q": Unit.of("m")}) is None
    True
    """
    match expression:
        case sp.Symbol():
            signal, order = split_derivative(expression.name)
            return signals.get(signal, Unit()) / Unit.of("s") ** order
        case sp.Mul():
            factors = [unit_of(factor, signals) for factor in expression.args]
            known = [unit for unit in factors if unit is not None]
            return prod(known, start=Unit()) if len(known) == len(factors) else None
        case sp.Pow() if expression.exp.is_Integer:
            base = unit_of(expression.base, signals)
            return base and base ** int(expression.exp)
        case sp.Abs():
            return unit_of(expression.args[0], signals)
        case sp.Add():
            # The units of ratios and of gravity are not known here: a term without them determines the unit.
            plain = [term for term in expression.args if _holds_signals_only(term, signals)]
            units = {unit_of(term, signals) for term in plain}
            return units.pop() if len(units) == 1 else None
        case _:
            return Unit()


def _holds_signals_only(term: sp.Expr, signals: Mapping[str, Unit]) -> bool:
    names = {split_derivative(str(symbol))[0] for symbol in term.free_symbols}
    return bool(names) and names <= set(signals)
