"""Lowering of polynomials and signal expressions to flat NumPy assignments.

Polynomials are written in Horner's form, one variable after the other in the order of the declaration. Common
subexpressions are written once: the minimal parameters of a chain share almost everything, and the 45 000 terms of an
axis with eight masses become a few hundred operations.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import cache
from itertools import compress, groupby
from operator import itemgetter
from typing import Any

import sympy as sp
from sympy import QQ
from sympy.polys.rings import PolyElement
from sympy.printing.numpy import NumPyPrinter

from symid.symbolic import MinimalParameter, ParameterFunction

_LARGEST_EXACT = 2**53
"""Integers beyond it are not all doubles."""


class _ModulePrinter(NumPyPrinter):  # type: ignore[misc]  # sympy has no types
    """Prints expressions of the law language with ``np`` as NumPy's name."""

    def _module_format(self, fqn: str, register: bool = True) -> str:
        return str(super()._module_format(fqn, register)).replace("numpy.", "np.")

    def _print_positive(self, expression: Any) -> str:
        return f"np.heaviside({self._print(expression.args[0])}, 0.0)"


def numpy_code(expression: sp.Expr) -> str:
    """NumPy code of an expression.

    >>> numpy_code(sp.sympify("-sign(q_d1) + 2*q"))
    '2*q - np.sign(q_d1)'
    """
    return str(_ModulePrinter().doprint(expression))


class PolynomialLowering:
    """Collects assignments that compute polynomials.

    Each generator has the name of a variable, or None if it never occurs; `write` writes a coefficient.
    """

    def __init__(self, names: Sequence[str | None], write: Callable[[sp.Expr], str] = numpy_code) -> None:
        self.names = tuple(names)
        self._write, self._one = write, write(sp.S.One)
        self.assignments: list[tuple[str, str]] = []
        self._prefix = "c__" if any(name and re.fullmatch(r"c\d+", name) for name in names) else "c"
        self._known: dict[tuple[int, tuple[tuple[int, str], ...]], str] = {}

    def lower(self, polynomial: PolyElement) -> str:
        """Code of a polynomial in terms of variables and earlier assignments."""
        number = cache(lambda c: self._write(_number(c, polynomial.ring.domain)))
        ordered = sorted(polynomial.items(), key=itemgetter(0), reverse=True)
        return self._lower([m for m, _ in ordered], [number(c) for _, c in ordered], 0)

    def _lower(self, monomials: Sequence[tuple[int, ...]], numbers: Sequence[str], variable: int) -> str:
        """Code of terms in falling order that agree in the variables before this one."""
        if len(monomials) == 1:
            (monomial,), (text,) = monomials, numbers
            for i in reversed([*compress(range(len(monomial)), monomial)]):
                text = self._horner(str(self.names[i]), {monomial[i]: text}) if i >= variable else text
            return text
        # Terms are grouped by the power of one variable; the coefficient of each power is lowered recursively, and the
        # key (variable, coefficients) finds polynomials that were written before.
        while not monomials[0][variable]:
            variable += 1
        parts, first = [], 0
        for power, group in groupby(monomials, key=itemgetter(variable)):
            last = first + len(list(group))
            parts.append((power, self._lower(monomials[first:last], numbers[first:last], variable + 1)))
            first = last
        key = (variable, tuple(parts))
        if key not in self._known:
            self._known[key] = name = f"{self._prefix}{len(self.assignments)}"
            self.assignments.append((name, self._horner(str(self.names[variable]), dict(parts))))
        return self._known[key]

    def _horner(self, name: str, parts: Mapping[int, str]) -> str:
        text = ""
        for power in range(max(parts), -1, -1):
            if text:
                text = f"{name}*{as_factor(text)}" if text != self._one else name
            if power in parts:
                text = f"{text} + {parts[power]}" if text else parts[power]
        return text


def minimal_parameter_code(
    parameters: Sequence[MinimalParameter],
    names: Sequence[str | None],
    write: Callable[[sp.Expr], str] = numpy_code,
) -> tuple[list[tuple[str, str]], list[str]]:
    """Assignments of common subexpressions of minimal parameters, and the code of each parameter."""
    lowering, results = PolynomialLowering(names, write), []
    for parameter in parameters:
        above, below = map(lowering.lower, _scaled(parameter.function))
        results.append(above if below == write(sp.S.One) else f"{as_factor(above)}/{as_factor(below)}")
    return lowering.assignments, results


def _scaled(function: ParameterFunction) -> tuple[PolyElement, PolyElement]:
    """Numerator and denominator, over its largest coefficient where doubles do not hold all numbers."""
    above, below = function.numerator, function.denominator
    if above.ring.domain != QQ or all(map(_is_exact, (*above.coeffs(), *below.coeffs()))):
        return above, below
    scale = 1 / max(map(abs, below.coeffs()))
    return above.mul_ground(scale), below.mul_ground(scale)


def _number(value: Any, domain: Any) -> sp.Expr:
    """A coefficient; rounded to double precision if its numerator or denominator has more digits."""
    if domain != QQ or _is_exact(value):
        return domain.to_sympy(value)
    return sp.Float(float(Fraction(int(value.numerator), int(value.denominator))), 17)


def _is_exact(value: Any) -> bool:
    """Whether numerator and denominator of a rational number are integers that a double holds."""
    return bool(max(abs(value.numerator), value.denominator) <= _LARGEST_EXACT)


def as_factor(text: str) -> str:
    """Code in parentheses unless it is a single name or number."""
    return text if text.isidentifier() or text.isdigit() else f"({text})"


def symbol_names(expressions: Sequence[sp.Expr]) -> tuple[str, ...]:
    """Names of all signals in some expressions, sorted."""
    return tuple(sorted({str(symbol) for expression in expressions for symbol in expression.free_symbols}))
