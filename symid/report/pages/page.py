"""Pages of reports: their files, their templates, and how they were made."""

import contextlib
import gzip
import hashlib
import platform
from base64 import b64encode
from collections.abc import Iterable
from datetime import UTC, datetime
from inspect import isfunction
from pathlib import Path
from typing import TypeVar

import jinja2
import numpy as np
import scipy

from symid import __version__
from symid.errors import SettingError
from symid.files import written_path
from symid.report.figures import colours
from symid.report.tables import number_text
from symid.report.tables.diagnosis import removes
from symid.report.tables.fleet import spread_size
from symid.report.tables.motion_gap import fit, motion_line, motion_rows, motions, unit_of_errors
from symid.text import spoken

AnyRecord = TypeVar("AnyRecord")


def html_path(file: str | Path) -> Path:
    """Path of a report; SettingError if its suffix is not that of a page, or its folder does not exist."""
    path = written_path("report", file, ".html", ".htm")
    if not path.parent.is_dir():
        raise SettingError(f"report {path}: there is no folder {path.parent}: create it first")
    return path


def as_it_is(record: AnyRecord) -> AnyRecord:
    """The record: settings in its messages stay as the library names them."""
    return record


def page_templates() -> jinja2.Environment:
    """Templates that escape all text and know how reports write numbers."""
    templates = jinja2.Environment(
        loader=jinja2.PackageLoader("symid.report.pages"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    filters = (
        fit,
        motion_line,
        motion_rows,
        motions,
        unit_of_errors,
        removes,
        spread_size,
        spoken,
        colours.in_dark,
    )
    templates.filters |= {write.__name__: write for write in filters}
    templates.filters |= {name: write for name, write in vars(number_text).items() if isfunction(write)}
    templates.filters["packed"] = _packed
    templates.globals.update(colours=colours)
    return templates


def _packed(script: str) -> str:
    """A script as compressed base64, which a page unpacks and runs."""
    return b64encode(gzip.compress(script.encode(), mtime=0)).decode()


def provenance(sources: Iterable[str], command: str = "") -> list[tuple[str, str]]:
    """Name and value of each line: when, by which command and programs, and the SHA-256 of each log.

    A source of a log is a path, or several with commas or, of one log, plus signs between, or a name of no file, which
    has no hash.
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
