"""Expressions of laws as functions: of two numbers for the steps of a simulation, of two arrays for a whole log."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import sympy as sp

from symid.arrays import FloatArray
from symid.codegen.lowering import code


def law_function(expression: sp.Expr, numbers: tuple[str, ...] = ()) -> Callable[..., float]:
    """Law expression in q, v and further `numbers` as a function of two numbers and these.

    >>> law_function(sp.sympify("v*q"))(2.0, 3.0)
    6.0
    >>> law_function(sp.sympify("v/speed"), ("speed",))(0.0, 1.0, 0.5)
    2.0
    """
    function: Callable[..., float] = _function(f"float({code(expression)})", numbers, Scalar())
    return function


def array_function(expression: sp.Expr, numbers: tuple[str, ...] = ()) -> Callable[..., FloatArray]:
    """Law expression in q and v as a function of two arrays; `numbers` as in `law_function`.

    >>> array_function(sp.sympify("v*q"))(np.array([2.0, 1.0]), np.array([3.0, 4.0])).tolist()
    [6.0, 4.0]
    """
    constant = " + 0 * q" if not expression.has(sp.Symbol("q"), sp.Symbol("v")) else ""
    function: Callable[..., FloatArray] = _function(f"{code(expression)}{constant}", numbers, np)
    return function


def _function(text: str, numbers: tuple[str, ...], library: object) -> Any:
    return eval(f"lambda {', '.join(('q', 'v', *numbers))}: {text}", {"np": library})


class Scalar:
    """Functions of the law language for single numbers, in place of ``np``: ten times as fast, of the same values.

    All others come from NumPy.

    >>> np_ = Scalar()
    >>> np_.sign(-2.0), np_.heaviside(0.0, 0.5), np_.exp(1e3), float(np_.sqrt(4.0))
    (-1.0, 0.5, inf, 2.0)
    """

    abs = staticmethod(abs)
    cos = staticmethod(math.cos)
    maximum = staticmethod(max)
    minimum = staticmethod(min)
    sin = staticmethod(math.sin)

    @staticmethod
    def sign(x: float) -> float:
        """Sign of a number: 1, 0 or -1."""
        return 1.0 if x > 0.0 else -1.0 if x < 0.0 else 0.0

    @staticmethod
    def heaviside(x: float, at_zero: float) -> float:
        """Unit step with a given value at 0."""
        return 1.0 if x > 0.0 else 0.0 if x < 0.0 else at_zero

    @staticmethod
    def exp(x: float) -> float:
        """Exponential; infinite where it is beyond the largest number."""
        return math.exp(x) if x < 709.0 else math.inf

    def __getattr__(self, name: str) -> Any:
        return getattr(np, name)
