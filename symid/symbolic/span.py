"""Linear spans of sparse vectors over an exact field."""

from collections.abc import Hashable, Mapping
from typing import Any, NamedTuple

Vector = Mapping[Any, Any]


class SpanRow(NamedTuple):
    """A vector of a span, scaled to 1 at its pivot, and its coordinates in the added vectors."""

    pivot: Hashable
    vector: dict[Any, Any]
    coordinates: dict[int, Any]


class Span:
    """The space spanned by the vectors added so far, and the coordinates of its members in them.

    >>> from sympy import QQ
    >>> span = Span()
    >>> span.add({"a": QQ(1), "b": QQ(1)}), span.add({"b": QQ(2)}), span.add({"a": QQ(1)})
    (True, True, False)
    >>> span.coordinates({"a": QQ(1)})
    {0: 1, 1: -1/2}
    """

    def __init__(self) -> None:
        self._rows: list[SpanRow] = []

    def add(self, vector: Vector, pivot: Hashable = None) -> bool:
        """Add a vector as the next basis vector, with a preferred pivot; False if it is already in the span."""
        # Gaussian elimination: the remainder after reduction by all rows becomes a new row. Its coordinates express it
        # in the added vectors, this one included.
        remainder, used = self._reduce(vector)
        if not remainder:
            return False
        pivot = pivot if pivot in remainder else next(iter(remainder))
        scale = 1 / remainder[pivot]
        row = {key: value * scale for key, value in remainder.items()}
        coordinates = {index: -value * scale for index, value in used.items()}
        self._rows.append(SpanRow(pivot, row, {**coordinates, len(self._rows): scale}))
        return True

    def reduced(self) -> list[SpanRow]:
        """Basis of the span in which each vector is 0 at the pivots of all others (reduced echelon form)."""
        rows: list[SpanRow] = []
        for pivot, vector, coordinates in reversed(self._rows):
            row = SpanRow(pivot, dict(vector), dict(coordinates))
            for other in rows:
                if share := row.vector.get(other.pivot):
                    subtract(row.vector, other.vector, share)
                    subtract(row.coordinates, other.coordinates, share)
            rows.insert(0, row)
        return rows

    def coordinates(self, vector: Vector) -> dict[int, Any] | None:
        """Coefficients of the added vectors, by index, that sum to a vector; None if it is outside the span."""
        remainder, used = self._reduce(vector)
        return None if remainder else dict(sorted(used.items()))

    def _reduce(self, vector: Vector) -> tuple[dict[Hashable, Any], dict[int, Any]]:
        remainder, used = dict(vector), dict[int, Any]()
        for pivot, row, coordinates in self._rows:
            share = remainder.get(pivot)
            if share:
                subtract(remainder, row, share)
                subtract(used, coordinates, -share)
        return remainder, used


def subtract(vector: dict[Any, Any], other: Mapping[Any, Any], factor: Any) -> None:
    """vector -= factor * other in place, without zero entries."""
    for key, value in other.items():
        total = vector[key] - factor * value if key in vector else -factor * value
        if total:
            vector[key] = total
        else:
            del vector[key]
