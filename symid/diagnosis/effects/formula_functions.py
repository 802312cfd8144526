"""The formula of a law as functions of arrays and of numbers."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache

from symid.arrays import FloatArray
from symid.axis import Term
from symid.simulation.law_code import array_function, has_jumps, law_code, level_code


@dataclass(frozen=True, eq=False)
class LawFunctions:
    """A formula as functions of q, v, its shape parameters and, but for `arrays`, its amplitudes."""

    arrays: tuple[Callable[..., FloatArray], ...]  # each term for arrays and a unit amplitude
    force: str  # the whole force as NumPy code, in q, v and `names`
    names: tuple[str, ...]  # of shape parameters and amplitudes
    level: str | None  # factor of sign(v) in dry friction; it does not fall below 0 along the stroke
    jumps: tuple[bool, ...]  # whether each term jumps where the velocity changes its sign


@cache
def functions_of(formula: tuple[Term, ...], numbers: tuple[str, ...]) -> LawFunctions:
    """Functions of the terms of a formula, with some of its numbers as arguments."""
    terms = [law_code(term.expression) for term in formula]
    levels = [level_code(term.expression) for term in formula]
    amplitudes = tuple(f"amplitude_{i}" for i in range(len(terms)))

    def whole(parts: Sequence[str | None]) -> str:
        return " + ".join(f"{a} * ({part})" for a, part in zip(amplitudes, parts, strict=True))

    level = None if None in levels else whole(levels)
    if level is not None and re.search(r"\bq\b", level):
        level = f"np.maximum({level}, 0.0)"
    arrays = tuple(array_function(term, numbers) for term in terms)
    jumps = tuple(has_jumps(term.expression) for term in formula)
    return LawFunctions(arrays, whole(terms), (*numbers, *amplitudes), level, jumps)
