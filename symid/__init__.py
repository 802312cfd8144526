"""symid: declare a machine axis, derive its regressors, identify it, and learn why simulation and machine differ."""

from functools import cache

__version__ = "0.1.0"


def __getattr__(name: str) -> object:
    """Import a name when it is used: declaring an axis needs neither sympy nor scipy, and a command starts at once."""
    if name.startswith("__") and name != "__all__":  # asked by the import system and by inspect
        raise AttributeError(name)
    modules = _modules()
    if name == "__all__":
        return list(modules)
    if name not in modules:
        raise AttributeError(f"module 'symid' has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(modules[name]), name)


def __dir__() -> list[str]:
    return sorted({*_modules(), *(name for name in globals() if name.startswith("__"))})


@cache
def _modules() -> dict[str, str]:
    """Module of each name, as the stub file beside this one imports it, for type checkers too."""
    import ast
    from importlib import import_module
    from pathlib import Path

    stub = ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    imports = [node for node in stub.body if isinstance(node, ast.ImportFrom)]
    modules = {}
    for module, name in ((node.module, alias.name) for node in imports for alias in node.names):
        modules |= dict.fromkeys(import_module(module).__all__ if name == "*" else [name], module)
    return modules
