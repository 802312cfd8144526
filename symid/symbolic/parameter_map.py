"""Maps between minimal and physical parameters, and what the sensors determine of the latter.

The forward map X(theta) is part of the minimal model. Here it is inverted in closed form where one unknown after
the other can be solved for (paper below [41]), with all branches, and the identifiability of each physical parameter
is decided: a rank shows whether it is determined at all, and the number of solutions of X(theta) = X(theta0) at
a random point theta0 whether it is determined uniquely. Both are exact calculations modulo a prime.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from math import prod
from random import Random
from typing import Any, Literal, NamedTuple

import numpy as np
import sympy as sp
from sympy import GF, QQ
from sympy.polys.densebasic import dup_degree
from sympy.polys.fields import FracElement
from sympy.polys.galoistools import gf_sqf_part
from sympy.polys.groebnertools import groebner
from sympy.polys.matrices import DomainMatrix
from sympy.polys.orderings import grevlex
from sympy.polys.rings import PolyElement, PolyRing

from symid.symbolic.branch_signs import other_solutions_are_unphysical
from symid.symbolic.minimal import MinimalModel, ParameterFunction
from symid.symbolic.span import Span
from symid.symbolic.triangular_systems import MOST_TERMS, TriangularSolution, triangular_solution

Identifiability = Literal["unique", "several", "none"]

_PRIME = 2**31 - 1
_MOST_UNKNOWNS = 4
"""Largest number of unknowns for which a Groebner basis is computed; more take too long."""


@dataclass(frozen=True)
class ParameterMap:
    """Maps between minimal and physical parameters.

    Parameters
    ----------
    functions : mapping of str to ParameterFunction
        Minimal parameters in terms of the physical ones.
    solution : TriangularSolution or None
        Closed form of the inverse map, None if there is none.
    inverse : tuple of mapping of str to sympy.Expr
        Physical parameters in terms of the minimal ones, one mapping for each branch; empty without closed form.
    identifiability : mapping of str to {"unique", "several", "none"}
        Whether the sensors determine each physical parameter; of solutions in closed form only those count that have
        the declared signs.
    combinations : tuple of ParameterFunction
        Determined functions of the parameters that are not determined themselves.
    relations : int
        How many more minimal than physical parameters are determined: relations that a right model satisfies.
    counted : bool
        Whether the solutions were counted; if not, "several" means: determined locally, number of solutions unknown.
    """

    functions: Mapping[str, ParameterFunction]
    solution: TriangularSolution | None
    inverse: tuple[Mapping[str, sp.Expr], ...]
    identifiability: Mapping[str, Identifiability]
    combinations: tuple[ParameterFunction, ...]
    relations: int
    counted: bool

    @cached_property
    def minimal(self) -> dict[str, sp.Expr]:
        """Minimal parameters in terms of the physical ones, as expressions."""
        return {name: function.expression for name, function in self.functions.items()}

    def __str__(self) -> str:
        """Minimal parameters, the first solution of the inverse map, and what is determined."""
        lines = [f"{name} = {function}" for name, function in self.functions.items()]
        lines += [
            f"{name} = {expression}" for branch in self.inverse[:1] for name, expression in branch.items()
        ]
        lines += [f"{name}: {determined}" for name, determined in self.identifiability.items()]
        return "\n".join(lines)


def parameter_map(model: MinimalModel) -> ParameterMap:
    """Parameter map of a minimal model.

    Examples
    --------
    >>> from symid.symbolic.pipeline import derive
    >>> from symid.axis import load_axis
    >>> parameter_map(derive(load_axis("direct_2m1s"), ("q2",)).minimal).inverse[0]["Mm"]
    -X2*X3 + X5
    """
    names = list(model.source.source.axis.physical_parameters)
    point = _Point(model)
    undetermined = point.undetermined()
    several, counted = point.with_several_values()
    identifiability: dict[str, Identifiability] = {
        name: "none" if name in undetermined else "several" if name in several else "unique" for name in names
    }
    functions = {parameter.name: parameter.function for parameter in model.parameters}
    solution = inverse_map(model)
    inverse = _branches(model, solution) if solution else ()
    axis = model.source.source.axis
    units = {name: str(unit) for name, unit in axis.physical_parameters.items()}
    if len(inverse) > 1:
        known = {sp.Symbol(name): value for name, value in model.source.source.numbers.items()}
        forward = {name: function.expression.xreplace(known) for name, function in functions.items()}
        backward = [{name: expression.xreplace(known) for name, expression in b.items()} for b in inverse]
        if other_solutions_are_unphysical(forward, backward, units, axis.signed_parameters):
            identifiability |= dict.fromkeys(several, "unique")
    return ParameterMap(
        functions=functions,
        solution=solution,
        inverse=inverse,
        identifiability=identifiability,
        combinations=tuple(function for function in functions.values() if function.names & undetermined),
        relations=len(model.parameters) - point.rank,
        counted=counted,
    )


def inverse_map(model: MinimalModel) -> TriangularSolution | None:
    """Closed form of the inverse map; its polynomials are over the field of the minimal parameters.

    None if parameters are not determined, or not in closed form. Parameters without effect on signals are left out.
    """
    if any(len(parameter.function.numerator) > MOST_TERMS for parameter in model.parameters):
        return None
    names = list(model.source.source.axis.physical_parameters)
    constants = list(model.source.source.numbers)
    # The steps are tried at a random point modulo a prime, where numbers stay small: with symbols, an attempt that
    # leads nowhere may take minutes. A step that does not exist there does not exist in general.
    trial = _Point(model)
    seen = set().union(*(p.function.names for p in model.parameters)).intersection(names)
    if trial.undetermined() & seen or not _solves(trial.triangular(), names, seen):
        return None
    field = QQ.frac_field(*constants, *(parameter.name for parameter in model.parameters))
    ring = PolyRing(names, field)
    system = [
        _convert(p.function.numerator, ring)
        - _convert(p.function.denominator, ring) * field.from_sympy(sp.Symbol(p.name))
        for p in model.parameters
    ]
    solution = triangular_solution(system, len(names))
    return solution if _solves(solution, names, seen) else None


def _solves(solution: TriangularSolution, names: Sequence[str], wanted: set[str]) -> bool:
    """Whether all parameters wanted were solved for.

    Where numerator and denominator of a minimal parameter vanish together, its equation holds whatever the rest is:
    such a false solution leaves parameters open.
    """
    return not solution.left and {names[step.unknown] for step in solution.steps} == wanted


def _convert(polynomial: PolyElement, ring: PolyRing) -> PolyElement:
    """A polynomial of the operator model's ring, free of s, in a ring of the unknown parameters alone."""
    domain, symbols = polynomial.ring.domain, polynomial.ring.symbols
    unknown = set(ring.symbols)
    total: dict[tuple[int, ...], Any] = {}
    for m, c in polynomial.terms():
        powers = dict(zip(symbols, m, strict=True))
        known = sp.Mul(*(x**power for x, power in powers.items() if power and x not in unknown))
        key = tuple(powers.get(x, 0) for x in ring.symbols)
        total[key] = total.get(key, 0) + ring.domain.from_sympy(domain.to_sympy(c) * known)
    return ring.from_dict({key: c for key, c in total.items() if c})


