"""Triangular polynomial systems: one unknown after the other by linear and quadratic steps.

Minimal parameters are functions of low degree in the physical ones, and almost always some equation is linear in one of
the remaining unknowns. `triangular_solution` solves for that unknown, substitutes it and continues. Equations that
remain at the end have no closed-form solution by such steps.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import prod

from sympy.polys.fields import FracElement
from sympy.polys.rings import PolyElement

MOST_TERMS = 400
"""A polynomial with more terms ends the search for a closed form."""
LARGEST = 300
"""So does one whose coefficients have more terms in total: common divisors of such fractions take minutes."""


@dataclass(frozen=True)
class SolvedUnknown:
    """One solved unknown."""

    unknown: int  # index of the generator
    # of the linear or quadratic equation in the unknown, by descending power; they hold unknowns solved later only
    coefficients: tuple[PolyElement, ...]

    @property
    def branches(self) -> int:
        """Number of solutions: 1 or 2."""
        return len(self.coefficients) - 1


@dataclass(frozen=True)
class TriangularSolution:
    """Unknowns in the order in which they were solved, each in terms of later ones."""

    steps: tuple[SolvedUnknown, ...]
    left: tuple[PolyElement, ...] = ()  # equations without closed form; empty if all is solved

    @property
    def branches(self) -> int:
        """Number of solutions of a complete system."""
        return prod(step.branches for step in self.steps)


def triangular_solution(
    equations: Sequence[PolyElement], unknowns: int, *, simple: bool = False
) -> TriangularSolution:
    """Solve polynomial equations for the first generators, all non-zero, as far as linear and quadratic steps go.

    The right-hand sides are elements of the coefficient field. A `simple` solution has linear steps with monomial
    leading coefficients only, which neither lose nor add solutions.

    >>> from sympy import QQ
    >>> from sympy.polys.rings import PolyRing
    >>> x, y = PolyRing(("x", "y"), QQ).gens
    >>> solution = triangular_solution([x * y - 6, x + y - 5], 2)
    >>> solution.branches, [step.coefficients for step in solution.steps]
    (2, [(1, y - 5), (1, -5, 6)])
    """
    system = [_without_monomials(equation) for equation in equations]
    steps: list[SolvedUnknown] = []
    while True:
        # A constant left by a substitution is a relation between the right-hand sides and determines no unknown.
        system = sorted({e.monic() for e in system if not e.is_ground}, key=lambda e: (len(e), str(e)))
        if not system:
            break
        short = all(len(e) <= MOST_TERMS and _size(e) <= LARGEST for e in system)
        choice = _next_step(system, unknowns, simple) if short else None
        if choice is None:
            return TriangularSolution(tuple(steps), tuple(system))
        equation, step = choice
        steps.append(step)
        system = [_without_monomials(_substitute(e, step)) for e in system if e is not equation]
    return TriangularSolution(tuple(steps))


def _next_step(
    system: Sequence[PolyElement], unknowns: int, simple: bool
) -> tuple[PolyElement, SolvedUnknown] | None:
    """The simplest linear step, else a quadratic equation in a single unknown."""
    candidates = []
    for place, equation in enumerate(system):
        for unknown in range(unknowns):
            if equation.degree(unknown) == 1:
                coefficients = _by_falling_power(equation, unknown)
                leading = coefficients[0]
                if simple and not leading.is_term:
                    continue
                size = sum(map(_size, coefficients))
                cost = (not leading.is_ground, len(leading), sum(map(len, coefficients)), size, place)
                candidates.append((cost, unknown, equation, coefficients))
    if candidates:
        _, unknown, equation, coefficients = min(candidates, key=lambda c: (c[0], c[1]))
        return equation, SolvedUnknown(unknown, coefficients)
    for equation in () if simple else system:
        held = [unknown for unknown in range(unknowns) if equation.degree(unknown) > 0]
        if len(held) == 1 and equation.degree(held[0]) == 2:
            return equation, SolvedUnknown(held[0], _by_falling_power(equation, held[0]))
    return None


def _size(equation: PolyElement) -> int:
    """Number of terms in all coefficients; of fractions, in numerator and denominator."""
    return sum(len(c.numer) + len(c.denom) if isinstance(c, FracElement) else 1 for c in equation.coeffs())


def _substitute(equation: PolyElement, step: SolvedUnknown) -> PolyElement:
    """An equation with a linear step substituted and the denominator cleared, or reduced modulo a quadratic step."""
    degree = equation.degree(step.unknown)
    if degree <= 0:
        return equation
    parts = _by_falling_power(equation, step.unknown)
    if step.branches == 1:
        denominator, constant = step.coefficients  # the unknown is -constant / denominator
        terms = (part * (-constant) ** (degree - i) * denominator**i for i, part in enumerate(parts))
        return sum(terms, equation.ring.zero)
    unknown = equation.ring.gens[step.unknown]
    modulus = sum((c * unknown ** (2 - i) for i, c in enumerate(step.coefficients)), equation.ring.zero)
    return equation.prem(modulus, unknown) if degree >= 2 else equation


def _by_falling_power(equation: PolyElement, unknown: int) -> tuple[PolyElement, ...]:
    """Coefficients of a polynomial in one unknown, by descending power."""
    ring = equation.ring
    parts: list[dict[tuple[int, ...], object]] = [{} for _ in range(equation.degree(unknown) + 1)]
    for monomial, value in equation.terms():
        parts[-1 - monomial[unknown]][(*monomial[:unknown], 0, *monomial[unknown + 1 :])] = value
    return tuple(ring.from_dict(part) for part in parts)


def _without_monomials(equation: PolyElement) -> PolyElement:
    """The equation divided by its common monomial, since the unknowns are not zero."""
    if not equation:
        return equation
    shared = tuple(map(min, zip(*equation.itermonoms(), strict=True)))
    if not any(shared):
        return equation
    return equation.ring.from_dict(
        {tuple(a - b for a, b in zip(m, shared, strict=True)): c for m, c in equation.terms()}
    )
