"""Axes by name, by file, or as given: each axis file defines `axis`."""

import os
import runpy
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Concatenate, ParamSpec, Protocol, TypeAlias, TypeVar

from symid.axis.axis import Axis
from symid.errors import SettingError, SymidError
from symid.text import similar

_PACKAGE = Path(__file__).resolve().parents[1]


def installed_folder(name: str) -> Path:
    """Folder inside the installed package that ships with symid; a source tree does not have it."""
    return _PACKAGE / "shipped" / name


def shipped_folder(name: str) -> Path:
    """Folder that ships with symid: inside an installed package, at the top of a source tree."""
    installed = installed_folder(name)
    return installed if installed.is_dir() else _PACKAGE.parent / name


def models_folders() -> tuple[Path, ...]:
    """Folders searched for an axis given by name, the working folder's own first."""
    working, shipped = Path("models").resolve(), shipped_folder("models")
    return (shipped,) if working == shipped or not working.is_dir() else (working, shipped)


def axis_names() -> tuple[str, ...]:
    """Names of all axes that can be loaded by name.

    >>> "emps" in axis_names()
    True
    """
    return tuple(sorted({path.stem for folder in models_folders() for path in folder.glob("*.py")}))


def axis_file(name_or_path: str) -> Path:
    """File that declares an axis, given its name or its path.

    Raises
    ------
    SymidError
        If there is none; names those that exist.

    Examples
    --------
    >>> axis_file("emps").name
    'emps.py'
    """
    if name_or_path.endswith(".py") and "\0" not in name_or_path:
        path = Path(name_or_path).resolve()
        if path.is_file():
            return path
        raise SymidError(
            f"there is no axis file {name_or_path!r}: give the path of a file that defines axis = Axis(...)"
        )
    named = Path(name_or_path).name == name_or_path and "\0" not in name_or_path
    for folder in models_folders() if named else ():
        if (path := folder / f"{name_or_path}.py").is_file():
            return path
    raise SymidError(
        f"there is no axis {name_or_path!r}{similar(name_or_path, axis_names())}: choose from "
        f"{', '.join(axis_names())}, or give a path to a .py file"
    )


def load_axis(name_or_path: str) -> Axis:
    """Axis declared in a file of `models/` (by name) or in any file (by path).

    Raises
    ------
    SymidError
        If the file does not exist, cannot be run, or defines no `axis`.
    DeclarationError
        If the declaration is not sound.

    Examples
    --------
    >>> load_axis("rigid_1m").drive.signal
    'F'
    """
    path = axis_file(name_or_path)
    try:
        axis = runpy.run_path(str(path)).get("axis")
    except SymidError:
        raise
    except Exception as error:
        raise SymidError(f"axis file {path.name} cannot be run: {type(error).__name__}: {error}") from error
    if not isinstance(axis, Axis):
        raise SymidError(f"axis file {path.name} defines no axis: end it with axis = Axis(...)")
    if axis.name != path.stem:
        raise SymidError(f"axis file {path.name} declares the axis {axis.name!r}: give both the same name")
    return axis


class ModelOfAxis(Protocol):
    """A derived or generated model, which knows its axis or the name of it."""

    @property
    def axis(self) -> Axis | str:
        """The declaration, or its name."""
        ...


AnyAxis: TypeAlias = Axis | str | os.PathLike[str] | ModelOfAxis
"""A declaration, the name or path of its file, or a model of it."""
P = ParamSpec("P")
R = TypeVar("R")


def axis_of(given: AnyAxis) -> Axis:
    """The declaration of an axis given as such, by name or path, or by a model.

    Raises
    ------
    SettingError
        If it is anything else.

    Examples
    --------
    >>> axis_of("rigid_1m").drives[0].signal
    'F'
    """
    named = given if isinstance(given, (Axis, str, os.PathLike)) else getattr(given, "axis", None)
    if isinstance(named, Axis):
        return named
    if isinstance(named, (str, os.PathLike)):
        return load_axis(os.fspath(named))
    raise SettingError(
        f"{type(given).__name__} is not an axis: give an Axis, the name or path of its file, or a model of it"
    )


def of_any_axis(function: Callable[Concatenate[Axis, P], R]) -> Callable[Concatenate[AnyAxis, P], R]:
    """Let a function of a declared axis also take a name, a path or a model.

    >>> of_any_axis(lambda axis: axis.drives[0].signal)("rigid_1m")
    'F'
    """

    @wraps(function)
    def by_any(axis: AnyAxis, *args: P.args, **settings: P.kwargs) -> R:
        return function(axis_of(axis), *args, **settings)

    return by_any  # type: ignore[return-value]  # the first argument may still be named