def _branches(model: MinimalModel, solution: TriangularSolution) -> tuple[dict[str, sp.Expr], ...]:
    """Explicit expressions in the minimal parameters for each branch."""
    names = list(model.source.source.axis.physical_parameters)
    values: dict[sp.Symbol, sp.Expr] = {}
    roots: dict[sp.Symbol, sp.Expr] = {}  # kept apart: to factor square roots takes minutes
    signs: list[sp.Symbol] = []
    for step in reversed(solution.steps):
        parts = [part.as_expr().xreplace(values) for part in step.coefficients]
        symbol = sp.Symbol(names[step.unknown])
        if step.branches == 1:
            value = sp.factor(-parts[1] / parts[0])
        else:
            a, b, c = (sp.factor(part) for part in parts)
            signs.append(sp.Dummy("sign"))
            value = (-b + signs[-1] * sp.sqrt(b**2 - 4 * a * c)) / (2 * a)
        if step.branches == 2 or value.free_symbols & set(roots):
            roots[symbol] = value.xreplace(roots)
        else:
            values[symbol] = value
    values |= roots
    branches = []
    for chosen in product((1, -1), repeat=len(signs)):
        sign = dict(zip(signs, map(sp.Integer, chosen), strict=True))
        solved = {str(symbol): value.xreplace(sign) for symbol, value in values.items()}
        branches.append({name: solved[name] for name in names if name in solved})
    return tuple(branches)


