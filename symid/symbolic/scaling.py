"""Removal of gear ratios before elimination, by a choice of units.

A ratio r between two displacements disappears if displacements are measured in other units, x = r^k x', balances are
multiplied by powers of r, and parameters are scaled as p = r^w p'. If all coefficients are numbers times powers of
ratios, the exponents solve a linear system, which has a solution for every tree of gears and springs. Elimination is
then fast, since polynomials have numbers for coefficients. Ratios in a loop of gears, and in sums such as 1 + r, cannot
be removed and are replaced by numbers.
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
"""Exponents of the ratios of a coefficient field, in their order."""


@dataclass(frozen=True)
class Scaling:
    """Powers of the ratios by which balances, columns and parameters are multiplied, by name."""

    balances: Mapping[str, Exponents]
    columns: Mapping[str, Exponents]
    parameters: Mapping[str, Exponents]  # a parameter is this power times that of the scaled axis
    plain: PolyRing  # ring of the scaled axis, over the numbers
    ring: PolyRing  # ring of the axis

    def scaled(self, row: Row) -> Row:
        """The row of the scaled axis for one of the axis."""
        return {
            column: self.plain.from_dict({m: term_of(c)[0] for m, c in entry.terms()})
            for column, entry in row.items()
        }

    def operators(self, operators: OperatorModel, rows: Mapping[str, Row]) -> OperatorModel:
        """Forces and laws of the scaled axis; its motion is omitted."""
        inputs = {b: self.scaled(row) for b, row in _split_inputs(operators, rows).items()}
        force = {balance: self.scaled(row) for balance, row in operators.force.items()}
        return replace(operators, ring=self.plain, motion={}, inputs=inputs, force=force)

    def restored(self, row: EliminationRow, ring: PolyRing, constants: Mapping[str, float]) -> EliminationRow:
        """The combination of balances of the axis for one of the scaled axis; the first multiplier starts with 1.

        The coefficients of `ring` hold ratios as symbols or numbers; `constants` gives their values.
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
        exponents_of = [self.parameters[str(symbol)] for symbol in self.ring.symbols[1:]]
        # The exponents of all ratios are packed into one integer, by which terms of equal exponents are found quickly.
        packed = [0, *(sum(w << 20 * k for k, w in enumerate(weights)) for weights in exponents_of)]
        exponents: dict[int, Exponents] = {}
        terms = {}
        for m, c in entry.items():
            key = sum(map(mul, m, packed))
            if key not in exponents:
                used = list(zip(m[1:], exponents_of, strict=True))
                exponents[key] = tuple(p - sum(n * w[k] for n, w in used) for k, p in enumerate(power))
            terms[m] = powers.times(c, exponents[key])
        return ring.zero.new(terms)


class _Powers:
    """Products of powers of ratios as elements of a coefficient field, each computed once."""

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
        """A number times the ratios, each to its exponent."""
        if exponents not in self._known:
            factors = (base**n for base, n in zip(self._bases, exponents, strict=True) if n)
            self._known[exponents] = prod(factors, start=self.field.one)
        power = self._known[exponents]
        if isinstance(power, FracElement):
            return power.raw_new(power.numer.mul_ground(number), power.denom)
        return power * number


def scaling_of(rows: Mapping[str, Row], operators: OperatorModel) -> Scaling | tuple[str, ...]:
    """Scaling that removes all ratios from motion, forces and laws, or the names of the ratios that cannot be removed.

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
    of_laws = _constants_of_laws(operators, rows)
    # Each balance is multiplied, each column and parameter scaled, by a product of powers of the ratios; the exponents
    # are sought, one ratio after the other.
    keys = (
        *(("balance", b) for b in dict.fromkeys(term.balance for term in terms)),
        *(("column", c) for c in dict.fromkeys(term.column for term in terms)),
        *(("parameter", p) for p in names),
    )
    unknowns = {key: i for i, key in enumerate(keys)}
    solved = [
        [0] * len(keys) if ratio in of_laws else _exponents(terms, names, unknowns, k)
        for k, ratio in enumerate(ratios)
    ]
    if None in solved:
        return tuple(ratio for ratio, exponents in zip(ratios, solved, strict=True) if exponents is None)
    powers_of = dict(
        zip(keys, zip(*(exponents for exponents in solved if exponents), strict=True), strict=True)
    )
    balances, columns, parameters = (
        {name: powers for (kind, name), powers in powers_of.items() if kind == wanted}
        for wanted in ("balance", "column", "parameter")
    )
    plain = PolyRing(ring.symbols, QQ, ring.order)
    return Scaling(balances, columns, parameters, plain, ring)


def term_of(coefficient: Any) -> tuple[Any, Exponents | None]:
    """Number and exponents of a coefficient that is a number times powers of ratios; None as exponents otherwise.

    >>> from sympy import QQ
    >>> field = QQ.frac_field("r", "s")
    >>> term_of(3 * field.gens[0] ** 2 / field.gens[1])
    (3, (2, -1))
    """
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
    """Constants that occur in laws only, such as gravity, so that elimination is not concerned."""
    entries = [entry for row in (*rows.values(), *operators.force.values()) for entry in row.values()]
    met = {name for entry in entries for c in entry.coeffs() for name in _names_in(c)}
    return {str(symbol) for symbol in operators.ring.domain.symbols} - met


def _split_inputs(operators: OperatorModel, rows: Mapping[str, Row]) -> dict[str, Row]:
    """Laws by balance, with a column for each power of the constants that occur in laws only."""
    symbols = [str(symbol) for symbol in operators.ring.domain.symbols]
    places = [symbols.index(name) for name in sorted(_constants_of_laws(operators, rows))]
    split: dict[str, Row] = {}
    for balance, row in operators.inputs.items():
        parts: Row = {}
        for column, entry in row.items():
            for monomial, c in entry.terms():
                exponents = term_of(c)[1]
                power = "".join(f"*{symbols[k]}^{exponents[k]}" for k in places if exponents and exponents[k])
                parts = add(parts, {column + power: operators.ring({monomial: c})}, operators.ring.one)
        split[balance] = parts
    return split


def _names_in(coefficient: Any) -> set[str]:
    parts = (coefficient.numer, coefficient.denom)
    return {str(x) for part in parts for i, x in enumerate(part.ring.symbols) if part.degree(i) > 0}


def _exponents(
    terms: list[_Term], names: list[str], unknowns: Mapping[tuple[str, str], int], ratio: int
) -> list[int] | None:
    """Exponents that remove one ratio from every term; None if no integers do."""
    # One equation per term: the exponents of its balance, its column and its parameters cancel that of the ratio.
    equations: dict[tuple[tuple[int, int], ...], int] = {}
    for balance, column, monomial, c in terms:
        sums = {unknowns["balance", balance]: 1, unknowns["column", column]: 1}
        powers = zip(names, monomial[1:], strict=True)
        sums |= {unknowns["parameter", name]: power for name, power in powers if power}
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
