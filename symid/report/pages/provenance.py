"""How a page was made: time, command, programs and files."""

from __future__ import annotations

import contextlib
import hashlib
import platform
from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import scipy

from symid import __version__


def provenance(sources: Iterable[str], command: str = "") -> list[tuple[str, str]]:
    """Name and value of each line: when, by which command and programs, and the SHA-256 of each log.

    Parameters
    ----------
    sources : iterable of str
        Sources of logs: a path, or several with commas or, of one log, plus signs between, or a name of no file,
        which has no hash.
    command : str
        The command line, if there was one.
    """
    files = [
        file for source in sources for file in ([source] if Path(source).is_file() else source.split(", "))
    ]
    files = [part for file in files for part in ([file] if Path(file).is_file() else file.split("+"))]
    hashes = []
    for name in dict.fromkeys(files):
        with contextlib.suppress(OSError, ValueError), open(name, "rb") as file:
            hashes.append((f"SHA-256 of {name}", hashlib.file_digest(file, "sha256").hexdigest()))
    libraries = f"NumPy {np.__version__}, SciPy {scipy.__version__}"
    programs = f"symid {__version__}, Python {platform.python_version()}, {libraries}"
    when = datetime.now(UTC).strftime("%Y-%m-%d %H:%M:%S UTC")
    return [("written", when), *([("command", command)] if command else []), ("programs", programs), *hashes]