class _Point:
    """The forward map at a random point, modulo a prime."""

    def __init__(self, model: MinimalModel) -> None:
        self.names = list(model.source.source.axis.physical_parameters)
        self.field = GF(_PRIME, symmetric=False)
        self.ring = PolyRing(self.names, self.field, grevlex)
        draw = Random(len(self.names))
        self.values = [self.field(draw.randrange(1, _PRIME)) for _ in self.names]
        self.constants = {name: draw.randrange(1, _PRIME) for name in model.source.source.numbers}
        self.functions = [(p.function.numerator, p.function.denominator) for p in model.parameters]
        self.evaluated = [(self._evaluated(n), self._evaluated(d)) for n, d in self.functions]
        self.is_small = all(len(n) <= MOST_TERMS for n, _ in self.functions)
        self.jacobian = self._jacobian()
        self.rank = self.jacobian.rank()

    def undetermined(self) -> set[str]:
        """Parameters that can change without changing any minimal parameter."""
        null = self.jacobian.nullspace().to_list()
        return {name for i, name in enumerate(self.names) if any(row[i] for row in null)}

    def system(self) -> list[PolyElement]:
        """Equations X(theta) = X(theta0), undetermined directions held at theta0."""
        # The solutions form a manifold if parameters are undetermined: each direction is fixed by one without pivot.
        _, pivots = self.jacobian.rref()
        held = {i: self.values[i] for i in range(len(self.names)) if i not in pivots}
        equations = [
            self._modular(n) - self._modular(d) * self.field(above.value) / self.field(below.value)
            for (n, d), (above, below) in zip(self.functions, self.evaluated, strict=True)
        ]
        fixed = [(self.ring.gens[i], value) for i, value in held.items()]
        return [e for equation in equations if (e := equation.subs(fixed) if fixed else equation)]

    def triangular(self) -> TriangularSolution:
        """Closed form at this point: the same steps exist for general minimal parameters."""
        return triangular_solution(self.system(), len(self.names))

    def with_several_values(self) -> tuple[set[str], bool]:
        """Parameters that take several values among all solutions, and whether these were counted.

        Monomial steps leave a core that only a Groebner basis can count; if it is too large, all its
        unknowns and those that depend on them are suspected.
        """
        if not self.is_small:
            return set(self.names) - self.undetermined(), False
        solution = triangular_solution(self.system(), len(self.names), simple=True)
        core = sorted({i for e in solution.left for i in range(len(self.names)) if e.degree(i) > 0})
        counted = len(core) <= _MOST_UNKNOWNS
        values = _count_values(solution.left, core, self.ring) if core and counted else dict.fromkeys(core, 2)
        several = {i for i, count in values.items() if count > 1}
        for step in reversed(solution.steps):
            if any(part.degree(i) > 0 for part in step.coefficients for i in several):
                several.add(step.unknown)
        return {self.names[i] for i in several}, counted

    def _modular(self, polynomial: PolyElement) -> PolyElement:
        symbols = list(map(str, polynomial.ring.symbols))
        places = [symbols.index(name) if name in symbols else None for name in self.names]
        known = [(i, self.field(self.constants[x])) for i, x in enumerate(symbols) if x in self.constants]
        total = self.ring.zero
        for m, c in polynomial.terms():
            value = prod((base ** m[i] for i, base in known if m[i]), start=self._number(c))
            total += self.ring.from_dict(
                {tuple(m[i] if i is not None else 0 for i in places): value} if value else {}
            )
        return total

    def _number(self, value: Any) -> Any:
        """A coefficient, which may hold known constants."""
        if isinstance(value, FracElement):
            point = [(x, self.constants[str(x)]) for x in value.numer.ring.gens]
            above, below = (self._number(part.evaluate(point)) for part in (value.numer, value.denom))
            return above / below
        return self.field(int(value.numerator)) / self.field(int(value.denominator))

    def _jacobian(self) -> DomainMatrix:
        rows = []
        for above, below in self.evaluated:
            scale = pow(below.value, -2, _PRIME)
            slopes = zip(above.gradient, below.gradient, strict=True)
            rows.append([self.field((n * below.value - above.value * d) * scale) for n, d in slopes])
        return DomainMatrix(rows, (len(rows), len(self.names)), self.field)

    def _evaluated(self, polynomial: PolyElement) -> _Evaluated:
        """Value and gradient of a polynomial at the point: sums over products of residues, which 64 bits hold."""
        symbols = list(map(str, polynomial.ring.symbols))
        powers = np.array(polynomial.monoms(), dtype=np.int64).reshape(len(polynomial), len(symbols))
        terms = np.array([int(self._number(c)) for c in polynomial.coeffs()], dtype=np.int64)
        point = {**self.constants, **dict(zip(self.names, map(int, self.values), strict=True))}
        for i, name in enumerate(symbols):
            if powers[:, i].any():
                table = [pow(point[name], k, _PRIME) for k in range(int(powers[:, i].max()) + 1)]
                terms = terms * np.array(table)[powers[:, i]] % _PRIME
        slopes = dict(zip(symbols, (terms @ powers).tolist(), strict=True))
        gradient = tuple(slopes.get(name, 0) * pow(point[name], -1, _PRIME) % _PRIME for name in self.names)
        return _Evaluated(int(terms.sum()) % _PRIME, gradient)


