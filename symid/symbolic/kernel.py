"""Minimal bases of the multipliers that eliminate columns from a matrix of polynomials in s.

`left_kernel` gives multipliers l(s) with l(s) A(s) = 0, `divisible` those that also make columns divisible by a
power of s. Both bases are row-reduced: no other basis has lower degrees, so none differentiates the balances less.
Where their polynomials grow too large, `local_kernel` gives another basis: each balance that is not needed to determine
the unknown displacements, combined with those that are.

A single multiplier consists of minors of the matrix (Cramer's rule). Several come from the order-basis algorithm
(Beckermann and Labahn, SIAM J. Matrix Anal. Appl. 15 (1994) 804; M-basis in Giorgi, Jeannerod and Villard, ISSAC 2003):
conditions on the coefficients of s^0, s^1, ... are met one by one, each by multiplying the row of lowest degree by s.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from math import gcd, prod
from random import Random

from sympy import GF
from sympy.polys.matrices import DomainMatrix
from sympy.polys.rings import PolyElement, PolyRing

from symid.errors import EliminationError
from symid.symbolic.operators import Row, add, by_power
from symid.symbolic.polynomials import (
    Budget,
    Minors,
    TooLargeError,
    common_divisor,
    connected,
    from_flint,
    product_of,
    quotient,
    to_flint,
)

MOST_KERNEL_PRODUCTS = 200_000
"""Largest number of term products in a step of an order basis."""
MOST_PRODUCTS_IN_ALL = 60_000
"""Largest number in all steps: half a second, and more than any useful formula needs."""
_PRIME = 2**31 - 1


@dataclass(frozen=True)
class EliminationRow:
    """A combination of balances: multipliers by balance, and the resulting entries by column."""

    multipliers: Row
    entries: Row

    def combine(
        self, factor: PolyElement, other: EliminationRow, other_factor: PolyElement
    ) -> EliminationRow:
        """factor * self + other_factor * other; TooLargeError beyond `MOST_KERNEL_PRODUCTS`."""
        if (products := self.products(factor) + other.products(other_factor)) > MOST_KERNEL_PRODUCTS:
            raise TooLargeError(products)
        mine, theirs = self.scaled(factor), other.scaled(other_factor)
        return EliminationRow(
            add(mine.multipliers, theirs.multipliers, 1), add(mine.entries, theirs.entries, 1)
        )

    def products(self, factor: PolyElement) -> int:
        """Number of term products of the row with a polynomial."""
        return len(factor) * sum(map(len, (*self.multipliers.values(), *self.entries.values())))

    def scaled(self, factor: PolyElement) -> EliminationRow:
        """The row multiplied by a polynomial."""
        return self._with_all(product_of, factor)

    def divided(self, divisor: PolyElement) -> EliminationRow:
        """The row divided by a common factor of its multipliers and entries."""
        return self._with_all(quotient, divisor)

    def _with_all(
        self, operation: Callable[[PolyElement, PolyElement], PolyElement], operand: PolyElement
    ) -> EliminationRow:
        parts = (self.multipliers, self.entries)
        return EliminationRow(*({k: operation(v, operand) for k, v in part.items()} for part in parts))

    @property
    def is_linear(self) -> bool:
        """Whether the entries are linear in the physical parameters, and the multipliers free of them."""
        free = not any(any(m[1:]) for part in self.multipliers.values() for m in part.itermonoms())
        return free and all(sum(m[1:]) == 1 for part in self.entries.values() for m in part.itermonoms())

    @property
    def degree(self) -> int:
        """Highest power of s in the multipliers: how often balances are differentiated."""
        return max(int(entry.degree(0)) for entry in self.multipliers.values())


def left_kernel(rows: Mapping[str, Row], unknown: Sequence[str], ring: PolyRing) -> list[EliminationRow]:
    """Minimal basis of the combinations of rows in which unknown columns vanish.

    It has one member for each row in excess of the unknown columns. The first generator of the ring is s.
    """
    start = {name: EliminationRow({name: ring.one}, dict(row)) for name, row in rows.items()}
    basis: list[EliminationRow] = []
    # Groups of rows that share unknown columns are independent problems.
    for names, columns in connected(
        {name: [c for c in row if c in unknown] for name, row in rows.items()}, unknown
    ):
        block = {name: start[name] for name in names}
        surplus = len(names) - len(columns)
        if surplus < 0:
            raise _undetermined(columns)
        if not columns:
            basis += block.values()
        elif surplus == 1:
            basis.append(_single_row(block, columns, ring))
        elif surplus > 1:
            basis += _order_basis(list(block.values()), columns, ring, surplus)
    return basis


def local_kernel(rows: Mapping[str, Row], unknown: Sequence[str], ring: PolyRing) -> list[EliminationRow]:
    """Basis of the combinations of rows in which unknown columns vanish; one member for each row in excess.

    As many rows as there are unknown columns determine these; those of the same name are preferred. Each of the other
    rows, with those of the first that it needs, has a single combination that is free of the columns.
    """
    held = {name: [c for c in row if c in unknown] for name, row in rows.items()}
    ordered = sorted(rows, key=lambda name: name not in unknown)
    inner = _independent({name: rows[name] for name in ordered}, unknown, ring)
    groups = connected({name: held[name] for name in inner}, unknown)
    basis = []
    for name in (name for name in rows if name not in inner):
        needed_groups = [
            (names, columns) for names, columns in groups if not set(columns).isdisjoint(held[name])
        ]
        chosen = {name, *(row for names, _ in needed_groups for row in names)}
        block = {row: EliminationRow({row: ring.one}, dict(rows[row])) for row in rows if row in chosen}
        columns = [column for column in unknown if any(column in columns for _, columns in needed_groups)]
        basis.append(_single_row(block, columns, ring) if columns else block[name])
    return basis


def differentiated(row: EliminationRow, powers: Mapping[str, int], ring: PolyRing) -> EliminationRow:
    """The row times the power of s that makes column k divisible by s**powers[k]."""
    missing = (
        power - min(monomial[0] for monomial in row.entries[column].itermonoms())
        for column, power in powers.items()
        if column in row.entries
    )
    power = max(0, *missing, 0)
    return row.scaled(ring.gens[0] ** power) if power else row


def _independent(rows: Mapping[str, Row], columns: Sequence[str], ring: PolyRing) -> list[str]:
    """The first rows that are independent in the columns, judged at a random point modulo a prime."""
    field, draw = GF(_PRIME, symmetric=False), Random(len(rows))
    point = [draw.randrange(1, _PRIME) for _ in ring.gens]

    def value(entry: PolyElement) -> int:
        return sum(
            int(c.numerator)
            * pow(int(c.denominator), -1, _PRIME)
            * prod(x**e for x, e in zip(point, m, strict=True))
            for m, c in entry.terms()
        )

    numbers = [[field(value(row[c]) if c in row else 0) for row in rows.values()] for c in columns]
    _, places = DomainMatrix(numbers, (len(columns), len(rows)), field).rref()
    if len(places) < len(columns):
        raise _undetermined(columns)
    names = list(rows)
    return [names[place] for place in places]


def _undetermined(columns: Sequence[str]) -> EliminationError:
    return EliminationError(
        f"the sensors do not determine the motion of {', '.join(columns)}: add a sensor there"
    )


def divisible(rows: Sequence[EliminationRow], powers: Mapping[str, int]) -> list[EliminationRow]:
    """Minimal basis of the combinations of rows in which column k is divisible by s**powers[k]."""
    basis, budget = list(rows), Budget(MOST_PRODUCTS_IN_ALL)
    for column, power in powers.items():
        for exponent in range(power):
            basis = _meet_condition(basis, column, exponent, budget)
    return basis


def _single_row(
    block: Mapping[str, EliminationRow], columns: Sequence[str], ring: PolyRing
) -> EliminationRow:
    """The only combination of n + 1 rows that is free of n columns."""
    # Cramer's rule: with the n-row minors as multipliers, of alternating sign, all n columns cancel. Divided by their
    # common factor, these multipliers have the lowest degree.
    rows = [to_flint(row.entries) for row in block.values()]
    entries = {(i, j): row[c] for i, row in enumerate(rows) for j, c in enumerate(columns) if c in row}
    one = to_flint({"": ring.one})[""]
    minors, places = Minors(entries, one), tuple(range(len(rows)))
    multipliers = [minors.of(places[:i] + places[i + 1 :], places[:-1]) * (-1) ** i for i in places]
    if not any(multipliers):
        raise _undetermined(columns)
    common = reduce(lambda common, part: common.gcd(part), sorted(multipliers, key=len))
    multipliers = [minor / common for minor in multipliers]
    shown = dict.fromkeys(c for row in rows for c in row if c not in columns)
    sums = {
        c: sum((m * row[c] for m, row in zip(multipliers, rows, strict=True) if c in row), one * 0)
        for c in shown
    }
    return EliminationRow(
        from_flint(dict(zip(block, multipliers, strict=True)), ring), from_flint(sums, ring)
    )


def _order_basis(
    rows: list[EliminationRow], columns: Sequence[str], ring: PolyRing, wanted: int
) -> list[EliminationRow]:
    """Minimal kernel basis where several combinations are free of the columns."""
    # Invariant: the rows are a minimal basis of all combinations whose columns are divisible by s**exponent. Degrees
    # are bounded: once the exponent exceeds them, the columns of a row that meets the conditions must be zero.
    basis, budget = rows, Budget(MOST_PRODUCTS_IN_ALL)
    exponent = 0
    while True:
        done = [row for row in basis if not any(column in row.entries for column in columns)]
        if len(done) == wanted:
            return [primitive(row, ring) for row in done]
        for column in columns:
            basis = _meet_condition(basis, column, exponent, budget)
        exponent += 1


def _meet_condition(
    rows: list[EliminationRow], column: str, exponent: int, budget: Budget
) -> list[EliminationRow]:
    """Make the coefficient of s**exponent in a column vanish, at the cost of one degree of one row."""
    coefficients = (by_power(row.entries.get(column)).get(exponent) for row in rows)
    residuals = {i: residual for i, residual in enumerate(coefficients) if residual is not None}
    if not residuals:
        return rows
    # The row of lowest degree clears the coefficient in the others, whose degrees do not change, and is then itself
    # multiplied by s. Only the lowest degree rises, so the basis remains row-reduced.
    pivot = min(
        residuals,
        key=lambda i: (rows[i].degree, len(residuals[i]), sum(map(len, rows[i].multipliers.values()))),
    )
    ring = residuals[pivot].ring
    met = list(rows)
    for i in residuals:
        if i != pivot:
            common = common_divisor([residuals[pivot], residuals[i]])
            mine, theirs = quotient(residuals[pivot], common), quotient(residuals[i], common)
            budget.spend(rows[i].products(mine) + rows[pivot].products(theirs))
            met[i] = primitive(rows[i].combine(mine, rows[pivot], -theirs), ring, keep_powers_of_s=True)
    met[pivot] = rows[pivot].scaled(ring.gens[0])
    return met


def primitive(row: EliminationRow, ring: PolyRing, *, keep_powers_of_s: bool = False) -> EliminationRow:
    """Divide a row by the greatest common factor of its multipliers, which also divides its entries.

    Powers of s are kept while conditions on coefficients of powers of s are being met: dividing by them would undo
    the conditions that the row already meets.
    """
    parts = sorted(row.multipliers.values(), key=len)
    if _have_no_common_factor(parts, ring):
        return row
    factor = common_divisor(parts)
    if keep_powers_of_s:
        power = min(monomial[0] for monomial in factor.itermonoms())
        factor = ring.from_dict(
            {(monomial[0] - power, *monomial[1:]): value for monomial, value in factor.terms()}
        )
    factor = factor.monic() if not factor.is_ground else factor
    return row.divided(factor) if factor != ring.one else row


def _have_no_common_factor(parts: Sequence[PolyElement], ring: PolyRing) -> bool:
    """Whether values at a point of large random integers prove the absence of a common factor.

    A common factor would have a huge value there, which divides every value. The greatest common divisor of polynomials
    with thousands of terms takes seconds; that of a few integers takes no time. False means undecided.
    """
    if not ring.domain.is_QQ:
        return False
    draw = Random(len(ring.gens))
    point = [draw.randrange(10**15, 10**16) for _ in ring.gens]
    powers = [
        [value**exponent for exponent in range(1 + max(part.degree(i) for part in parts))]
        for i, value in enumerate(point)
    ]
    values = (
        sum(c * prod(powers[i][e] for i, e in enumerate(monomial) if e) for monomial, c in part.terms())
        for part in parts
    )
    return gcd(*(int(value.numerator) for value in values)) < 10**9
