"""Two results side by side as one HTML file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from symid import __version__
from symid.files import write_whole
from symid.report.figures.comparison_figure import comparison_figure
from symid.report.figures.drawn import wide_and_narrow
from symid.report.pages.page import html_path, page_templates, provenance
from symid.report.tables.result_comparison import comparison_sentence


def write_comparison_html(record: Mapping[str, Any], file: str | Path, command: str = "") -> None:
    """Write a comparison as one HTML file, which loads nothing.

    Parameters
    ----------
    record : mapping
        That of `comparison_record`.
    file : path-like
        Ends with .html.
    command : str
        The command line that made it.
    """
    path = html_path(file)
    page = page_templates().get_template("comparison.html")
    text = page.render(
        r=record,
        sentence=comparison_sentence(record),
        intervals=wide_and_narrow(lambda narrow: comparison_figure(record, narrow=narrow), "intervals"),
        made=provenance(record["files"], command),
        version=__version__,
    )
    write_whole(path, text)
