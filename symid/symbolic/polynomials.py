"""Products, quotients, common divisors and minors of polynomials with many terms, by FLINT.

sympy computes these in Python: a product of a thousand by a thousand terms takes seconds, a common divisor minutes.
FLINT uses the same number types, so a conversion costs one copy of the terms.

Minors of sparse matrices come from Laplace expansion, which needs no division. A matrix is expanded along the row or
column with the fewest entries. The determinant of a block-diagonal matrix is the product over its blocks, and every
minor is computed once. A chain, a tree or a loop of springs has few distinct minors, none of them longer than the
result.
"""

from collections.abc import Collection, Hashable, Mapping, Sequence
from functools import cache, reduce
from math import prod
from operator import add, sub
from typing import Any, TypeVar

import flint
import sympy as sp
from flint.utils.flint_exceptions import DomainError
from sympy import QQ
from sympy.polys.rings import PolyElement, PolyRing

_FASTER_BY_FLINT = 500  # term products from which on FLINT is faster, copies included


def product_of(first: PolyElement, second: PolyElement) -> PolyElement:
    """Product of two polynomials of one ring.

    >>> ring = PolyRing(("x", "y"), QQ)
    >>> x, y = ring.gens
    >>> product_of((x + y) ** 40, x - y) == (x + y) ** 40 * (x - y)
    True
    """
    if len(second) == 1:
        ((powers, scale),) = second.items()
        return first.new({tuple(map(add, monomial, powers)): c * scale for monomial, c in first.items()})
    if first.ring.domain != QQ or len(first) * len(second) < _FASTER_BY_FLINT:
        return first * second
    return _back(_copy(first) * _copy(second), first.ring)


def quotient(polynomial: PolyElement, divisor: PolyElement) -> PolyElement:
    """Quotient of a polynomial by a divisor of it.

    >>> ring = PolyRing(("x", "y"), QQ)
    >>> x, y = ring.gens
    >>> quotient((x + y) ** 3, x + y) == (x + y) ** 2
    True
    """
    whole = quotient_if_whole(polynomial, divisor)
    assert whole is not None, "a divisor must divide"
    return whole


def quotient_if_whole(polynomial: PolyElement, divisor: PolyElement) -> PolyElement | None:
    """Quotient of two polynomials; None if the division leaves a remainder.

    >>> x, y = PolyRing(("x", "y"), QQ).gens
    >>> quotient_if_whole(x * y + x, y + 1), quotient_if_whole(x, y + 1)
    (x, None)
    >>> quotient_if_whole(x * y + x, 2 * x), quotient_if_whole(x + y, x)
    (1/2*y + 1/2, None)
    """
    if divisor.is_term and polynomial.ring.domain.is_Field:
        # sympy searches the leading term again for each term of the quotient.
        ((powers, scale),) = divisor.items()
        terms = {tuple(map(sub, monomial, powers)): c / scale for monomial, c in polynomial.items()}
        return polynomial.new(terms) if all(min(monomial) >= 0 for monomial in terms) else None
    if polynomial.ring.domain != QQ or divisor.is_term or len(polynomial) * len(divisor) < _FASTER_BY_FLINT:
        quotient_, remainder = polynomial.div(divisor)
        return None if remainder else quotient_
    try:
        return _back(_copy(polynomial) / _copy(divisor), polynomial.ring)
    except DomainError:
        return None


def common_divisor(polynomials: Sequence[PolyElement]) -> PolyElement:
    """Greatest common divisor of one or more polynomials.

    >>> ring = PolyRing(("x", "y"), QQ)
    >>> x, y = ring.gens
    >>> common_divisor([x**2 - y**2, (x + y) ** 2]).monic()
    x + y
    """
    ring = polynomials[0].ring
    ordered = sorted(polynomials, key=len)
    if ring.domain != QQ:
        return reduce(
            lambda common, part: common if common.is_ground else common.gcd(part), ordered[1:], ordered[0]
        )
    common = _copy(ordered[0])
    for part in ordered[1:]:
        if common.is_constant():
            break
        common = common.gcd(_copy(part))
    return _back(common, ring)


def to_flint(polynomials: Mapping[str, PolyElement]) -> dict[str, Any]:
    """FLINT's copies of polynomials."""
    return {name: _copy(polynomial) for name, polynomial in polynomials.items()}


def from_flint(polynomials: Mapping[str, Any], ring: PolyRing) -> dict[str, PolyElement]:
    """Elements of a ring from FLINT's copies, without zeros."""
    return {name: _back(polynomial, ring) for name, polynomial in polynomials.items() if polynomial != 0}


@cache
def context(names: tuple[str, ...], modulus: int = 0) -> Any:
    """FLINT's ring of polynomials over the rational numbers, or modulo a prime."""
    if modulus:
        return flint.nmod_mpoly_ctx.get(names, modulus=modulus, ordering=flint.Ordering.lex)
    return flint.fmpq_mpoly_ctx.get(names, flint.Ordering.lex)


def expression(polynomial: Any) -> sp.Expr:
    """FLINT's polynomial as a sympy expression.

    >>> x, y = context(("x", "y")).gens()
    >>> expression((x - y) * (x + y) / 2)
    x**2/2 - y**2/2
    """
    symbols = [sp.Symbol(name) for name in polynomial.context().names()]
    return sp.Add(
        *(
            sp.Rational(int(c.numerator), int(c.denominator))
            * sp.Mul(*(x ** int(power) for x, power in zip(symbols, monomial, strict=True) if power))
            for monomial, c in polynomial.terms()
        )
    )


