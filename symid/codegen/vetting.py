"""Checks of a generated module before it is run: the hash of its text, and that it contains array arithmetic only.

The hash detects edited or damaged modules. It is not a secret: whoever edits a module on purpose can write a new hash.
Even then only arithmetic runs, because every statement is checked before any is executed.
"""

import ast
import builtins
import hashlib
import re
from collections.abc import Set
from typing import Final

import numpy as np

from symid.errors import GeneratedModuleError

_MARK: Final = "# SHA-256 of all above: "
_END: Final = re.compile(rf"{re.escape(_MARK)}([0-9a-f]{{64}})\n?\Z")
_FUNCTIONS: Final = frozenset({"max", "map", "min", "abs"})
_ARRAYS: Final = frozenset({"size", "empty", "zeros", "array", "select", "where", "amax", "amin", "clip"})
_CONSTANTS: Final = frozenset({"nan", "inf", "pi", "e", "True_", "False_"})
_LARGEST_POWER: Final = 64
_EXPRESSIONS: Final = (
    ast.Name,
    ast.Constant,
    ast.BinOp,
    ast.UnaryOp,
    ast.Compare,
    ast.BoolOp,
    ast.IfExp,
    ast.Subscript,
    ast.Slice,
    ast.Tuple,
    ast.List,
    ast.Dict,
    ast.Call,
    ast.keyword,
    ast.Attribute,
    ast.operator,
    ast.unaryop,
    ast.cmpop,
    ast.boolop,
    ast.expr_context,
)
_PLAIN: Final = frozenset({ast.Load, ast.Store, ast.Add, ast.Sub, ast.Mult, ast.Div, ast.USub})


def signed(text: str) -> str:
    r"""Text of a module with a last line that holds its hash.

    >>> len(vetted(signed("a = 1\n")).body)
    1
    """
    return f"{text.rstrip()}\n\n{_MARK}{_hash(text.rstrip())}\n"


def vetted(text: str) -> ast.Module:
    """Syntax tree of a module; GeneratedModuleError unless it is unchanged and contains only arithmetic."""
    end = _END.search(text)
    if end is None or _hash(text[: end.start()].rstrip()) != end[1]:
        raise GeneratedModuleError("was changed after it was generated")
    tree = ast.parse(text)
    for statement in tree.body:
        if fault := _fault(statement):
            raise GeneratedModuleError(f"contains code that symid does not generate (line {fault})")
    return tree


def _hash(text: str) -> str:
    return hashlib.sha256(text.encode("utf-8", errors="surrogateescape")).hexdigest()


def _fault(statement: ast.stmt) -> int | None:
    """Line of the first part of a top-level statement that symid does not generate."""
    match statement:
        case ast.Import(names=[ast.alias(name="numpy", asname="np")]):
            return None
        case ast.FunctionDef(decorator_list=[], returns=None):
            arguments = statement.args
            own = {one.arg for one in arguments.args}
            own |= {
                n.id for n in ast.walk(statement) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)
            }
            lines = (_fault_within(part, own) for part in (*statement.body, *arguments.defaults))
            odd = (*arguments.kwonlyargs, *arguments.posonlyargs, arguments.vararg, arguments.kwarg)
            if any(odd) or "np" in own:
                return statement.lineno
            return next((line for line in lines if line is not None), None)
        case _:
            return _fault_within(statement)


def _fault_within(statement: ast.AST, own: Set[str] = frozenset()) -> int | None:
    """Line of the first node in a statement that is not arithmetic; `own` are the names of its function."""
    if not isinstance(statement, (ast.Assign, ast.Return, ast.Expr, ast.Constant)):
        return int(getattr(statement, "lineno", 0))
    for node in ast.walk(statement):
        if type(node) in _PLAIN:  # most nodes
            continue
        foreign = (
            isinstance(node, ast.Name) and hasattr(builtins, node.id) and node.id not in own | _FUNCTIONS
        )
        known = node is statement or (isinstance(node, _EXPRESSIONS) and _is_arithmetic(node))
        if foreign or not known:
            return int(getattr(node, "lineno", getattr(statement, "lineno", 0)))
    return None


def _is_arithmetic(node: ast.AST) -> bool:
    match node:
        case ast.Call(func=ast.Name(id=name)):
            return name in _FUNCTIONS
        case ast.Call(func=ast.Attribute()):
            return True  # the attribute node is checked separately
        case ast.Call():
            return False
        case ast.Attribute(value=ast.Name(id="np"), attr=name):
            known = name in _ARRAYS or name in _CONSTANTS
            return known or isinstance(getattr(np, name, None), np.ufunc)
        case ast.Attribute(attr=name, ctx=ast.Load()):
            return name == "transpose"
        case ast.Attribute():
            return False
        case ast.Name(id=name, ctx=ast.Store()):
            return name != "np"
        case ast.Name(id=name):
            return not name.startswith("__")
        case ast.BinOp(left=left, op=ast.Pow(), right=right):
            return not (isinstance(left, ast.BinOp) and isinstance(left.op, ast.Pow)) and _is_small(right)
        case ast.Constant(value=value):
            return isinstance(value, (str, int, float, bool)) or value is None
        case _:
            return True


def _is_small(node: ast.expr) -> bool:
    """Whether an exponent is a small number or a name: towers of powers would run forever."""
    match node:
        case ast.UnaryOp(operand=operand):
            return _is_small(operand)
        case ast.BinOp(left=ast.Constant() as left, op=ast.Div(), right=ast.Constant() as right):
            return _is_small(left) and _is_small(right)
        case ast.Constant(value=value):
            return isinstance(value, (int, float)) and abs(value) <= _LARGEST_POWER
        case _:
            return isinstance(node, ast.Name)
