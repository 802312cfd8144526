"""The formula of a law as NumPy code, from its text alone: no computer algebra is loaded for it."""

from __future__ import annotations

import ast

from symid.axis.laws.law import FUNCTIONS
from symid.errors import SymidError

_ZERO = ast.Constant(0.0)


def law_code(formula: str) -> str:
    """NumPy code of a formula in the language of laws.

    Examples
    --------
    >>> law_code("sign(v)*exp(-(v/velocity)**2)"), law_code("v*positive(v)")
    ('np.sign(v) * np.exp(-(v / velocity) ** 2)', 'v * np.heaviside(v, 0.0)')
    """
    return ast.unparse(_InNumPy().visit(_parsed(formula)))


def level_code(formula: str) -> str | None:
    """NumPy code of the level of dry friction, which stands beside sign(v) in its formula; None of any other law.

    Examples
    --------
    >>> level_code("sign(v)*q**2"), level_code("-sign(v)"), level_code("v*abs(v)")
    ('q ** 2', '-1.0', None)
    """
    taken = _WithoutSign()
    level = taken.visit(_parsed(formula))
    if taken.signs != 1 or _calls(level, "sign"):
        return None
    return ast.unparse(_InNumPy().visit(level))


def has_jumps(formula: str) -> bool:
    """Whether a formula jumps where the velocity changes its sign.

    >>> has_jumps("v*positive(v)"), has_jumps("v*abs(v)")
    (True, False)
    """
    return _calls(_parsed(formula), "sign", "positive")


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
            f"law expression {formula!r} cannot be read: use q, v, numbers and {', '.join(FUNCTIONS)}"
        ) from error


def _calls(node: ast.AST, *names: str) -> bool:
    """Whether a function is called anywhere in an expression."""
    calls = (one.func for one in ast.walk(node) if isinstance(one, ast.Call))
    return any(isinstance(function, ast.Name) and function.id in names for function in calls)


class _InNumPy(ast.NodeTransformer):
    """Functions of the language as those of NumPy."""

    def visit_Call(self, node: ast.Call) -> ast.Call:  # noqa: N802  the name that the parent asks for
        arguments = [self.visit(argument) for argument in node.args]
        name = getattr(node.func, "id", "")
        if name == "positive":
            name, arguments = "heaviside", [*arguments, _ZERO]
        return ast.Call(ast.Attribute(ast.Name("np"), name), arguments, [])


class _WithoutSign(ast.NodeTransformer):
    """A product without its factor sign(v), which is not looked for in sums and functions."""

    def __init__(self) -> None:
        self.signs = 0

    def visit(self, node: ast.AST) -> ast.AST:
        """The same with 1 in place of the factor."""
        match node:
            case ast.Call(func=ast.Name(id="sign"), args=[ast.Name(id="v")]):
                self.signs += 1
                return ast.Constant(1.0)
            case ast.BinOp(left=left, op=ast.Mult(), right=right):
                return self._product(self.visit(left), self.visit(right))
            case ast.BinOp(left=left, op=ast.Div(), right=right):
                return ast.BinOp(self.visit(left), ast.Div(), right)
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return ast.UnaryOp(ast.USub(), self.visit(operand))
        return node

    @staticmethod
    def _product(left: ast.expr, right: ast.expr) -> ast.expr:
        """A product, of which a factor 1 is left out."""
        factors = [one for one in (left, right) if getattr(one, "value", None) != 1.0]
        return ast.BinOp(left, ast.Mult(), right) if len(factors) == 2 else (*factors, left)[0]
