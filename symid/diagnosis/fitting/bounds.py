"""Bounds of machines for the values of declared effects, such as a coefficient of friction between 0 and 0.5."""

from __future__ import annotations

from collections.abc import Sequence, Set

from symid.diagnosis.effects import Key, Placed, declared_effects
from symid.diagnosis.fitting.state import State

_HALVINGS = 10
"""Halvings of the way to a bound, which is then missed by a thousandth of a step."""


def beyond_bounds(state: State) -> set[Key]:
    """Declared effects with values that no machine has."""
    declared = {item.key for item in declared_effects(state.prediction)}
    return {
        item.key
        for item in state.placed
        if item.key in declared and not item.effect.is_possible(state.prediction, item)
    }


def moved_to_bounds(state: State, moved: Sequence[Placed], outside: Set[Key]) -> tuple[Placed, ...]:
    """Effects of a state, those `outside` with the last possible values on their way to the `moved` ones."""
    return tuple(
        _to_bound(state, own, target) if own.key in outside else own
        for own, target in zip(state.placed, moved, strict=True)
    )


def _to_bound(state: State, possible: Placed, impossible: Placed) -> Placed:
    """The last possible values between two, by bisection."""
    for _ in range(_HALVINGS):
        middle = possible.with_free(
            [(a + b) / 2 for a, b in zip(possible.free, impossible.free, strict=True)]
        )
        if middle.effect.is_possible(state.prediction, middle):
            possible = middle
        else:
            impossible = middle
    return possible
