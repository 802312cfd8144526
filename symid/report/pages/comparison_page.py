"""Two results side by side as one HTML file."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import matplotlib as mpl
import scipy

from symid import __version__
from symid.files import write_whole
from symid.report.figures.colours import LIGHT
from symid.report.figures.drawn import Drawn, wide_and_narrow
from symid.report.pages.page import html_path, page_templates, provenance
from symid.report.tables.result_comparison import comparison_sentence, shown_setting

_INTERVAL = float(scipy.special.ndtri(0.975))
"""Half width of a 95 % interval, in deviations."""
_ROW, _WIDTH, _NARROW_WIDTH = 0.55, 8.0, 4.2
"""In inches."""


def comparison_figure(record: Mapping[str, Any], *, narrow: bool) -> Drawn | None:
    """Each parameter of both results, in percent of A, with 95 % intervals; None where A is 0 throughout."""
    drawn = {name: entry for name, entry in record["parameters"].items() if entry["a"]["value"]}
    if not drawn:
        return None
    with mpl.rc_context(LIGHT.style):
        size = (_NARROW_WIDTH if narrow else _WIDTH, _ROW * len(drawn) + 1.1)
        figure = Drawn(figsize=size, layout="constrained")
        axes = figure.subplots()
        looks = (("a", "A", LIGHT.measured, "o", -0.13), ("b", "B", LIGHT.model, "^", 0.13))
        for side, label, colour, mark, beside in looks:
            scale = [100.0 / abs(entry["a"]["value"]) for entry in drawn.values()]
            apart = [entry[side]["value"] - entry["a"]["value"] for entry in drawn.values()]
            stds = [entry[side]["std"] for entry in drawn.values()]
            axes.errorbar(
                [value * by for value, by in zip(apart, scale, strict=True)],
                [place + beside for place in range(len(drawn))],
                xerr=[
                    _INTERVAL * std * by if math.isfinite(std) else 0.0
                    for std, by in zip(stds, scale, strict=True)
                ],
                fmt=mark,
                color=colour,
                label=label,
                capsize=3,
            )
        axes.set_yticks(range(len(drawn)), list(drawn))
        axes.set_ylim(len(drawn) - 0.5, -0.5)
        axes.set_xlabel("difference from A [%], with 95 % intervals")
        figure.legend(loc="outside upper right", ncols=2, frameon=False)
    return figure


def write_comparison_html(record: Mapping[str, Any], file: str | Path, command: str = "") -> None:
    """Write the record of `comparison_record` as one HTML file, which loads nothing; `command` is the command line."""
    path = html_path(file)
    page = page_templates().get_template("comparison.html")
    text = page.render(
        shown=shown_setting,
        r=record,
        sentence=comparison_sentence(record),
        intervals=wide_and_narrow(lambda narrow: comparison_figure(record, narrow=narrow), "intervals"),
        made=provenance(record["files"], command),
        version=__version__,
    )
    write_whole(path, text)
