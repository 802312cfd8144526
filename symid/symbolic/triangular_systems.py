"""Triangular polynomial systems: one unknown after the other by linear and quadratic steps.

Minimal parameters are functions of low degree in the physical ones, and almost always some equation is linear in one of
the remaining unknowns. `triangular_solution` solves for that unknown, substitutes it and continues. Equations that
remain at the end have no closed-form solution by such steps.

Polynomials are FLINT's. Their first generators are the unknowns; the others stand for known right-hand sides. No step
divides by these: an equation is divided by the common factor of its coefficients instead, as in fraction-free Gaussian
elimination.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from math import prod
from typing import Any

MOST_TERMS = 400
"""A polynomial with more terms in the unknowns ends the search for a closed form."""
LARGEST = 500
"""So does one with more terms in unknowns and right-hand sides together."""
_MOST_PRODUCTS = 50_000
"""Largest number of term products in a substitution."""


@dataclass(frozen=True)
class SolvedUnknown:
    """An unknown, and the linear or quadratic equation that determines it."""

    unknown: int  # index of the generator
    # of the linear or quadratic equation in the unknown, by descending power; they hold unknowns solved later only
    coefficients: tuple[Any, ...]

    @property
    def branches(self) -> int:
        """Number of solutions: 1 or 2."""
        return len(self.coefficients) - 1


@dataclass(frozen=True)
class TriangularSolution:
    """Unknowns in the order in which they were solved, each in terms of later ones."""

    steps: tuple[SolvedUnknown, ...]
    left: tuple[Any, ...] = ()  # equations without closed form; empty if all is solved

    @property
    def branches(self) -> int:
        """Number of solutions of a complete system."""
        return prod(step.branches for step in self.steps)


def triangular_solution(
    equations: Sequence[Any], unknowns: int, *, simple: bool = False
) -> TriangularSolution:
    """Solve polynomial equations for the first generators, all non-zero, as far as linear and quadratic steps go.

    A `simple` solution has linear steps with monomial leading coefficients only, which neither lose nor add solutions.

    >>> from symid.symbolic.polynomials import context
    >>> x, y = context(("x", "y")).gens()
    >>> solution = triangular_solution([x * y - 6, x + y - 5], 2)
    >>> solution.branches, [step.coefficients for step in solution.steps]
    (2, [(1, y - 5), (1, -5, 6)])
    """
    system = [_HeldEquation(_primitive(equation, unknowns), unknowns) for equation in equations]
    steps: list[SolvedUnknown] = []
    while True:
        # A constant left by a substitution is a relation between the right-hand sides and determines no unknown.
        different = {equation.text: equation for equation in system if equation.held}
        system = sorted(different.values(), key=lambda e: (len(e.polynomial), e.text))
        if not system:
            return TriangularSolution(tuple(steps))
        choice = _next_step(system, simple) if all(equation.is_short for equation in system) else None
        if choice is None or any(_products(e.polynomial, choice[1]) > _MOST_PRODUCTS for e in system):
            return TriangularSolution(tuple(steps), tuple(e.polynomial for e in system))
        solved, step = choice
        steps.append(step)
        system = [e if step.unknown not in e.held else e.after(step) for e in system if e is not solved]


@dataclass(frozen=True, eq=False)
class _HeldEquation:
    """An equation polynomial = 0, with the properties by which each step is chosen, computed once."""

    polynomial: Any
    unknowns: int

    @cached_property
    def text(self) -> str:
        return str(self.polynomial)

    @cached_property
    def held(self) -> dict[int, int]:
        """Degrees of the unknowns in it."""
        return {i: d for i, d in enumerate(self.polynomial.degrees()[: self.unknowns]) if d > 0}

    @cached_property
    def monomials(self) -> list[tuple[int, ...]]:
        """Monomials of the equation in the unknowns."""
        monomials = (monomial[: self.unknowns] for monomial in self.polynomial.monoms())
        return list(dict.fromkeys(tuple(map(int, monomial)) for monomial in monomials))

    @cached_property
    def is_short(self) -> bool:
        return len(self.polynomial) <= LARGEST and len(self.monomials) <= MOST_TERMS

    @cached_property
    def linear(self) -> list[tuple[bool, int, int, int, int]]:
        """Unknowns in which it is linear, each after the cost of its step: a short, known denominator is cheapest."""
        costs = []
        for unknown in (unknown for unknown, degree in self.held.items() if degree == 1):
            leading = [monomial for monomial in self.monomials if monomial[unknown]]
            is_known = not any(sum(monomial) > 1 for monomial in leading)
            costs.append((not is_known, len(leading), len(self.monomials), len(self.polynomial), unknown))
        return costs

    def step(self, unknown: int) -> SolvedUnknown:
        """The step that solves it for an unknown."""
        return SolvedUnknown(unknown, _by_falling_power(self.polynomial, unknown))

    def after(self, step: SolvedUnknown) -> _HeldEquation:
        """The equation with a step substituted."""
        return _HeldEquation(_primitive(_substitute(self.polynomial, step), self.unknowns), self.unknowns)


def _next_step(system: Sequence[_HeldEquation], simple: bool) -> tuple[_HeldEquation, SolvedUnknown] | None:
    """The simplest linear step, else a quadratic equation in a single unknown."""
    candidates = [
        (*cost, place, unknown)
        for place, equation in enumerate(system)
        for *cost, unknown in equation.linear
        if not simple or cost[1] == 1
    ]
    if candidates:
        *_, place, unknown = min(candidates)
        return system[place], system[place].step(unknown)
    for equation in () if simple else system:
        if [*equation.held.values()] == [2]:
            (unknown,) = equation.held
            return equation, equation.step(unknown)
    return None


def _products(equation: Any, step: SolvedUnknown) -> int:
    """Products of terms in a substitution, roughly."""
    power = max(0, equation.degrees()[step.unknown])
    return int(len(equation) * max(map(len, step.coefficients)) ** power)


def _substitute(equation: Any, step: SolvedUnknown) -> Any:
    """An equation with a linear step substituted and the denominator cleared, or reduced modulo a quadratic step."""
    degree = equation.degrees()[step.unknown]
    if degree <= 0:
        return equation
    if step.branches == 1:
        parts = _by_falling_power(equation, step.unknown)
        denominator, constant = step.coefficients  # the unknown is -constant / denominator
        terms = (part * (-constant) ** (degree - i) * denominator**i for i, part in enumerate(parts))
        return sum(terms, equation * 0)
    unknown = equation.context().gens()[step.unknown]
    modulus = sum((c * unknown ** (2 - i) for i, c in enumerate(step.coefficients)), equation * 0)
    while (degree := equation.degrees()[step.unknown]) >= 2:
        leading = _by_falling_power(equation, step.unknown)[0]
        equation = step.coefficients[0] * equation - leading * unknown ** (degree - 2) * modulus
    return equation


def _by_falling_power(equation: Any, unknown: int) -> tuple[Any, ...]:
    """Coefficients of a polynomial in one unknown, by descending power."""
    parts: list[dict[tuple[int, ...], object]] = [{} for _ in range(equation.degrees()[unknown] + 1)]
    for monomial, value in equation.terms():
        parts[-1 - int(monomial[unknown])][(*monomial[:unknown], 0, *monomial[unknown + 1 :])] = value
    return tuple(map(equation.context().from_dict, parts))


def _over_unknowns(equation: Any, unknowns: int) -> list[Any]:
    """Coefficients of the monomials in the unknowns, as polynomials in the right-hand sides."""
    parts: dict[tuple[int, ...], dict[tuple[int, ...], object]] = {}
    for monomial, value in equation.terms():
        powers = tuple(map(int, monomial[:unknowns]))
        parts.setdefault(powers, {})[(*(0,) * unknowns, *monomial[unknowns:])] = value
    return list(map(equation.context().from_dict, parts.values()))


def _primitive(equation: Any, unknowns: int) -> Any:
    """The equation divided by its common monomial, since nothing in it is zero, and by what its coefficients share."""
    if not equation:
        return equation
    equation = equation / equation.term_content()
    if len(equation.degrees()) > unknowns:
        parts = sorted(_over_unknowns(equation, unknowns), key=len)
        equation = equation / reduce(
            lambda common, part: common if common.is_constant() else common.gcd(part), parts
        )
    return equation / equation.leading_coefficient()