def factored(numerator: Any, denominator: Any) -> sp.Expr:
    """Quotient of two of FLINT's polynomials as a product of powers of irreducible factors.

    >>> x, y = context(("x", "y")).gens()
    >>> factored(y**2 - x**2, x * y + y**2)
    (-x + y)/y
    """
    common = numerator.gcd(denominator)
    product = sp.Integer(1)
    for part, sign in ((numerator / common, 1), (denominator / common, -1)):
        content, factors = part.factor()
        product *= sp.Rational(int(content.numerator), int(content.denominator)) ** sign
        for factor, power in factors:
            product *= expression(factor) ** (sign * int(power))
    return product


def _copy(polynomial: PolyElement) -> Any:
    return context(tuple(map(str, polynomial.ring.symbols))).from_dict(dict(polynomial))


def _back(polynomial: Any, ring: PolyRing) -> PolyElement:
    # The coefficients are of the ring's domain already: `from_dict` would convert each of them again.
    return ring.zero.new({tuple(map(int, m)): c for m, c in polynomial.to_dict().items()})


K = TypeVar("K", bound=Hashable)
C = TypeVar("C", bound=Hashable)
Places = tuple[int, ...]

MOST_PRODUCTS = 400_000
"""Largest number of term products for the minors of a matrix: three times what a loop of eight springs and dampers
takes."""


class TooLargeError(Exception):
    """Polynomials exceed the limit of cost."""


class Budget:
    """Term products that may still be computed."""

    def __init__(self, products: int) -> None:
        self._left = products

    def spend(self, products: int) -> None:
        """Subtract products from the budget; TooLargeError if fewer are left."""
        self._left -= products
        if self._left < 0:
            raise TooLargeError


class Minors:
    """Minors of a matrix, given by its non-zero entries by row and column, and the 1 of their ring.

    >>> from sympy import QQ
    >>> from sympy.polys.rings import PolyRing
    >>> ring = PolyRing(("x", "y"), QQ)
    >>> x, y = ring.gens
    >>> Minors({(0, 0): x, (0, 1): y, (1, 0): y, (1, 1): x}, ring.one).of((0, 1), (0, 1))
    x**2 - y**2
    """

    def __init__(self, entries: Mapping[tuple[int, int], Any], unit: Any) -> None:
        self._entries, self._one = entries, unit
        self._known: dict[tuple[Places, Places], Any] = {}
        self._budget = Budget(MOST_PRODUCTS)

    def of(self, rows: Places, columns: Places) -> Any:
        """Determinant of the submatrix of rows and columns in ascending order; TooLargeError beyond `MOST_PRODUCTS`."""
        if (rows, columns) not in self._known:
            self._known[rows, columns] = self._computed(rows, columns)
        return self._known[rows, columns]

    def _computed(self, rows: Places, columns: Places) -> Any:
        # Rows that share no columns form blocks. A block that is not square makes the determinant 0; the others
        # multiply, with the sign of the permutation that sorts rows and columns into blocks.
        blocks = connected({i: [j for j in columns if (i, j) in self._entries] for i in rows}, columns)
        if any(len(block_rows) != len(block_columns) for block_rows, block_columns in blocks):
            return self._one * 0
        if len(blocks) == 1:
            return self._expanded(rows, columns)
        value = self._one * prod(_sign([i for block in blocks for i in block[side]]) for side in (0, 1))
        for block_rows, block_columns in sorted(blocks, key=lambda block: len(block[0])):
            value = self._product(value, self.of(tuple(block_rows), tuple(block_columns)))
        return value

    def _expanded(self, rows: Places, columns: Places) -> Any:
        lines = [[(i, j) for j in columns if (i, j) in self._entries] for i in rows]
        lines += [[(i, j) for i in rows if (i, j) in self._entries] for j in columns]
        total = self._one * 0
        for i, j in min(lines, key=len):
            above, before = rows.index(i), columns.index(j)
            minor = self.of(rows[:above] + rows[above + 1 :], columns[:before] + columns[before + 1 :])
            total += self._product(self._entries[i, j] * (-1) ** (above + before), minor)
        return total

    def _product(self, first: Any, second: Any) -> Any:
        self._budget.spend(len(first) * len(second))
        return first * second


def connected(rows: Mapping[K, Collection[C]], columns: Sequence[C]) -> list[tuple[list[K], list[C]]]:
    """Connected groups of rows that share columns, each with its columns, in the given order.

    >>> connected({"a": [1], "b": [2], "c": [3, 1]}, [1, 2, 3])
    [(['b'], [2]), (['a', 'c'], [1, 3])]
    """
    groups: list[tuple[set[K], set[C]]] = []
    for name, held in rows.items():
        joined = [group for group in groups if not group[1].isdisjoint(held)]
        groups = [group for group in groups if group not in joined]
        groups.append(({name}.union(*(g[0] for g in joined)), set(held).union(*(g[1] for g in joined))))
    return [
        ([name for name in rows if name in mine], [c for c in columns if c in theirs])
        for mine, theirs in groups
    ]


def _sign(permutation: Sequence[int]) -> int:
    inversions = sum(later < first for i, first in enumerate(permutation) for later in permutation[i + 1 :])
    return -1 if inversions % 2 else 1
