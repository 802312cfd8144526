"""Minors of sparse matrices of polynomials, by Laplace expansion, which needs no division.

A matrix is expanded along the row or column with the fewest entries. The determinant of a block-diagonal matrix is the
product over its blocks, and every minor is computed once. A chain, a tree or a loop of springs has few distinct minors,
none of them longer than the result.
"""

from __future__ import annotations

from collections.abc import Collection, Hashable, Mapping, Sequence
from math import prod
from typing import Any, TypeVar

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
        """Take products off; TooLargeError if there are not so many left."""
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

    def __init__(self, entries: Mapping[tuple[int, int], Any], one: Any) -> None:
        self._entries, self._one = entries, one
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
        if any(len(own) != len(theirs) for own, theirs in blocks):
            return self._one * 0
        if len(blocks) == 1:
            return self._expanded(rows, columns)
        value = self._one * prod(_sign([i for block in blocks for i in block[side]]) for side in (0, 1))
        for own, theirs in sorted(blocks, key=lambda block: len(block[0])):
            value = self._product(value, self.of(tuple(own), tuple(theirs)))
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
    for name, own in rows.items():
        joined = [group for group in groups if not group[1].isdisjoint(own)]
        groups = [group for group in groups if group not in joined]
        groups.append(({name}.union(*(g[0] for g in joined)), set(own).union(*(g[1] for g in joined))))
    return [
        ([name for name in rows if name in mine], [c for c in columns if c in theirs])
        for mine, theirs in groups
    ]


def _sign(permutation: Sequence[int]) -> int:
    inversions = sum(later < first for i, first in enumerate(permutation) for later in permutation[i + 1 :])
    return -1 if inversions % 2 else 1