class _Evaluated(NamedTuple):
    """Value and gradient of a polynomial at a point, modulo a prime."""

    value: int
    gradient: tuple[int, ...]


def _count_values(system: Sequence[PolyElement], involved: Sequence[int], ring: PolyRing) -> dict[int, int]:
    """How many values each unknown takes among the non-zero solutions of a polynomial system.

    A new unknown t with t * (product of the unknowns) = 1 keeps solutions with a zero out. The number of values is
    the degree of the square-free part of the unknown's minimal polynomial modulo the ideal.
    """
    small = PolyRing(("t", *(str(ring.symbols[i]) for i in involved)), ring.domain, grevlex)
    moved = [small.from_dict({(0, *(m[i] for i in involved)): c for m, c in e.terms()}) for e in system]
    nonzero = small.from_dict({(1,) * len(small.gens): small.domain.one}) - 1
    basis = groebner([*moved, nonzero], small)
    return {
        i: _number_of_values(generator, basis) for i, generator in zip(involved, small.gens[1:], strict=True)
    }


def _number_of_values(unknown: PolyElement, basis: Sequence[PolyElement]) -> int:
    span, power, degree = Span(), unknown.ring.one, 0
    while span.add(dict(power.terms())):
        power = (power * unknown).rem(list(basis))
        degree += 1
    relation = span.coordinates(dict(power.terms())) or {}
    polynomial = [1] + [
        int(-relation.get(i, unknown.ring.domain.zero)) % _PRIME for i in reversed(range(degree))
    ]
    return int(dup_degree(gf_sqf_part(polynomial, _PRIME, sp.ZZ)))
