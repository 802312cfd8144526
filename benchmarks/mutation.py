"""Mutation score: how many small faults in a package its own tests notice.

A mutant is the package with one fault: a comparison, sign, operator, constant or condition that is another. It is
killed if the tests of its folder and the examples of its docstrings fail, or take `--patience` times as long as
without a fault. Mutants are drawn with a seed from all places; those that survive are printed with their line. Some of
them are equal to the original, or change only a speed or a message.

Usage: python -m benchmarks.mutation estimation [--mutants 60] [--seed 1]
"""

import ast
import copy
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from benchmarks.options import parser_of

LINKED = ("models", "generated", "data", "docs", "examples", "benchmarks", "README.md", "CHANGELOG.md")
COMPARISONS: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
}
OPERATORS: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Pow: ast.Mult,
    ast.MatMult: ast.Add,
}
NAMES = {"min": "max", "max": "min", "any": "all", "all": "any", "minimum": "maximum", "maximum": "minimum"}


@dataclass(frozen=True)
class Mutant:
    """A module with one fault."""

    file: Path
    line: int
    change: str
    source: str


@dataclass(frozen=True)
class Fault:
    """Another node in the place of one."""

    parent: ast.AST
    field: str
    index: int | None
    node: ast.AST
    other: ast.AST


def faulty(node: ast.AST) -> ast.AST | None:
    """A copy of a node with a fault; None where there is none to make."""
    other = copy.deepcopy(node)
    if isinstance(other, ast.Compare) and type(other.ops[0]) in COMPARISONS:
        other.ops[0] = COMPARISONS[type(other.ops[0])]()
    elif isinstance(other, (ast.BinOp, ast.AugAssign)) and type(other.op) in OPERATORS:
        other.op = OPERATORS[type(other.op)]()
    elif isinstance(other, ast.BoolOp):
        other.op = ast.Or() if isinstance(other.op, ast.And) else ast.And()
    elif isinstance(other, ast.UnaryOp) and isinstance(other.op, (ast.Not, ast.USub)):
        return other.operand
    elif isinstance(other, ast.Constant) and type(other.value) in (int, float):
        other.value = other.value + 1 if isinstance(other.value, int) else 2.0 * other.value + 1e-3
    elif isinstance(other, ast.IfExp):
        other.body, other.orelse = other.orelse, other.body
    elif isinstance(other, ast.Name) and other.id in NAMES:
        other.id = NAMES[other.id]
    elif isinstance(other, ast.Attribute) and other.attr in NAMES:
        other.attr = NAMES[other.attr]
    else:
        return None
    return other


def places(tree: ast.AST) -> Iterator[tuple[ast.AST, str, int | None]]:
    """Children that may be replaced: the parent, its field, and the index within that; no types and messages."""
    for parent in ast.walk(tree):
        if isinstance(parent, (ast.Raise, ast.JoinedStr, ast.AnnAssign, ast.arguments)):
            for child in ast.walk(parent):
                child.__dict__["left_out"] = True
        for field, value in ast.iter_fields(parent):
            for index, child in enumerate(value) if isinstance(value, list) else ((None, value),):
                if isinstance(child, ast.AST) and "left_out" not in child.__dict__:
                    yield parent, field, index


def faults(tree: ast.AST) -> list[Fault]:
    """All faults that a module may have."""
    found = []
    for parent, field, index in list(places(tree)):
        value = getattr(parent, field)
        node = value if index is None else value[index]
        other = faulty(node)
        if other is not None:
            found.append(Fault(parent, field, index, node, ast.fix_missing_locations(other)))
    return found


def drawn(package: Path, number: int, seed: int) -> tuple[list[Mutant], int]:
    """Mutants of a package, each place as likely as any other, and the number of all."""
    trees = [(file, ast.parse(file.read_text())) for file in sorted(package.rglob("*.py"))]
    every = [(file, tree, fault) for file, tree in trees for fault in faults(tree)]
    found = []
    for file, tree, fault in random.Random(seed).sample(every, min(number, len(every))):
        change = f"{ast.unparse(fault.node)} -> {ast.unparse(fault.other)}"
        put(fault.parent, fault.field, fault.index, fault.other)
        found.append(Mutant(file, getattr(fault.node, "lineno", 0), change, ast.unparse(tree)))
        put(fault.parent, fault.field, fault.index, fault.node)
    return found, len(every)


def put(parent: ast.AST, field: str, index: int | None, node: ast.AST) -> None:
    if index is None:
        setattr(parent, field, node)
    else:
        getattr(parent, field)[index] = node


def tested(root: Path, package: str, module: str, limit: float) -> bool:
    """Whether the tests of a package pass in a copy of the repository, those named after a module first."""
    first = [str(file) for file in sorted((root / "tests" / package).rglob(f"test_{module}*.py"))]
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", *first]
    command += [f"symid/{package}", f"tests/{package}"]
    environment = {**os.environ, "PYTHONPATH": str(root), "OPENBLAS_NUM_THREADS": "1"}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    try:
        done = subprocess.run(
            command, check=False, cwd=root, env=environment, capture_output=True, timeout=limit
        )
    except subprocess.TimeoutExpired:
        return False
    return done.returncode == 0


def copied(root: Path) -> None:
    """Copy what the tests need of this repository."""
    for name in ("symid", "tests"):
        shutil.copytree(name, root / name, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy("pyproject.toml", root)
    for name in LINKED:
        (root / name).symlink_to(Path(name).resolve())


def main() -> None:
    parser = parser_of(__doc__, mutants=60, seed=1, patience=5.0)
    parser.add_argument("package", help="a folder of symid/ that has tests in tests/")
    options = parser.parse_args()
    chosen, places_in_all = drawn(Path("symid") / options.package, options.mutants, options.seed)
    with tempfile.TemporaryDirectory() as name:
        root = Path(name)
        copied(root)
        begin = time.perf_counter()
        if not tested(root, options.package, "none", 3600.0):
            raise SystemExit("the tests fail without any fault: mend them first")
        limit = options.patience * (time.perf_counter() - begin)
        survivors = 0
        for number, mutant in enumerate(chosen, 1):
            file = root / mutant.file
            whole = file.read_text()
            file.write_text(mutant.source)
            if tested(root, options.package, mutant.file.stem, limit):
                survivors += 1
                print(f"  survives: {mutant.file}:{mutant.line}: {mutant.change}", flush=True)
            file.write_text(whole)
            print(f"{number} tested, {number - survivors} killed", file=sys.stderr, flush=True)
    killed, share = len(chosen) - survivors, 1 - survivors / len(chosen)
    print(
        f"{options.package}: {killed} of {len(chosen)} killed ({100 * share:.0f} %), drawn from {places_in_all}"
    )


if __name__ == "__main__":
    main()
