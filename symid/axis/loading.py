"""Finding and loading axis files: `models/` of the working folder, `models/` that ship with symid, or a path."""

from __future__ import annotations

import runpy
from pathlib import Path

from symid.axis.axis import Axis
from symid.errors import SymidError
from symid.text import similar

PACKAGE = Path(__file__).resolve().parents[1]


def shipped_folder(name: str) -> Path:
    """Folder that ships with symid: inside an installed package, at the top of a source tree."""
    installed = PACKAGE / "shipped" / name
    return installed if installed.is_dir() else PACKAGE.parent / name


def models_folders() -> tuple[Path, ...]:
    """Folders searched for an axis given by name, the working folder's own first."""
    own, shipped = Path("models").resolve(), shipped_folder("models")
    return (shipped,) if own == shipped or not own.is_dir() else (own, shipped)


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
        raise SymidError(f"axis file {path.name} declares the axis {axis.name!r}: name both alike")
    return axis
