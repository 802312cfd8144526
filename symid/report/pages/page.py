"""Pages of reports: their files and their templates."""

from __future__ import annotations

from inspect import isfunction
from pathlib import Path
from typing import TypeVar

import jinja2

from symid.errors import SettingError
from symid.report.figures import colours
from symid.report.tables import number_text
from symid.report.tables.diagnosis import removes
from symid.report.tables.motion_gap import fit, motion_line, motion_rows, motions

Record = TypeVar("Record")


def html_path(file: str | Path) -> Path:
    """Path of a report; SettingError if its suffix is not that of a page, or its folder does not exist."""
    path = Path(file)
    if path.suffix.lower() not in (".html", ".htm"):
        raise SettingError(f"report {path.name!r} is of an unknown kind: end its name with .html")
    if not path.parent.is_dir():
        raise SettingError(f"report {path}: there is no folder {path.parent}; make it first")
    return path


def as_it_is(record: Record) -> Record:
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
    for write in (fit, motion_line, motion_rows, motions, removes, colours.in_dark):
        templates.filters[write.__name__] = write
    templates.filters |= {name: write for name, write in vars(number_text).items() if isfunction(write)}
    templates.globals.update(colours=colours)
    return templates
