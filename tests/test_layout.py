"""Files are short, no two modules and no two classes share a name, and packages keep to each other's faces."""

import ast
import re
from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from graphlib import CycleError, TopologicalSorter
from importlib import import_module
from pathlib import Path

import pytest

TESTS = Path(__file__).parent
PACKAGE = TESTS.parent / "symid"


def test_no_file_has_more_than_300_lines() -> None:
    files = [*PACKAGE.rglob("*.py"), *TESTS.rglob("*.py")]
    lengths = {str(file): len(file.read_text(encoding="utf-8").splitlines()) for file in files}
    assert len(lengths) > 500
    assert {name: count for name, count in lengths.items() if count > 300} == {}


def test_no_two_modules_have_the_same_name() -> None:
    names = Counter(file.stem for file in PACKAGE.rglob("*.py") if file.stem != "__init__")
    assert [name for name, count in names.items() if count > 1] == []


def test_no_two_classes_have_the_same_name() -> None:
    texts = (file.read_text(encoding="utf-8") for file in PACKAGE.rglob("*.py"))
    names = Counter(name for text in texts for name in re.findall(r"^ *class (\w+)[(:]", text, re.MULTILINE))
    assert len(names) > 300
    assert [name for name, count in names.items() if count > 1] == []


def imports_of(text: str) -> Iterator[tuple[str, str]]:
    """Module and name of each import, those within functions and for type checkers included."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom) and node.module and not node.level:
            yield from ((node.module, alias.name) for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (alias.name.rpartition(".")[::2] for alias in node.names)


def is_package(name: str) -> bool:
    return PACKAGE.parent.joinpath(*name.split(".")).is_dir()


def face_of(module: str) -> Collection[str]:
    """Names that a package states in its `__init__`; none for a module."""
    return getattr(import_module(module), "__all__", ()) if is_package(module) else ()


def past_faces(text: str, package: str) -> list[str]:
    """Imports in a module of a package of what another package does not state as its face."""
    found = []
    for module, name in imports_of(text):
        root, _, rest = module.partition(".")
        other = rest.partition(".")[0]
        reached = f"{module}.{name}"
        if root == "symid" and other not in ("", package) and is_package(f"symid.{other}"):
            found += [] if name in face_of(module) or is_package(reached) else [reached]
    return found


def test_no_package_reaches_past_the_face_of_another() -> None:
    files = sorted(PACKAGE.rglob("*.py"))
    texts = {file.relative_to(PACKAGE): file.read_text(encoding="utf-8") for file in files}
    found = {str(file): past_faces(text, file.parts[0]) for file, text in texts.items()}
    assert {file: names for file, names in found.items() if names} == {}


def test_an_import_past_a_face_is_found() -> None:
    modules = "from symid.data.log import Log", "from symid.data import log", "import symid.data.log"
    assert [past_faces(text, "tuning") for text in modules] == [
        ["symid.data.log.Log"],
        *[["symid.data.log"]] * 2,
    ]
    within = "def f():\n    from symid.identification.rows.settings import Preparation"
    assert past_faces(within, "tuning") == ["symid.identification.rows.settings.Preparation"]
    faces = (
        "from symid.data import Log\nfrom symid.identification.rows import noise_of_rows\nimport symid.errors"
    )
    assert past_faces(faces, "tuning") == past_faces(modules[0], "data") == []


def require_no_circle(texts: Mapping[str, str]) -> None:
    """CycleError if modules, given by name, import each other, be it within functions or for type checkers."""
    imports = {own: {(f"{of}.{name}", of) for of, name in imports_of(text)} for own, text in texts.items()}
    graph = {
        own: {next((m for m in pair if m in texts), "") for pair in pairs} for own, pairs in imports.items()
    }
    TopologicalSorter(graph).prepare()


def test_no_modules_import_each_other() -> None:
    files = {file: file.relative_to(PACKAGE.parent).with_suffix("") for file in PACKAGE.rglob("*.py")}
    names = {
        file: ".".join(part for part in path.parts if part != "__init__") for file, path in files.items()
    }
    require_no_circle({name: file.read_text(encoding="utf-8") for file, name in names.items()})


def test_a_circle_is_found() -> None:
    late = "def f():\n    from symid.a import g"
    with pytest.raises(CycleError):
        require_no_circle({"symid.a": "from symid.b import f", "symid.b": late})
    require_no_circle({"symid.a": "from symid.b import f", "symid.b": "from symid.c import g"})
