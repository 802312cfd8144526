"""Linear spans of sparse vectors over an exact field."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from typing import Any

Vector = Mapping[Hashable, Any]


class Span:
    """The space spanned by the vectors added so far, with every member's coordinates in them.

    Examples
    --------
    >>> from sympy import QQ
    >>> span = Span()
    >>> span.add({"a": QQ(1), "b": QQ(1)}), span.add({"b": QQ(2)}), span.add({"a": QQ(1)})
    (True, True, False)
    >>> span.coordinates({"a": QQ(1)})
    {0: 1, 1: -1/2}
    """

    def __init__(self) -> None:
        self._rows: list[tuple[Hashable, dict[Hashable, Any], dict[int, Any]]] = []
        self.dimension = 0

    def add(self, vector: Vector) -> bool:
        """Add a vector as the next basis vector; False if it lies in the span already."""
        remainder, used = self._reduce(vector)
        if not remainder:
            return False
        pivot = next(iter(remainder))
        scale = 1 / remainder[pivot]
        row = {key: value * scale for key, value in remainder.items()}
        combination = {index: -value * scale for index, value in used.items()}
        combination[self.dimension] = scale
        self._rows.append((pivot, row, combination))
        self.dimension += 1
        return True

    def coordinates(self, vector: Vector) -> dict[int, Any] | None:
        """Coefficients of the added vectors (by index) that give a vector; None if it lies outside."""
        remainder, used = self._reduce(vector)
        return None if remainder else dict(sorted(used.items()))

    def _reduce(self, vector: Vector) -> tuple[dict[Hashable, Any], dict[int, Any]]:
        remainder, used = dict(vector), dict[int, Any]()
        for pivot, row, combination in self._rows:
            share = remainder.get(pivot)
            if share:
                subtract(remainder, row, share)
                subtract(used, combination, -share)
        return remainder, used


def subtract(vector: dict[Any, Any], other: Mapping[Any, Any], factor: Any) -> None:
    """vector -= factor * other in place, without zero entries."""
    for key, value in other.items():
        total = vector[key] - factor * value if key in vector else -factor * value
        if total:
            vector[key] = total
        else:
            del vector[key]
