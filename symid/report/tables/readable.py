"""Formulas with numbers as a reader takes them: 1.59155e-3 in place of a fraction of twenty digits."""

from __future__ import annotations

from typing import Any, Final

import sympy as sp

from symid.symbolic.parameter_function import ParameterFunction

_LONGEST: Final = 10_000
"""Fractions of smaller numbers are kept, as 16/25 is."""
_DIGITS: Final = 6


def readable(formula: sp.Expr | ParameterFunction) -> str:
    """A formula as text, its long fractions as decimals of six digits.

    A quotient is divided by the largest number below its line first, so that none is left with a power of ten on both
    sides.

    >>> M, J, K = sp.symbols("M J K")
    >>> readable(J + sp.Rational(16129, 400000000) * M), readable(sp.Rational(16, 25) * M)
    ('J + 4.03225e-5*M', '16*M/25')
    >>> readable((312500000000 * M + 497359197162 * J) / (625000000000 * K))
    '(0.795775*J + M/2)/K'
    """
    if isinstance(formula, ParameterFunction):
        if formula.is_long:
            return str(formula)
        formula = formula.expression
    if not any(map(_is_long, formula.atoms(sp.Rational))):
        return str(formula)
    quotients = map(_quotient, sp.Add.make_args(formula))
    return str(sp.sstr(_in_decimals(sp.Add(*quotients)), full_prec=False))


def _quotient(expression: sp.Expr) -> sp.Expr:
    above, below = expression.as_numer_denom()
    largest = max(abs(term.as_coeff_Mul()[0]) for term in sp.Add.make_args(below))
    return _divided(above, largest) / _divided(below, largest)


def _divided(expression: sp.Expr, number: Any) -> sp.Expr:
    terms = (term.as_coeff_Mul() for term in sp.Add.make_args(expression))
    return sp.Add(*(_in_decimals(factor / number) * rest for factor, rest in terms))


def _in_decimals(expression: sp.Expr) -> sp.Expr:
    long = filter(_is_long, expression.atoms(sp.Rational))
    return expression.xreplace({number: sp.Float(f"{float(number):.{_DIGITS}g}") for number in long})


def _is_long(number: sp.Rational) -> bool:
    return bool(max(abs(number.p), number.q) >= _LONGEST)
