"""Libraries of the extra ``symid[files]``, loaded where a file needs one."""

from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from symid.errors import LogError


def required(library: str, path: Path) -> Any:
    """A library that reads a kind of file; LogError, which names the extra that holds it, if it is not installed."""
    try:
        return import_module(library)
    except ImportError as error:
        raise _missing(library, path) from error


def require_installed(library: str, path: Path) -> None:
    """Raise LogError if a library that reads a kind of file is not installed; it is not loaded."""
    try:
        found = find_spec(library)
    except ValueError:  # a module without a specification, as tests set it
        found = None
    if found is None:
        raise _missing(library, path)


def _missing(library: str, path: Path) -> LogError:
    return LogError(
        f"{path}: {path.suffix} files are read by {library}, which is not installed: pip install 'symid[files]'"
    )
