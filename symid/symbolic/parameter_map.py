"""Maps between minimal and physical parameters, and the identifiability of the physical ones.

The forward map X(theta) is part of the minimal model. It is inverted in closed form, with all branches, where one
unknown after the other can be solved for (paper below [41]). `GenericPoint` decides for each physical parameter whether
the sensors determine it, and whether uniquely.
"""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from itertools import product
from typing import Any, Literal

import numpy as np
import sympy as sp
from sympy.polys.fields import FracElement

from symid.symbolic.generic_point import GenericPoint
from symid.symbolic.minimal import MinimalModel
from symid.symbolic.parameter_function import ParameterFunction
from symid.symbolic.polynomials import context, expression
from symid.symbolic.triangular_systems import MOST_TERMS, TriangularSolution, triangular_solution

_MOST_WRITTEN = 600
"""Terms of an inverse map beyond which it is not written out as expressions, only as the steps of its module."""

Identifiability = Literal["unique", "several", "none"]


@dataclass(frozen=True)
class ParameterMap:
    """Maps between minimal and physical parameters."""

    functions: Mapping[str, ParameterFunction]  # minimal parameters in terms of the physical ones
    solution: TriangularSolution | None  # closed form of the inverse map, None if there is none
    # physical parameters in terms of the minimal ones, one mapping for each branch; empty without closed form
    inverse: tuple[Mapping[str, sp.Expr], ...]
    # number of values of each physical parameter; closed-form solutions count only with the declared signs
    identifiability: Mapping[str, Identifiability]
    combinations: tuple[ParameterFunction, ...]  # determined functions of undetermined parameters
    relations: (
        int  # excess of minimal over determined physical parameters: relations that a correct model satisfies
    )
    counted: (
        bool  # whether solutions were counted; otherwise "several" means determined locally, number unknown
    )

    @cached_property
    def minimal(self) -> dict[str, sp.Expr]:
        """Minimal parameters in terms of the physical ones, as expressions."""
        return {name: function.expression for name, function in self.functions.items()}

    def __str__(self) -> str:
        """Minimal parameters, the first solution of the inverse map, and the identifiability."""
        lines = [f"{name} = {function}" for name, function in self.functions.items()]
        lines += [
            f"{name} = {expression}" for branch in self.inverse[:1] for name, expression in branch.items()
        ]
        lines += [f"{name}: {determined}" for name, determined in self.identifiability.items()]
        return "\n".join(lines)


def parameter_map(model: MinimalModel) -> ParameterMap:
    """Parameter map of a minimal model.

    >>> from symid.symbolic.pipeline import derive
    >>> from symid.axis import load_axis
    >>> parameter_map(derive(load_axis("direct_2m1s"), ("q2",)).minimal).inverse[0]["Mm"]
    -X2*X3 + X5
    """
    names = list(model.source.source.axis.physical_parameters)
    point = GenericPoint(model)
    undetermined = point.undetermined()
    several, counted = point.with_several_values()
    identifiability: dict[str, Identifiability] = {
        name: "none" if name in undetermined else "several" if name in several else "unique" for name in names
    }
    functions = {parameter.name: parameter.function for parameter in model.parameters}
    solution = inverse_map(model)
    written = sum(map(len, (c for step in solution.steps for c in step.coefficients))) if solution else 0
    inverse = _branches(model, solution) if solution and written <= _MOST_WRITTEN else ()
    axis = model.source.source.axis
    units = {name: str(unit) for name, unit in axis.physical_parameters.items()}
    # Of several solutions, others than the true one may all have masses or frictions below zero.
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
    """Closed form of the inverse map, in polynomials over the field of the minimal parameters.

    None if there is no closed form, or parameters are not determined. Parameters without effect on signals are omitted.
    """
    if any(len(parameter.function.numerator) > MOST_TERMS for parameter in model.parameters):
        return None
    names = list(model.source.source.axis.physical_parameters)
    constants = list(model.source.source.numbers)
    # The steps are first tried at a random point modulo a prime, where numbers remain small: with symbols, a failing
    # attempt may take minutes. A step that does not exist there does not exist in general.
    trial = GenericPoint(model)
    seen = set().union(*(p.function.names for p in model.parameters)).intersection(names)
    if trial.undetermined() & seen or not _solves(trial.triangular(), names, seen):
        return None
    ring = context((*names, *constants, *(parameter.name for parameter in model.parameters)))
    system = [
        _cleared(p.function, ring.gens()[len(names) + len(constants) + i], ring)
        for i, p in enumerate(model.parameters)
    ]
    solution = triangular_solution(system, len(names))
    return solution if _solves(solution, names, seen) else None


