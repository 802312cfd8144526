"""Triangular polynomial systems: one unknown after the other by linear and quadratic steps.

The minimal parameters are low-degree functions of the physical ones, and almost always some equation is linear in
one of the unknowns that are left. `triangular_solution` uses this again and again; what is left at the end is
either solved, a relation that the right-hand sides must satisfy, or beyond closed form.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from sympy.polys.fields import FracElement
from sympy.polys.rings import PolyElement

MOST_TERMS = 400
"""A polynomial longer than this ends the search for a closed form."""
LARGEST = 300
"""One whose coefficients have more terms than this in all, too: common divisors of such fractions take minutes."""


@dataclass(frozen=True)
class SolvedUnknown:
    """One solved unknown."""

    unknown: int  # index of the generator
    # of the polynomial in the unknown, by falling power, in the unknowns solved later: two of them for a linear
    # equation, three for a quadratic one
    coefficients: tuple[PolyElement, ...]

    @property
    def branches(self) -> int:
        """Number of solutions: 1 or 2."""
        return len(self.coefficients) - 1


@dataclass(frozen=True)
class TriangularSolution:
    """Unknowns in the order in which they were solved; each is given by those behind it."""

    steps: tuple[SolvedUnknown, ...]  # solved unknowns
    left: tuple[PolyElement, ...] = field(default=())  # equations beyond closed form; empty if all is solved

    @property
    def branches(self) -> int:
        """Number of solutions of a complete system."""
        total = 1
        for step in self.steps:
            total *= step.branches
        return total


def triangular_solution(
    equations: Sequence[PolyElement], unknowns: int, *, simple: bool = False
) -> TriangularSolution:
    """Solve polynomial equations for the first generators, all non-zero, as far as linear and quadratic steps go.

    The exact field of the polynomials holds the right-hand sides. A `simple` solution has only linear steps whose
    leading coefficient is a monomial: these neither lose nor invent solutions.

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
    """Terms of all coefficients of a polynomial, above and below where they are fractions of polynomials."""
    return sum(len(c.numer) + len(c.denom) if isinstance(c, FracElement) else 1 for c in equation.coeffs())


def _substitute(equation: PolyElement, step: SolvedUnknown) -> PolyElement:
    """Put a step's solution into an equation and clear the denominator; reduce by a quadratic step."""
    degree = equation.degree(step.unknown)
    if degree <= 0:
        return equation
    parts = _by_falling_power(equation, step.unknown)
    if step.branches == 1:
        denominator, negative_numerator = step.coefficients
        total = equation.ring.zero
        for i, part in enumerate(parts):
            total += part * (-negative_numerator) ** (degree - i) * denominator**i
        return total
    unknown = equation.ring.gens[step.unknown]
    modulus = sum((c * unknown ** (2 - i) for i, c in enumerate(step.coefficients)), equation.ring.zero)
    return equation.prem(modulus, equation.ring.gens[step.unknown]) if degree >= 2 else equation


def _by_falling_power(equation: PolyElement, unknown: int) -> tuple[PolyElement, ...]:
    """Coefficients of a polynomial in one unknown, from its degree down to 0."""
    ring = equation.ring
    parts: list[dict[tuple[int, ...], object]] = [{} for _ in range(equation.degree(unknown) + 1)]
    for monomial, value in equation.terms():
        parts[-1 - monomial[unknown]][(*monomial[:unknown], 0, *monomial[unknown + 1 :])] = value
    return tuple(ring.from_dict(part) for part in parts)


def _without_monomials(equation: PolyElement) -> PolyElement:
    """Divide by the common monomial: the unknowns are not zero."""
    if not equation:
        return equation
    shared = tuple(map(min, zip(*equation.itermonoms(), strict=True)))
    if not any(shared):
        return equation
    return equation.ring.from_dict(
        {tuple(a - b for a, b in zip(m, shared, strict=True)): c for m, c in equation.terms()}
    )
