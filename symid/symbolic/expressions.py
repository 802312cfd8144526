"""Law expressions as sympy expressions, and their total derivative by time."""

from collections.abc import Mapping
from functools import cache
from typing import Any

import sympy as sp
from sympy.parsing.sympy_parser import parse_expr

from symid.axis import LAW_FUNCTIONS, Axis, EncoderRipple, Imperfection
from symid.errors import SymidError


class positive(sp.Function):  # type: ignore[misc]  # noqa: N801  sympy has no types; a name of the law language
    """1 for an argument above 0, else 0; its derivative is set to zero, as that of sign."""

    nargs = 1

    @classmethod
    def eval(cls, argument: Any) -> Any:
        """Value for numbers; unevaluated otherwise."""
        return sp.Integer(int(bool(argument > 0))) if argument.is_Number else None

    def fdiff(self, argindex: int = 1) -> Any:
        """Derivative, zero by convention."""
        return sp.Integer(0)


_LANGUAGE = {
    "q": sp.Symbol("q"),
    "v": sp.Symbol("v"),
    **{name: {"positive": positive, "abs": sp.Abs}.get(name) or getattr(sp, name) for name in LAW_FUNCTIONS},
}
_OF_IMPERFECTIONS = {"min": sp.Min, "max": sp.Max}
FORCE, READING, TIME, MEMORY = (sp.Symbol(name) for name in "Fytz")
"""Symbols on which the law of an imperfection depends besides q and v."""


def parameter_symbol(name: str) -> sp.Symbol:
    """Symbol of a physical parameter."""
    return sp.Symbol(name)


def exact(value: float) -> sp.Rational:
    """A known number as it was written: 0.35 is 7/20, not the nearest binary fraction.

    >>> exact(0.35), exact(12)
    (7/20, 12)
    """
    return sp.Rational(str(float(value)))


@cache
def law_expression(text: str) -> sp.Expr:
    """Expression of a law's term in q and v.

    >>> law_expression("v*positive(v)").free_symbols
    {v}
    """
    try:
        expression = _parsed(text, _LANGUAGE)
        unknown = sorted({str(s) for s in expression.free_symbols}.difference({"q", "v"}))
    except Exception as error:
        raise SymidError(
            f"law expression {text!r} cannot be read: use q, v, numbers and {', '.join(_LANGUAGE)}"
        ) from error
    if unknown:
        raise SymidError(f"law expression {text!r} uses {', '.join(unknown)}: only q and v vary in a law")
    return expression


def imperfection_law(element: Imperfection) -> sp.Expr:
    """Formula of an imperfection in q, v, `FORCE`, `READING`, `TIME` and `MEMORY`.

    >>> from symid.axis import ForceLimit
    >>> imperfection_law(ForceLimit(25.0))
    Min(25.0, Max(-25.0, F))
    """
    return _parsed(element.in_numbers(element.law), {**_LANGUAGE, **_OF_IMPERFECTIONS})


def misread(axis: Axis, signal: str) -> sp.Expr | None:
    """Reading of a sensor with ripple in terms of the exact value, `READING`; None without ripple."""
    ripples = [e for e in axis.elements if isinstance(e, EncoderRipple) and e.signal == signal]
    return READING + sum(imperfection_law(ripple) - READING for ripple in ripples) if ripples else None


def imperfection_rate(element: Imperfection) -> sp.Expr:
    """Time derivative of its memory, in the same symbols.

    >>> from symid.axis import ActuatorLag
    >>> imperfection_rate(ActuatorLag(0.5))
    2.0*F - 2.0*z
    """
    return _parsed(element.in_numbers(element.rate), _LANGUAGE)


def _parsed(text: str, language: Mapping[str, Any]) -> sp.Expr:
    classes = {name: getattr(sp, name) for name in ("Integer", "Float", "Rational", "Symbol")}
    return parse_expr(text, local_dict=dict(language), global_dict=classes)


def is_smooth(expression: sp.Expr) -> bool:
    """Whether an expression has no jumps, so that its derivative needs no assumption."""
    return not expression.has(sp.sign, positive)


def time_derivative(expression: sp.Expr, displacement: tuple[sp.Symbol, ...]) -> sp.Expr:
    """Total derivative of an expression in a displacement and its derivatives (`displacement[k]`, real, is the k-th).

    The derivatives of jumps (sign and positive) are set to zero, as in the paper below its eq. [11].
    """
    return sp.Add(
        *(
            sp.diff(expression, symbol).replace(sp.DiracDelta, lambda *_: sp.Integer(0))
            * displacement[order + 1]
            for order, symbol in enumerate(displacement[:-1])
            if expression.has(symbol)
        )
    )
