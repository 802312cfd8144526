"""Expressions of the law language in C99."""

import re
from collections.abc import Iterable, Sequence
from typing import Any

import sympy as sp
from sympy.printing.c import C99CodePrinter, reserved_words, reserved_words_c99

_RESERVED = {
    *reserved_words,
    *reserved_words_c99,
    *re.findall(
        r"\w+",
        """NAN INFINITY HUGE_VAL EOF NULL p x dx signals W y X sign positive force n h r v d q i j k low high
        impulse response joint joints inverse way late before note noted followed sweep sweeps moved moving speed own
        wanted change now has_jump""",
    ),
}
"""Words of C and names that the exported functions use."""
_MOST_FACTORS = 4  # powers up to it are written as products


class _CPrinter(C99CodePrinter):  # type: ignore[misc]  # sympy has no types
    """Prints numbers as doubles, small powers as products, and jumps as calls of `sign` and `positive`."""

    def _print_Integer(self, expression: Any) -> str:
        return f"{int(expression)}.0"

    def _print_Rational(self, expression: Any) -> str:
        return f"{expression.p}.0/{expression.q}.0"

    def _print_Pow(self, expression: Any) -> str:
        base, power = expression.args
        if power.is_Integer and 2 <= power <= _MOST_FACTORS and base.is_Symbol:
            return "(" + "*".join([self._print(base)] * int(power)) + ")"
        return str(super()._print_Pow(expression))

    def _print_sign(self, expression: Any) -> str:
        return f"sign({self._print(expression.args[0])})"

    def _print_positive(self, expression: Any) -> str:
        return f"positive({self._print(expression.args[0])})"


def c_code(expression: sp.Expr) -> str:
    """C code of an expression; every number in it is a double.

    >>> x = sp.Symbol("x")
    >>> c_code(sp.Rational(1, 2) * x**3 - sp.sign(x) * abs(x))
    '(1.0/2.0)*(x*x*x) - fabs(x)*sign(x)'
    """
    return str(_CPrinter().doprint(expression))


def c_name(name: str) -> str:
    """A name that is free in C; an appended underscore occurs in no name of a parameter or signal.

    >>> c_name("Mm"), c_name("double")
    ('Mm', 'double_')
    """
    taken = name in _RESERVED or name.startswith(("M_", "FP_", "MATH_", "HUGE_VAL"))
    return f"{name}_" if taken else name


def assignments(targets: Sequence[str], expressions: Sequence[sp.Expr], taken: Iterable[str]) -> list[str]:
    """Statements that assign expressions to targets, after their common subexpressions.

    >>> a, b = sp.symbols("a b")
    >>> assignments(["u", "w"], [sp.sin(a + b), 2 * sp.sin(a + b)], ())
    ['const double c0 = sin(a + b);', 'u = c0;', 'w = 2.0*c0;']
    """
    names = set(taken)
    free = (s for s in sp.numbered_symbols("c") if str(s) not in names)
    shared, reduced = sp.cse(list(expressions), symbols=free, order="canonical")
    return [
        *(f"const double {symbol} = {c_code(value)};" for symbol, value in shared),
        *(f"{target} = {c_code(value)};" for target, value in zip(targets, reduced, strict=True)),
    ]
