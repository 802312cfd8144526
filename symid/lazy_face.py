"""Faces of packages that import a name when it is used, so that a command loads only what it needs."""

import sys
from collections.abc import Callable
from functools import cache


def lazy_face(package: str) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """`__getattr__` and `__dir__` of a package whose stub file, `__init__.pyi`, imports each name from its module.

    Type checkers read the same file. No name may be that of a module of the package, which would hide it.
    """

    @cache
    def modules() -> dict[str, str]:
        import ast
        from importlib import import_module
        from pathlib import Path

        stub = Path(str(sys.modules[package].__file__)).with_suffix(".pyi").read_text(encoding="utf-8")
        imports = [node for node in ast.parse(stub).body if isinstance(node, ast.ImportFrom)]
        found: dict[str, str] = {}
        for module, name in ((str(node.module), alias.name) for node in imports for alias in node.names):
            found |= dict.fromkeys(import_module(module).__all__ if name == "*" else [name], module)
        return found

    def get(name: str) -> object:
        if name.startswith("__") and name != "__all__":  # asked by the import system and by inspect
            raise AttributeError(name)
        if name == "__all__":
            return list(modules())
        if name not in modules():
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        from importlib import import_module

        return getattr(import_module(modules()[name]), name)

    def names() -> list[str]:
        return sorted({*modules(), *(name for name in vars(sys.modules[package]) if name.startswith("__"))})

    return get, names
