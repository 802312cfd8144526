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

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import prod
from operator import sub
from typing import Any

import sympy as sp
from sympy.polys.rings import PolyElement

from symid.errors import EliminationError
from symid.signals import derivative_name
from symid.symbolic.elimination import InputOutputModel
from symid.symbolic.equations import InputOutputEquation
from symid.symbolic.expressions import exact
from symid.symbolic.polynomials import quotient_if_whole
from symid.symbolic.span import Span
from symid.units import Unit

_AFTER_ALL_DERIVATIVES = 1000
_LONG = 200
"""Terms from which on a function is not written by sympy."""
_ONE = 0
"""Place of the constant 1 in a basis."""


@dataclass(frozen=True)
class ParameterFunction:
    """A rational function of the physical parameters in the ring of the operator model, reduced by common monomials."""

    numerator: PolyElement
    denominator: PolyElement

    @classmethod
    def quotient(cls, numerator: PolyElement, denominator: PolyElement) -> ParameterFunction:
        """numerator / denominator in lowest terms, as far as monomials and exact division go."""
        ring = numerator.ring
        if not denominator.is_term and len(numerator) >= len(denominator):
            whole = quotient_if_whole(numerator, denominator)
            if whole is not None:
                return cls(whole, ring.one)
        shared = tuple(
            min(powers) for powers in zip(*numerator.itermonoms(), *denominator.itermonoms(), strict=True)
        )
        sign = ring.domain.one if ring.domain.is_positive(denominator.LC) else -ring.domain.one
        scale = 1 / (denominator.LC if denominator.is_term else sign)
        if not any(shared) and scale == ring.domain.one:
            return cls(numerator, denominator)
        return cls(_over_monomial(numerator, shared, scale), _over_monomial(denominator, shared, scale))

    @cached_property
    def monomials(self) -> dict[Any, Any]:
        """Vector of its monomials; functions with the same polynomial denominator share a space."""
        if self.denominator.is_term:
            ((powers, scale),) = self.denominator.terms()
            below = ""
        else:
            powers, scale = (0,) * len(self.numerator.ring.gens), self.numerator.ring.domain.one
            below = str(self.denominator)
        if not any(powers) and scale == self.numerator.ring.domain.one:
            return {(below, m): c for m, c in self.numerator.terms()}
        return {(below, tuple(map(sub, m, powers))): c / scale for m, c in self.numerator.terms()}

    def coordinates(self, known: Mapping[int, Any]) -> dict[Any, Any]:
        """Vector of its monomials in the unknown parameters; `known` gives generators their values."""
        if not known:
            return self.monomials
        total: dict[Any, Any] = {}
        for (below, powers), c in self.monomials.items():
            key = (below, tuple(0 if i in known else power for i, power in enumerate(powers)))
            factor = prod((value ** powers[i] for i, value in known.items() if powers[i]), start=c)
            total[key] = total.get(key, 0) + factor
        return {key: c for key, c in total.items() if c}

    @property
    def names(self) -> set[str]:
        """Names of the physical parameters in it."""
        powers = zip(*self.numerator.itermonoms(), *self.denominator.itermonoms(), strict=True)
        return {str(x) for x, used in zip(self.numerator.ring.symbols, powers, strict=True) if any(used)}

    @property
    def is_linear(self) -> bool:
        """Whether it is a sum of physical parameters times numbers."""
        return self.denominator.is_ground and all(sum(m) == 1 for m in self.numerator.itermonoms())

    @cached_property
    def expression(self) -> sp.Expr:
        """As a sum of fractions, each over the monomial that is left below it."""
        ring = self.numerator.ring
        if not self.denominator.is_term:
            return self.numerator.as_expr() / self.denominator.as_expr()
        fractions: dict[sp.Expr, list[sp.Expr]] = {}
        for (_, powers), coefficient in self.monomials.items():
            above = sp.Mul(*(g**p for g, p in zip(ring.symbols, powers, strict=True) if p > 0))
            below = sp.Mul(*(g**-p for g, p in zip(ring.symbols, powers, strict=True) if p < 0))
            fractions.setdefault(below, []).append(ring.domain.to_sympy(coefficient) * above)
        return sp.Add(*(sp.Add(*terms) / below for below, terms in fractions.items()))

    def __str__(self) -> str:
        """Its expression; a long one term by term, which sympy would take minutes to sort."""
        if len(self.numerator) <= _LONG or not self.denominator.is_term:
            return str(self.expression)
        names, field = list(map(str, self.numerator.ring.symbols)), self.numerator.ring.domain
        written = []
        for (_, powers), c in self.monomials.items():
            factors = [f"{n}**{p}" if p != 1 else n for n, p in zip(names, powers, strict=True) if p]
            written.append("*".join(factors if c == 1 else [f"({field.to_sympy(c)})", *factors]))
        return " + ".join(written)

    def unit(self, units: dict[str, Unit]) -> Unit:
        """Unit, given those of the physical parameters."""
        total = Unit()
        names = [str(symbol) for symbol in self.numerator.ring.symbols[1:]]
        for sign, part in ((1, self.numerator), (-1, self.denominator)):
            for name, power in zip(names, part.LM[1:], strict=True):
                total = total * units[name] ** (sign * power) if power else total
        return total


