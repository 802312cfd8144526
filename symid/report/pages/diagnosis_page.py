"""A diagnosis as one self-contained HTML file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from symid import __version__
from symid.diagnosis import Diagnosis
from symid.files import write_whole
from symid.report.pages.bar_scale import scale_of
from symid.report.pages.effect_catalogue import effect_catalogue
from symid.report.pages.page import as_it_is, html_path, page_templates
from symid.report.tables.diagnosis import diagnosis_record

VERDICTS = {
    "no_gap": "No gap",
    "parameters": "Values were off",
    "effect": "Effect found",
    "partly": "Explained in part",
    "recording": "Damaged recording",
    "unexplained": "Unexplained gap",
}

MAPS = {
    "band": "Frequency",
    "regime": "Regime of motion",
    "direction": "Direction",
    "position": "Position along the stroke",
    "drive force": "Drive force",
    "time": "Time",
}

_MOST_SHOWN = 8
"""Number of alternatives that are shown at first; accepted effects always are."""


def write_html(found: Diagnosis, file: str | Path, said: Callable[[Any], Any] = as_it_is) -> None:
    """Write a diagnosis as one HTML file, which loads nothing; without JavaScript only its plots are missing.

    `said` writes the settings that messages name.
    """
    from symid.report.figures.schematic import schematic_svg
    from symid.report.pages.interactive import plots_of  # half a second to load: only where a page is written

    path, record = html_path(file), said(diagnosis_record(found))
    accepted = {(effect.effect, effect.at) for effect in found.effects}
    ranked = list(enumerate(record["alternatives"], start=1))
    shown = [(k, one) for k, one in ranked if k <= _MOST_SHOWN or (one["effect"], one["at"]) in accepted]
    page = page_templates().get_template("diagnosis.html")
    text = page.render(
        d=record,
        verdict=VERDICTS[found.verdict],
        scale=scale_of([stage["multiple_of_floor"] for stage in record["waterfall"]]),
        maps=[(MAPS.get(name, name), cells) for name, cells in record["maps"].items() if cells],
        accepted=accepted,
        shown=shown,
        more=[one for one in ranked if one not in shown],
        plots=plots_of(found),
        catalogue=effect_catalogue(),
        schematic=schematic_svg(found.axis),
        version=__version__,
    )
    write_whole(path, text)
