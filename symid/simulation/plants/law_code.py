"""The formula of a law as NumPy code and as a function, from its text alone, without computer algebra."""

import ast
import re
from collections.abc import Callable
from typing import Any

import numpy as np

from symid.axis import LAW_FUNCTIONS
from symid.errors import SymidError

_ZERO, _ONE = ast.Constant(0.0), ast.Constant(1.0)


def law_code(formula: str) -> str:
    """NumPy code of a formula in the language of laws.

    >>> law_code("sign(v)*exp(-(v/velocity)**2)"), law_code("v*positive(v)"), law_code("min(F, 2)")
    ('np.sign(v) * np.exp(-(v / velocity) ** 2)', 'v * np.heaviside(v, 0.0)', 'np.minimum(F, 2)')
    """
    return ast.unparse(_InNumPy().visit(_parsed(formula)))


def array_function(code: str, numbers: tuple[str, ...] = ()) -> Callable[..., Any]:
    """Function of q, v and further `numbers`, each a number or an array, for the NumPy code of a law.

    >>> array_function("v*q")(np.array([2.0, 1.0]), np.array([3.0, 4.0])).tolist()
    [6.0, 4.0]
    >>> array_function("v/speed", ("speed",))(0.0, 1.0, 0.5)
    2.0
    """
    constant = "" if re.search(r"\b[qv]\b", code) else " + 0 * q"
    function: Callable[..., Any] = eval(
        f"lambda {', '.join(('q', 'v', *numbers))}: {code}{constant}", {"np": np}
    )
    return function


def level_code(formula: str) -> str | None:
    """NumPy code of the level of dry friction, the factor of sign(v) in its formula; None for any other law.

    >>> level_code("sign(v)*q**2"), level_code("-sign(v)"), level_code("v*abs(v)")
    ('q ** 2', '-1.0', None)
    """
    return dry_level(law_code(formula))


def dry_level(code: str) -> str | None:
    """As `level_code`, for a law that is NumPy code already.

    >>> dry_level("np.sign(v) * np.exp(-(v / 0.01) ** 2)"), dry_level("np.sign(v)"), dry_level("v * np.abs(v)")
    ('np.exp(-(v / 0.01) ** 2)', '1.0', None)
    """
    whole = _parsed(code)
    level = _without_sign(whole)
    return None if _signs(whole) != 1 or _signs(level) else ast.unparse(level)


def not_below_zero(level: str) -> str:
    """NumPy code of a level of friction that does not fall below 0 along the stroke.

    >>> not_below_zero("a * (q ** 3)"), not_below_zero("a * (v ** 2)")
    ('np.maximum(a * (q ** 3), 0.0)', 'a * (v ** 2)')
    """
    return f"np.maximum({level}, 0.0)" if re.search(r"\bq\b", level) else level


def has_jumps(formula: str) -> bool:
    """Whether a formula jumps where the velocity changes its sign.

    >>> has_jumps("v*positive(v)"), has_jumps("v*abs(v)")
    (True, False)
    """
    return _calls(_parsed(formula), "sign", "positive") > 0


def moves(formula: str) -> bool:
    """Whether a formula depends on the motion.

    >>> moves("1"), moves("exp(-q)")
    (False, True)
    """
    return any(isinstance(one, ast.Name) and one.id in ("q", "v") for one in ast.walk(_parsed(formula)))


def _parsed(formula: str) -> ast.expr:
    try:
        return ast.parse(formula, mode="eval").body
    except SyntaxError as error:
        raise SymidError(
            f"law expression {formula!r} cannot be read: use q, v, numbers and {', '.join(LAW_FUNCTIONS)}"
        ) from error


def _signs(code: ast.AST) -> int:
    """Number of calls of the sign function in NumPy code."""
    return sum(isinstance(one, ast.Attribute) and one.attr == "sign" for one in ast.walk(code))


def _calls(node: ast.AST, *names: str) -> int:
    """Number of calls of the named functions in an expression."""
    calls = (one.func for one in ast.walk(node) if isinstance(one, ast.Call))
    return sum(isinstance(function, ast.Name) and function.id in names for function in calls)


class _InNumPy(ast.NodeTransformer):
    """Replaces functions of the law language by NumPy functions."""

    def visit_Call(self, node: ast.Call) -> ast.Call:
        arguments = [self.visit(argument) for argument in node.args]
        name = getattr(node.func, "id", "")
        if name == "positive":
            arguments.append(_ZERO)
        name = {"positive": "heaviside", "min": "minimum", "max": "maximum"}.get(name, name)
        return ast.Call(ast.Attribute(ast.Name("np"), name), arguments, [])


def _without_sign(node: ast.expr) -> ast.expr:
    """A product without its factors sign(v); sums and arguments of functions are not searched."""
    match node:
        case ast.Call(func=ast.Attribute(attr="sign"), args=[ast.Name(id="v")]):
            return _ONE
        case ast.BinOp(left=left, op=ast.Mult(), right=right):
            left, right = _without_sign(left), _without_sign(right)
            return right if left is _ONE else left if right is _ONE else ast.BinOp(left, ast.Mult(), right)
        case ast.BinOp(left=left, op=ast.Div(), right=right):
            return ast.BinOp(_without_sign(left), ast.Div(), right)
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return ast.UnaryOp(ast.USub(), _without_sign(operand))
    return node
