"""Ratios of gears as units of coordinates: elimination without them.

A ratio r that stands between two displacements can be made 1: measured in other units, x = r^k x', balances times
powers of r and parameters p = r^w p' hold no r. Where all coefficients are numbers times powers of ratios, exponents
solve a linear system, which has a solution for every tree of gears and springs. Elimination is
fast with polynomials over the numbers. Ratios in a loop, and in sums such as 1 + r, cannot be taken out; they become
numbers.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import prod
from operator import mul
from typing import Any, NamedTuple

from sympy import QQ
from sympy.polys.fields import FracElement
from sympy.polys.matrices import DomainMatrix
from sympy.polys.rings import PolyElement, PolyRing

from symid.symbolic.expressions import exact
from symid.symbolic.kernel import EliminationRow
from symid.symbolic.operators import OperatorModel, Row, add

Exponents = tuple[int, ...]
"""Of the ratios of a coefficient field, in their order."""


@dataclass(frozen=True)
class Scaling:
    """Powers of the ratios by which balances, columns and parameters are multiplied."""

    # balances, columns, parameters: by name; parameter p is the power of the ratios times that of the scaled axis
    balances: Mapping[str, Exponents]
    columns: Mapping[str, Exponents]
    parameters: Mapping[str, Exponents]
    plain: PolyRing  # ring of the scaled axis, over the numbers
    ring: PolyRing  # ring of the axis

    def scaled(self, row: Row) -> Row:
        """A row of the scaled axis."""
        return {
            column: self.plain.from_dict({m: term_of(c)[0] for m, c in entry.terms()})
            for column, entry in row.items()
        }

    def operators(self, operators: OperatorModel, rows: Mapping[str, Row]) -> OperatorModel:
        """Forces and laws of the scaled axis; its motion is left out."""
        inputs = {b: self.scaled(row) for b, row in _split_inputs(operators, rows).items()}
        force = {balance: self.scaled(row) for balance, row in operators.force.items()}
        return replace(operators, ring=self.plain, motion={}, inputs=inputs, force=force)

    def restored(self, row: EliminationRow, ring: PolyRing, constants: Mapping[str, float]) -> EliminationRow:
        """A combination of balances of the axis for one of the scaled axis; its first multiplier begins with 1.

        In the coefficients of the ring of the axis, ratios are symbols or numbers; `constants` holds their values.
        """
        powers = _Powers(self.ring.domain.symbols, ring, constants)
        multipliers = {
            b: self._with_ratios(e, self.balances[b], ring, powers) for b, e in row.multipliers.items()
        }
        scale = ring.domain.one / next(iter(multipliers.values())).LC
        entries = {
            c: self._with_ratios(e, tuple(-k for k in self.columns[c]), ring, powers)
            for c, e in row.entries.items()
        }
        if scale == ring.domain.one:
            return EliminationRow(multipliers, entries)
        return EliminationRow(
            {b: entry.mul_ground(scale) for b, entry in multipliers.items()},
            {c: entry.mul_ground(scale) for c, entry in entries.items()},
        )

    def _with_ratios(
        self, entry: PolyElement, power: Exponents, ring: PolyRing, powers: _Powers
    ) -> PolyElement:
        """A polynomial in the parameters of the axis, times a power of the ratios."""
        own = [self.parameters[str(symbol)] for symbol in self.ring.symbols[1:]]
        # exponents of all ratios in one number, which finds terms of equal exponents quickly
        packed = [0, *(sum(w << 20 * k for k, w in enumerate(weights)) for weights in own)]
        exponents: dict[int, Exponents] = {}
        terms = {}
        for m, c in entry.items():
            key = sum(map(mul, m, packed))
            if key not in exponents:
                used = list(zip(m[1:], own, strict=True))
                exponents[key] = tuple(p - sum(n * w[k] for n, w in used) for k, p in enumerate(power))
            terms[m] = powers.times(c, exponents[key])
        return ring.zero.new(terms)


class _Powers:
    """Products of powers of ratios as elements of a coefficient field, each made once."""

    def __init__(self, symbols: Sequence[Any], ring: PolyRing, constants: Mapping[str, float]) -> None:
        self.field = ring.domain
        kept = () if self.field == QQ else self.field.symbols
        self._bases = [
            self.field(self.field.gens[kept.index(x)])
            if x in kept
            else self.field.from_sympy(exact(constants[str(x)]))
            for x in symbols
        ]
        self._known: dict[Exponents, Any] = {}

    def times(self, number: Any, exponents: Exponents) -> Any:
        """A number times the ratios to the power of the exponents."""
        if exponents not in self._known:
            factors = (base**n for base, n in zip(self._bases, exponents, strict=True) if n)
            self._known[exponents] = prod(factors, start=self.field.one)
        power = self._known[exponents]
        if isinstance(power, FracElement):
            return power.raw_new(power.numer.mul_ground(number), power.denom)
        return power * number


def scaling_of(rows: Mapping[str, Row], operators: OperatorModel) -> Scaling | tuple[str, ...]:
    """Scaling that takes all ratios out of rows of the motion, forces and laws; else the ratios that remain.

    The coefficient field of the operators is that of the ratios.
    """
    ring = operators.ring
    ratios = [str(symbol) for symbol in ring.domain.symbols]
    terms = list(_terms(rows, operators))
    mixed = {
        name for term in terms if term_of(term.coefficient)[1] is None for name in _names_in(term.coefficient)
    }
    if mixed:
        return tuple(name for name in ratios if name in mixed)
    names = [str(symbol) for symbol in ring.symbols[1:]]
    own = _constants_of_laws(operators, rows)
    unknowns = {("balance", b): i for i, b in enumerate(dict.fromkeys(term.balance for term in terms))}
    for key in (
        *(("column", c) for c in dict.fromkeys(term.column for term in terms)),
        *(("parameter", p) for p in names),
    ):
        unknowns[key] = len(unknowns)
    found = {key: [0] * len(ratios) for key in unknowns}
    stuck = []
    for k, ratio in enumerate(ratios):
        if ratio in own:
            continue
        solved = _exponents(terms, names, unknowns, k)
        if solved is None:
            stuck.append(ratio)
            continue
        for key, i in unknowns.items():
            found[key][k] = solved[i]
    if stuck:
        return tuple(stuck)
    balances, columns, parameters = (
        {name: tuple(powers) for (kind, name), powers in found.items() if kind == wanted}
        for wanted in ("balance", "column", "parameter")
    )
    plain = PolyRing(ring.symbols, QQ, ring.order)
    return Scaling(balances, columns, parameters, plain, ring)


def term_of(coefficient: Any) -> tuple[Any, Exponents | None]:
    """Number and exponents of a coefficient that is a number times powers of ratios; None where it is not."""
    if not isinstance(coefficient, FracElement):
        return coefficient, ()
    above, below = coefficient.numer, coefficient.denom
    if not (above.is_term and below.is_term):
        return coefficient, None
    ((up, a),), ((down, b),) = above.terms(), below.terms()
    return a / b, tuple(x - y for x, y in zip(up, down, strict=True))


class _Term(NamedTuple):
    """A term of an entry: its row and column, and the polynomial's monomial and coefficient."""

    balance: str
    column: str
    monomial: tuple[int, ...]
    coefficient: Any


