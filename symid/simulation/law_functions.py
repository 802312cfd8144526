"""Expressions of laws as functions: of two numbers for the steps of a simulation, of two arrays for a whole log."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import sympy as sp

from symid.arrays import FloatArray
from symid.codegen.lowering import code
from symid.simulation.scalar import Scalar


def law_function(expression: sp.Expr, numbers: tuple[str, ...] = ()) -> Callable[..., float]:
    """Law expression in q and v as a function of two numbers.

    Parameters
    ----------
    expression : sympy expression
        In q, v and `numbers`.
    numbers : tuple of str
        Further arguments of the function, behind q and v.

    Examples
    --------
    >>> law_function(sp.sympify("v*q"))(2.0, 3.0)
    6.0
    >>> law_function(sp.sympify("v/speed"), ("speed",))(0.0, 1.0, 0.5)
    2.0
    """
    function: Callable[..., float] = _function(f"float({code(expression)})", numbers, Scalar())
    return function


def array_function(expression: sp.Expr, numbers: tuple[str, ...] = ()) -> Callable[..., FloatArray]:
    """Law expression in q and v as a function of two arrays; `numbers` as in `law_function`.

    Examples
    --------
    >>> array_function(sp.sympify("v*q"))(np.array([2.0, 1.0]), np.array([3.0, 4.0])).tolist()
    [6.0, 4.0]
    """
    constant = " + 0 * q" if not expression.has(sp.Symbol("q"), sp.Symbol("v")) else ""
    function: Callable[..., FloatArray] = _function(f"{code(expression)}{constant}", numbers, np)
    return function


def _function(text: str, numbers: tuple[str, ...], library: object) -> Any:
    return eval(f"lambda {', '.join(('q', 'v', *numbers))}: {text}", {"np": library})
