"""Expressions of laws as functions of two numbers (steps of a simulation) or of two arrays (a whole log)."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any

import numpy as np

from symid.arrays import FloatArray


def law_function(code: str, numbers: tuple[str, ...] = ()) -> Callable[..., float]:
    """Function of numbers q, v and further `numbers` for the NumPy code of a law.

    >>> law_function("v*q")(2.0, 3.0)
    6.0
    >>> law_function("v/speed", ("speed",))(0.0, 1.0, 0.5)
    2.0
    """
    function: Callable[..., float] = _function(f"float({code})", numbers, Scalar())
    return function


def array_function(code: str, numbers: tuple[str, ...] = ()) -> Callable[..., FloatArray]:
    """Function of arrays q and v for the NumPy code of a law; `numbers` as in `law_function`.

    >>> array_function("v*q")(np.array([2.0, 1.0]), np.array([3.0, 4.0])).tolist()
    [6.0, 4.0]
    """
    constant = "" if re.search(r"\b[qv]\b", code) else " + 0 * q"
    function: Callable[..., FloatArray] = _function(f"{code}{constant}", numbers, np)
    return function


def _function(text: str, numbers: tuple[str, ...], library: object) -> Any:
    return eval(f"lambda {', '.join(('q', 'v', *numbers))}: {text}", {"np": library})


class Scalar:
    """Functions of the law language for single numbers, in place of ``np``: equal values, ten times as fast.

    All other names come from NumPy.

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
        """Exponential; infinite where it overflows."""
        return math.exp(x) if x < 709.0 else math.inf

    def __getattr__(self, name: str) -> Any:
        return getattr(np, name)