def _terms(rows: Mapping[str, Row], operators: OperatorModel) -> Iterator[_Term]:
    """Every term of the equations; forces and laws have separate columns."""
    inputs = _split_inputs(operators, rows)
    for balance, row in rows.items():
        columns = {
            **row,
            **inputs[balance],
            **{f"force {signal}": entry for signal, entry in operators.force[balance].items()},
        }
        for column, entry in columns.items():
            yield from (_Term(balance, column, monomial, c) for monomial, c in entry.terms())


def _constants_of_laws(operators: OperatorModel, rows: Mapping[str, Row]) -> set[str]:
    """Constants that stand in laws alone, such as gravity: elimination does not meet them."""
    entries = [entry for row in (*rows.values(), *operators.force.values()) for entry in row.values()]
    met = {name for entry in entries for c in entry.coeffs() for name in _names_in(c)}
    return {str(symbol) for symbol in operators.ring.domain.symbols} - met


def _split_inputs(operators: OperatorModel, rows: Mapping[str, Row]) -> dict[str, Row]:
    """Laws by balance, with a column for each power of the constants that stand in laws alone."""
    symbols = [str(symbol) for symbol in operators.ring.domain.symbols]
    own = [symbols.index(name) for name in sorted(_constants_of_laws(operators, rows))]
    split: dict[str, Row] = {}
    for balance, row in operators.inputs.items():
        parts: Row = {}
        for column, entry in row.items():
            for monomial, c in entry.terms():
                exponents = term_of(c)[1]
                power = "".join(f"*{symbols[k]}^{exponents[k]}" for k in own if exponents and exponents[k])
                parts = add(parts, {column + power: operators.ring({monomial: c})}, operators.ring.one)
        split[balance] = parts
    return split


def _names_in(coefficient: Any) -> set[str]:
    parts = (coefficient.numer, coefficient.denom)
    return {str(x) for part in parts for i, x in enumerate(part.ring.symbols) if part.degree(i) > 0}


def _exponents(
    terms: list[_Term],
    names: list[str],
    unknowns: Mapping[tuple[str, str], int],
    ratio: int,
) -> list[int] | None:
    """Exponents that remove one ratio from every term; None if no whole numbers do."""
    equations: dict[tuple[tuple[int, int], ...], int] = {}
    for balance, column, monomial, c in terms:
        sums = {unknowns["balance", balance]: 1}
        column_place = unknowns["column", column]
        sums[column_place] = 1
        for name, power in zip(names, monomial[1:], strict=True):
            if power:
                sums[unknowns["parameter", name]] = power
        exponents = term_of(c)[1]
        assert exponents is not None
        key, value = tuple(sorted(sums.items())), -exponents[ratio]
        if equations.setdefault(key, value) != value:
            return None
    width = len(unknowns)
    matrix = [
        [QQ(dict(key).get(i, 0)) for i in range(width)] + [QQ(value)] for key, value in equations.items()
    ]
    reduced, pivots = DomainMatrix(matrix, (len(matrix), width + 1), QQ).rref()
    if width in pivots:
        return None
    solution = [0] * width
    for row, pivot in zip(reduced.to_list(), pivots, strict=False):
        if row[width].denominator != 1:
            return None
        solution[pivot] = int(row[width].numerator)
    return solution
