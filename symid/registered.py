"""Objects that the modules of a package register under a name: a new module needs no line elsewhere."""

from collections.abc import Iterator
from importlib import import_module
from pkgutil import iter_modules
from typing import Any


def registered(package: str, name: str) -> Iterator[Any]:
    """Objects of one name in the modules of a package, in the order of the modules.

    >>> [target.name for target in registered("symid.export", "TARGET")]
    ['mjcf', 'st', 'urdf']
    """
    for found in iter_modules(import_module(package).__path__):
        module = import_module(f"{package}.{found.name}")
        if hasattr(module, name):
            yield getattr(module, name)