def _over_monomial(polynomial: PolyElement, powers: tuple[int, ...], scale: Any) -> PolyElement:
    """scale * polynomial / monomial."""
    return polynomial.new({tuple(map(sub, m, powers)): c * scale for m, c in polynomial.items()})


@dataclass(frozen=True)
class MinimalParameter:
    """One minimal parameter X_j."""

    name: str
    function: ParameterFunction
    unit: Unit


@dataclass(frozen=True)
class MinimalModel:
    """y = D X for each equation, D being the regressor and X the minimal parameters.

    Parameters
    ----------
    source : InputOutputModel
        The eliminated equations.
    parameters : tuple of MinimalParameter
        X, in the paper's order.
    output : tuple of sympy.Expr
        y, one for each equation: a signal, less the terms of known parameters.
    output_names : tuple of str
        Flat name of that signal, with its sign.
    regressor : tuple of tuple of sympy.Expr
        D, in flat signal names.
    """

    source: InputOutputModel
    parameters: tuple[MinimalParameter, ...]
    output: tuple[sp.Expr, ...]
    output_names: tuple[str, ...]
    regressor: tuple[tuple[sp.Expr, ...], ...]

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

    Examples
    --------
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
    differentiated = {signal for e in model.equations for order, signal in e.force if order}
    drives = sorted(
        (drive.signal for drive in model.source.axis.drives), key=lambda signal: signal not in differentiated
    )
    basis, rows = _basis(model, [_with_output(equation, drives) for equation in model.equations])
    order = sorted(range(1, len(basis)), key=lambda j: _place(j, basis, rows))
    units = model.source.axis.parameter_units
    parameters = tuple(
        MinimalParameter(f"X{i + 1}", basis[j], basis[j].unit(units)) for i, j in enumerate(order)
    )
    if not parameters:
        raise EliminationError(
            f"axis {model.source.axis.name!r}: the sensors see nothing of the parameters that are not known"
        )
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


def _known_generators(model: InputOutputModel) -> dict[int, Any]:
    """Values of the generators that are known parameters, by index."""
    ring = model.operators.ring
    known = model.source.known
    return {
        i: ring.domain.from_sympy(exact(known[str(symbol)]))
        for i, symbol in enumerate(ring.symbols)
        if str(symbol) in known
    }


def _with_output(equation: InputOutputEquation, drives: Sequence[str]) -> _Row:
    """An equation divided by the coefficient of the force of lowest derivative, which becomes its output.

    Of several forces that enter so, one with a number for its coefficient goes first, then one that another equation
    differentiates: friction beside a drive is taken off its force where that is an output. Where this coefficient is
    a number, the sign of the equation is free: the highest derivative gets a positive one. An equation without force
    fixes its parameters up to a factor only: its highest derivative becomes its output.
    """
    ring = equation.motion[0].coefficient.ring
    positive = ring.domain.is_positive
    lowest = min(
        equation.force,
        key=lambda of: (of[0], not equation.force[of].is_ground, drives.index(of[1])),
        default=(0, ""),
    )
    divisor, sign = equation.force.get(lowest, ring.one), 1
    if divisor.is_ground:
        leading = max(equation.motion, key=lambda term: (term.smooth, term.order)).coefficient
        flip = 1 if any(map(positive, leading.coeffs())) else -1
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
    if equation.force:
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
    ring, known = model.operators.ring, _known_generators(model)
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
