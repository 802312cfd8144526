"""The map X(theta) from physical to minimal parameters at a random point theta0, modulo a prime.

What holds at a random point holds in general, with overwhelming probability. The null space of the Jacobian shows which
parameters are not determined at all; the number of solutions of X(theta) = X(theta0), which are determined uniquely.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import prod
from random import Random
from typing import Any, NamedTuple

import numpy as np
import sympy as sp
from sympy import GF
from sympy.polys.densebasic import dup_degree
from sympy.polys.fields import FracElement
from sympy.polys.galoistools import gf_sqf_part
from sympy.polys.groebnertools import groebner
from sympy.polys.matrices import DomainMatrix
from sympy.polys.orderings import grevlex
from sympy.polys.rings import PolyElement, PolyRing

from symid.symbolic.minimal import MinimalModel
from symid.symbolic.polynomials import context
from symid.symbolic.span import Span
from symid.symbolic.triangular_systems import MOST_TERMS, TriangularSolution, triangular_solution

_PRIME = 2**31 - 1
_MOST_UNKNOWNS = 4  # unknowns for which a Groebner basis is computed at most; more take too long


class GenericPoint:
    """The forward map of a minimal model at a random point, modulo a prime."""

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
        """Parameters that can change while all minimal parameters stay the same."""
        null = self.jacobian.nullspace().to_list()
        return {name for i, name in enumerate(self.names) if any(row[i] for row in null)}

    def system(self) -> list[PolyElement]:
        """Equations X(theta) = X(theta0), with undetermined directions held at theta0."""
        # If parameters are undetermined, the solutions form a manifold. Fixing the parameters without pivot in the
        # Jacobian's echelon form fixes one parameter for each of its directions.
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
        return self._triangular(simple=False)

    def with_several_values(self) -> tuple[set[str], bool]:
        """Parameters with several values among all solutions, and whether the values were counted.

        Linear steps with monomial coefficients reduce the system to a core, whose solutions a Groebner basis counts. If
        the core is too large, all its unknowns, and those that depend on them, are assumed to have several.
        """
        if not self.is_small:
            return set(self.names) - self.undetermined(), False
        solution = self._triangular(simple=True)
        core = sorted({i for e in solution.left for i, degree in enumerate(e.degrees()) if degree > 0})
        counted = len(core) <= _MOST_UNKNOWNS
        values = _count_values(solution.left, core, self.ring) if core and counted else dict.fromkeys(core, 2)
        several = {i for i, count in values.items() if count > 1}
        for step in reversed(solution.steps):
            if any(part.degrees()[i] > 0 for part in step.coefficients for i in several):
                several.add(step.unknown)
        return {self.names[i] for i in several}, counted

    def _triangular(self, *, simple: bool) -> TriangularSolution:
        ring = context(tuple(self.names), _PRIME)
        system = [ring.from_dict({m: int(c) for m, c in e.items()}) for e in self.system()]
        return triangular_solution(system, len(self.names), simple=simple)

    def _modular(self, polynomial: PolyElement) -> PolyElement:
        known = {name: self.field(value) for name, value in self.constants.items()}
        return moved(polynomial, self.ring, self._number, known)

    def _number(self, value: Any) -> Any:
        """A coefficient, which may contain known constants."""
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
        """Value and gradient of a polynomial at the point; products of two residues fit into 64 bits."""
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


def moved(
    polynomial: PolyElement, ring: PolyRing, number: Callable[[Any], Any], known: Mapping[str, Any]
) -> PolyElement:
    """A polynomial in another ring: `number` converts coefficients, `known` gives values of generators it lacks.

    A generator with neither must not occur, as s does not occur in parameters.
    """
    names, to_names = list(map(str, polynomial.ring.symbols)), list(map(str, ring.symbols))
    values = [(i, known[name]) for i, name in enumerate(names) if name in known and name not in to_names]
    places = [names.index(name) if name in names else None for name in to_names]
    total: dict[tuple[int, ...], Any] = {}
    for m, c in polynomial.terms():
        value = prod((base ** m[i] for i, base in values if m[i]), start=number(c))
        key = tuple(0 if i is None else m[i] for i in places)
        total[key] = total[key] + value if key in total else value
    return ring.from_dict({key: c for key, c in total.items() if c})


def _count_values(system: Sequence[Any], involved: Sequence[int], ring: PolyRing) -> dict[int, int]:
    """Number of values of each unknown among the non-zero solutions of a polynomial system.

    An extra unknown t with t * (product of the unknowns) = 1 excludes solutions with a zero. The number of values is
    the degree of the square-free part of the unknown's minimal polynomial modulo the ideal.
    """
    small = PolyRing(("t", *(str(ring.symbols[i]) for i in involved)), ring.domain, grevlex)
    moved = [
        small.from_dict({(0, *(int(m[i]) for i in involved)): small.domain(int(c)) for m, c in e.terms()})
        for e in system
    ]
    nonzero = small.from_dict({(1,) * len(small.gens): small.domain.one}) - 1
    basis = groebner([*moved, nonzero], small)
    return {
        i: _number_of_values(generator, basis) for i, generator in zip(involved, small.gens[1:], strict=True)
    }


def _number_of_values(unknown: PolyElement, basis: Sequence[PolyElement]) -> int:
    # The first power of the unknown whose normal form depends on those of lower powers gives its minimal polynomial.
    span, power, degree = Span(), unknown.ring.one, 0
    while span.add(dict(power.terms())):
        power = (power * unknown).rem(list(basis))
        degree += 1
    relation = span.coordinates(dict(power.terms())) or {}
    polynomial = [1] + [
        int(-relation.get(i, unknown.ring.domain.zero)) % _PRIME for i in reversed(range(degree))
    ]
    return int(dup_degree(gf_sqf_part(polynomial, _PRIME, sp.ZZ)))