def _cleared(function: ParameterFunction, value: Any, ring: Any) -> Any:
    """The equation function = value in FLINT's ring, multiplied by what its coefficients are divided by."""
    names = list(map(str, function.numerator.ring.symbols))
    sums: dict[str, tuple[Any, Any]] = {}
    for part, factor in ((function.numerator, ring.constant(1)), (function.denominator, -value)):
        of_coefficient: dict[Any, dict[tuple[int, ...], int]] = {}
        for monomial, c in part.items():
            of_coefficient.setdefault(c, {})[monomial] = 1
        for c, terms in of_coefficient.items():
            above, below = _in_ring(c, ring)
            total, _ = sums.get(str(below), (0, below))
            sums[str(below)] = total + above * factor * _of_terms(terms, names, ring), below
    common = reduce(lambda one, other: one * (other / one.gcd(other)), (below for _, below in sums.values()))
    return sum(above * (common / below) for above, below in sums.values())


def _in_ring(number: Any, ring: Any) -> tuple[Any, Any]:
    """Numerator and denominator of a coefficient, which may contain constants."""
    if not isinstance(number, FracElement):
        return ring.constant(number), ring.constant(1)
    names = list(map(str, number.numer.ring.symbols))
    return _of_terms(number.numer, names, ring), _of_terms(number.denom, names, ring)


def _of_terms(terms: Mapping[tuple[int, ...], Any], names: Sequence[str], ring: Any) -> Any:
    """A polynomial of a ring, given by its terms in generators with names; those that the ring lacks do not occur."""
    from_place = {name: place for place, name in enumerate(names)}
    places = [from_place.get(name) for name in ring.names()]
    return ring.from_dict(
        {tuple(0 if i is None else monomial[i] for i in places): c for monomial, c in terms.items()}
    )


def _solves(solution: TriangularSolution, names: Sequence[str], wanted: set[str]) -> bool:
    """Whether exactly the wanted parameters were solved for.

    If numerator and denominator of a minimal parameter vanish together, its equation holds for any values of the other
    parameters; such a spurious solution leaves parameters open.
    """
    return not solution.left and {names[step.unknown] for step in solution.steps} == wanted


def _branches(model: MinimalModel, solution: TriangularSolution) -> tuple[dict[str, sp.Expr], ...]:
    """Explicit expressions in the minimal parameters for each branch."""
    names = list(model.source.source.axis.physical_parameters)
    values: dict[sp.Symbol, sp.Expr] = {}
    # kept separate: factoring expressions with square roots takes minutes
    roots: dict[sp.Symbol, sp.Expr] = {}
    signs: list[sp.Symbol] = []
    for step in reversed(solution.steps):
        parts = [expression(part).xreplace(values) for part in step.coefficients]
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


_DRAWS = 400
_RARE = 0.01
"""Share of the draws below which a second solution with the right signs does not matter in practice."""
_RANGES: Mapping[str, tuple[float, float]] = {
    "kg": (0.0, 3.5),
    "kg*m^2": (-4.0, 1.0),
    "N*s/m": (1.0, 4.0),
    "N*m*s/rad": (-4.0, 0.0),
    "N/m": (6.0, 9.0),
    "N*m/rad": (2.0, 5.0),
}
"""Range of the parameters of machine axes by unit, as powers of ten; 1 to 1000 for other units."""


def other_solutions_are_unphysical(
    minimal: Mapping[str, sp.Expr],
    inverse: Sequence[Mapping[str, sp.Expr]],
    units: Mapping[str, str],
    signed: Sequence[str],
) -> bool:
    """Whether almost no machine has a second solution in which all parameters have the required signs.

    `minimal` gives the minimal parameters in terms of the physical ones, `inverse` the physical ones of each solution
    in terms of the minimal ones. Parameters in `signed` may be negative.
    """
    # Drawn machines are mapped to their minimal parameters, and these back by each solution of the inverse map.
    names = list(units)
    generator = np.random.default_rng(0)
    truth = [10 ** generator.uniform(*_RANGES.get(unit, (0.0, 3.0)), _DRAWS) for unit in units.values()]
    forward = sp.lambdify(sp.symbols(names), list(minimal.values()), "numpy")
    values = [np.broadcast_to(np.asarray(x, dtype=complex), _DRAWS) for x in forward(*truth)]
    seconds = np.zeros(_DRAWS)
    for branch in inverse:
        known = [name for name in names if name in branch]
        solve = sp.lambdify(sp.symbols(list(minimal)), [branch[name] for name in known], "numpy")
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            solved = [np.broadcast_to(np.asarray(x, dtype=complex), _DRAWS) for x in solve(*values)]
        admissible, same = np.ones((2, _DRAWS), dtype=bool)
        for name, value in zip(known, solved, strict=True):
            true = truth[names.index(name)]
            admissible &= (np.abs(value.imag) < 1e-6 * np.abs(true)) & ((value.real > 0) | (name in signed))
            same &= np.abs(value - true) < 1e-3 * np.abs(true)
        seconds += admissible & ~same
    return bool(np.mean(seconds > 0) < _RARE)
