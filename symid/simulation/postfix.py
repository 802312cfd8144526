"""Law expressions as programs in postfix notation, which one compiled function evaluates for numbers.

A law is known when symid runs, so that its own code would have to be compiled for every formula and every process. A
program is data: the loop that integrates a motion is compiled once for all laws, see `evaluation`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import sympy as sp

from symid.arrays import FloatArray
from symid.errors import SymidError
from symid.symbolic.expressions import positive

_FUNCTIONS = (sp.Abs, sp.sign, positive, sp.sin, sp.cos, sp.exp)
CONSTANT, ARGUMENT, ADD, MULTIPLY, POWER, MAXIMUM, FUNCTION = range(7)
"""Operations; from `FUNCTION` on they are those of `_FUNCTIONS`, in that order."""
_BINARY = {sp.Add: ADD, sp.Mul: MULTIPLY, sp.Pow: POWER, sp.Max: MAXIMUM}


@dataclass(frozen=True, eq=False)
class Program:
    """An expression in postfix notation, for a stack of height `depth`.

    An operand is the number that a constant puts on the stack, or the index of an argument.
    """

    operations: np.ndarray[tuple[int], np.dtype[np.int64]]
    operands: FloatArray
    depth: int


def program(expression: sp.Expr, arguments: tuple[str, ...]) -> Program:
    """The program of an expression of the law language in symbols named as the arguments; SymidError for any other.

    >>> from symid.simulation.evaluation import evaluate
    >>> short = program(sp.sympify("v*abs(q)/2"), ("q", "v"))
    >>> evaluate(short.operations, short.operands, np.array([-3.0, 4.0]), np.zeros(short.depth))
    6.0
    """
    steps: list[tuple[int, float]] = []
    depth = _append(sp.sympify(expression), arguments, steps)
    operations, operands = zip(*steps, strict=True)
    return Program(np.array(operations, dtype=np.int64), np.array(operands, dtype=np.float64), depth)


def _append(expression: sp.Expr, arguments: tuple[str, ...], steps: list[tuple[int, float]]) -> int:
    """Write the steps of an expression behind others; the height of the stack that it needs."""
    if expression.is_Symbol and str(expression) in arguments:
        steps.append((ARGUMENT, float(arguments.index(str(expression)))))
        return 1
    if not expression.free_symbols and expression.is_number:
        steps.append((CONSTANT, float(expression)))
        return 1
    if expression.func in _FUNCTIONS:
        height = _append(expression.args[0], arguments, steps)
        steps.append((FUNCTION + _FUNCTIONS.index(expression.func), 0.0))
        return height
    if expression.func not in _BINARY:
        raise SymidError(f"{expression} is not of the law language: use q, v, numbers and its functions")
    height = _append(expression.args[0], arguments, steps)
    for other in expression.args[1:]:
        height = max(height, 1 + _append(other, arguments, steps))
        steps.append((_BINARY[expression.func], 0.0))
    return height
