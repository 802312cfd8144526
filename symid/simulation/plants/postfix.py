"""Law expressions as programs in postfix notation, which one compiled function evaluates for numbers.

Laws are known only at run time: code of a law would have to be compiled for each formula in each process. A program is
data, so one compiled loop serves all laws; see `evaluation`.
"""

import ast
import math
import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from symid.arrays import FloatArray
from symid.errors import SymidError

_FUNCTIONS = ("abs", "sign", "heaviside", "sin", "cos", "exp")
CONSTANT, ARGUMENT, ADD, MULTIPLY, POWER, MINIMUM, MAXIMUM, FUNCTION = range(8)
"""Operations; `FUNCTION` + i is function i of `_FUNCTIONS`."""
_ARITHMETIC: Final[Mapping[type[ast.operator], tuple[int, Callable[[float, float], Any]]]] = {
    ast.Add: (ADD, operator.add),
    ast.Sub: (ADD, operator.sub),
    ast.Mult: (MULTIPLY, operator.mul),
    ast.Div: (MULTIPLY, operator.truediv),
    ast.Pow: (POWER, operator.pow),
}
"""Operation of a program for an operator of an expression, and the function of two numbers."""
_Steps = list[tuple[int, float]]


@dataclass(frozen=True, eq=False)
class Program:
    """An expression in postfix notation, for a stack of height `depth`.

    An operand is the number that a constant pushes on the stack, or the index of an argument.
    """

    operations: np.ndarray[tuple[int], np.dtype[np.int64]]
    operands: FloatArray
    depth: int

    def asks_for(self, argument: int) -> bool:
        """Whether the value depends on an argument."""
        return bool(np.any((self.operations == ARGUMENT) & (self.operands == argument)))


def program(code: str, arguments: tuple[str, ...]) -> Program:
    """Program of a law, given as NumPy code of the arguments; SymidError for any other code.

    >>> from symid.simulation.compiled_loop.evaluation import evaluate
    >>> short = program("v*np.abs(q)/2", ("q", "v"))
    >>> evaluate(short.operations, short.operands, np.array([-3.0, 4.0]), np.zeros(short.depth))
    6.0
    """
    steps: _Steps = []
    depth = _append(ast.parse(code, mode="eval").body, arguments, steps)
    operations, operands = zip(*steps, strict=True)
    return Program(np.array(operations, dtype=np.int64), np.array(operands, dtype=np.float64), depth)


def _append(node: ast.expr, arguments: tuple[str, ...], steps: _Steps) -> int:
    """Append the steps of an expression; return the height of the stack that it needs."""
    if (number := _number(node)) is not None:
        steps.append((CONSTANT, number))
        return 1
    match node:
        case ast.Name(id=name) if name in arguments:
            steps.append((ARGUMENT, float(arguments.index(name))))
            return 1
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return _joined(MULTIPLY, ast.Constant(-1.0), operand, arguments, steps)
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _ARITHMETIC:
            if isinstance(op, ast.Sub):
                right = ast.UnaryOp(ast.USub(), right)
            elif isinstance(op, ast.Div):
                right = ast.BinOp(right, ast.Pow(), ast.Constant(-1.0))
            return _joined(_ARITHMETIC[type(op)][0], left, right, arguments, steps)
    match (_function_name(node), *getattr(node, "args", ())):
        case "minimum" | "maximum" as name, ast.expr() as left, ast.expr() as right:
            return _joined(MINIMUM if name == "minimum" else MAXIMUM, left, right, arguments, steps)
        case "sqrt", ast.expr() as operand:
            return _joined(POWER, operand, ast.Constant(0.5), arguments, steps)
        case str() as name, ast.expr() as operand, *at_zero if name in _FUNCTIONS and list(
            map(_number, at_zero)
        ) == [0.0] * (name == "heaviside"):
            height = _append(operand, arguments, steps)
            steps.append((FUNCTION + _FUNCTIONS.index(name), 0.0))
            return height
    raise SymidError(f"{ast.unparse(node)} is not of the law language: use q, v, numbers and its functions")


def _joined(
    operation: int, left: ast.expr, right: ast.expr, arguments: tuple[str, ...], steps: _Steps
) -> int:
    """Append the steps of two operands and of their operation; return the height of the stack."""
    height = max(_append(left, arguments, steps), 1 + _append(right, arguments, steps))
    steps.append((operation, 0.0))
    return height


def _function_name(node: ast.expr) -> str:
    """Name of the NumPy or built-in function that is called; empty for any other expression."""
    match node:
        case ast.Call(
            func=ast.Attribute(value=ast.Name(id="np"), attr=name) | ast.Name(id=name), keywords=[]
        ):
            return name
        case _:
            return ""


def _number(node: ast.expr) -> float | None:
    """Value of a constant expression; None for any other."""
    match node:
        case ast.Constant(value=int() | float() as value):
            return float(value)
        case ast.Attribute(value=ast.Name(id="np"), attr="pi"):
            return math.pi
        case ast.UnaryOp(op=ast.USub(), operand=operand) if (inner := _number(operand)) is not None:
            return -inner
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _ARITHMETIC:
            a, b = _number(left), _number(right)
            return None if a is None or b is None else float(_ARITHMETIC[type(op)][1](a, b))
    return None
