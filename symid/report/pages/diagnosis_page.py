"""A diagnosis as one self-contained HTML file."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

from symid import __version__
from symid.diagnosis import Diagnosis
from symid.files import write_whole
from symid.identification.residual_correlation import MOST_LAGS, OutputCorrelations, correlation
from symid.report.pages.bar_scale import scale_of
from symid.report.pages.effect_catalogue import effect_catalogue
from symid.report.pages.page import as_it_is, html_path, page_templates, provenance
from symid.report.pages.plot_data import correlation_fields
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

_FEWEST_ROWS = 20
_MOST_SHOWN = 8
"""Number of alternatives that are shown at first; accepted effects always are."""


def write_html(
    found: Diagnosis, file: str | Path, reword: Callable[[Any], Any] = as_it_is, command: str = ""
) -> None:
    """Write a diagnosis as one HTML file, which loads nothing; without JavaScript only its plots are missing.

    `reword` writes the settings that messages name; `command` is the command line that made it.
    """
    from symid.report.figures.schematic import schematic_svg
    from symid.report.pages.interactive import plots_of  # half a second to load: only where a page is written

    path, record = html_path(file), reword(diagnosis_record(found))
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
        **correlation_fields(_correlations(found)),
        settings=_settings(found),
        made=provenance(found.logs, command),
        version=__version__,
    )
    write_whole(path, text)


def _correlations(found: Diagnosis) -> list[OutputCorrelations]:
    """Auto- and cross-correlation of each weighted force error, where there are enough rows."""
    parts = []
    for own in found.drives or (found,):
        signals, weighted, used = own.signals, own.weighted, own.signals.compared
        if weighted is None or used.sum() < _FEWEST_ROWS:
            continue
        most = min(MOST_LAGS, used.size // 4, weighted.noise.size - 1)
        alone = correlation(weighted.error, weighted.error, used, range(most + 1), weighted.noise)
        across = correlation(weighted.error, weighted.predicted, used, range(-most, most + 1), weighted.noise)
        step = float(signals.time[1] - signals.time[0])
        title = f"{own.gap.signal}, rows of {1e3 * step:.3g} ms"
        parts.append(OutputCorrelations(title, alone, across))
    return parts


def _settings(found: Diagnosis) -> list[tuple[str, str]]:
    """Name and value of each setting of a diagnosis."""
    gap, nominal = found.gap, any(math.isfinite(p.nominal) for p in found.parameters)
    settings = [
        ("sensors", ", ".join(found.measured)),
        ("nominal values", "of a simulator's log" if found.simulated else "given" if nominal else "none"),
        ("forces compared", f"up to {gap.band_hz:.3g} Hz"),
    ]
    if found.record is not None:
        log, late = found.record.log, found.record.late
        settings.append(("motion used", f"up to {found.record.motion_hz:.3g} Hz"))
        settings.append(("sampled", f"every {1e3 * log.sampling_period:.4g} ms"))
        times = ", ".join(f"{name} {1e6 * by:.4g} us" for name, by in late.items() if by)
        settings.append(("recorded late", times or "nothing"))
    return settings
