"""A diagnosis as one self-contained HTML file."""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Final

from symid import __version__
from symid.axis import shipped_folder
from symid.diagnosis import Diagnosis
from symid.files import write_whole
from symid.report.figures.residual_correlation import MOST_LAGS, OutputCorrelations, correlation
from symid.report.pages.page import as_it_is, html_path, page_templates, provenance
from symid.report.pages.plot_data import correlation_fields
from symid.report.tables.diagnosis import diagnosis_record

_ORIGIN = 0.5
"""Lower end of a logarithmic scale, in multiples of the noise floor."""
_MOST_LINEAR = 25.0
_LEAST = 4.0
"""Least upper end of a scale, in multiples of the noise floor."""
_TICKS = 6
"""Most ticks on a scale."""


@dataclass(frozen=True)
class DiagramScale:
    """Scale of bars up to a multiple of the noise floor: linear up to 25, logarithmic from half of that on.

    >>> DiagramScale(10.0).percent(5.0), DiagramScale(5000.0).logarithmic, DiagramScale(5000.0).percent(50.0)
    (50.0, True, 50.0)
    >>> DiagramScale(10.0).ticks, DiagramScale(1244.0).ticks
    ((0.0, 2.0, 4.0, 6.0, 8.0, 10.0), (1.0, 10.0, 100.0, 1000.0))
    """

    largest: float

    @property
    def logarithmic(self) -> bool:
        """Whether equal lengths are equal ratios."""
        return self.largest > _MOST_LINEAR

    def percent(self, multiple: float) -> float:
        """Length of a bar in percent of the full length; 0 for nan."""
        if not math.isfinite(multiple) or multiple <= 0:
            return 0.0
        if not self.logarithmic:
            return min(100 * multiple / self.largest, 100.0)
        return min(100 * max(math.log(multiple / _ORIGIN), 0.0) / math.log(self.largest / _ORIGIN), 100.0)

    @property
    def ticks(self) -> tuple[float, ...]:
        """Multiples at which the scale is marked."""
        if self.logarithmic:
            decades = range(math.floor(math.log10(self.largest)) + 1)
            return tuple(10.0**k for k in decades)
        steps = (m * 10.0**k for k in range(-2, 2) for m in (1, 2, 5))
        step = next(step for step in steps if self.largest / step < _TICKS)
        return tuple(step * i for i in range(math.floor(self.largest / step) + 1))


def scale_with(multiples: list[float]) -> DiagramScale:
    """Scale that contains all of these multiples, with a margin above the floor."""
    return DiagramScale(max([_LEAST, *(value for value in multiples if math.isfinite(value))]))


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


def write_diagnosis_html(
    diagnosis: Diagnosis, file: str | Path, reword: Callable[[Any], Any] = as_it_is, command: str = ""
) -> Path:
    """Write a diagnosis as one self-contained HTML file; without JavaScript only its plots are missing.

    `reword` writes the settings that messages name; `command` is the command line that made it.
    """
    from symid.report.figures.schematic import schematic_svg
    from symid.report.pages.interactive import plots_of  # half a second to load: only where a page is written

    path, record = html_path(file), reword(diagnosis_record(diagnosis))
    ranked = list(enumerate(record["alternatives"], start=1))
    shown = [
        (k, alternative)
        for k, alternative in ranked
        if k <= _MOST_SHOWN or (alternative["effect"], alternative["at"]) in diagnosis.named
    ]
    page = page_templates().get_template("diagnosis.html")
    text = page.render(
        d=record,
        verdict=VERDICTS[diagnosis.verdict],
        scale=scale_with([stage["multiple_of_floor"] for stage in record["waterfall"]]),
        maps=[(MAPS.get(name, name), cells) for name, cells in record["maps"].items() if cells],
        accepted=diagnosis.named,
        shown=shown,
        more=[alternative for alternative in ranked if alternative not in shown],
        plots=plots_of(diagnosis),
        catalogue=effect_catalogue(),
        schematic=schematic_svg(diagnosis.axis),
        **correlation_fields(_correlations(diagnosis)),
        settings=_settings(diagnosis),
        made=provenance(diagnosis.logs, command),
        version=__version__,
    )
    write_whole(path, text)
    return path


def _correlations(diagnosis: Diagnosis) -> list[OutputCorrelations]:
    """Auto- and cross-correlation of each weighted force error, where there are enough rows."""
    parts = []
    for drive in diagnosis.drives or (diagnosis,):
        signals, weighted, used = drive.signals, drive.weighted, drive.signals.compared
        if weighted is None or used.sum() < _FEWEST_ROWS:
            continue
        most = min(MOST_LAGS, used.size // 4, weighted.noise.size - 1)
        alone = correlation(weighted.error, weighted.error, used, range(most + 1), weighted.noise)
        across = correlation(weighted.error, weighted.predicted, used, range(-most, most + 1), weighted.noise)
        step = float(signals.time[1] - signals.time[0])
        title = f"{drive.gap.signal}, rows of {1e3 * step:.3g} ms"
        parts.append(OutputCorrelations(title, alone, across))
    return parts


def _settings(diagnosis: Diagnosis) -> list[tuple[str, str]]:
    """Name and value of each setting of a diagnosis."""
    gap, nominal = diagnosis.gap, any(math.isfinite(p.nominal) for p in diagnosis.parameters)
    settings = [
        ("sensors", ", ".join(diagnosis.measured)),
        ("nominal values", "of a simulator's log" if diagnosis.simulated else "given" if nominal else "none"),
        ("forces compared", f"up to {gap.band_hz:.3g} Hz"),
    ]
    if diagnosis.record is not None:
        log, late = diagnosis.record.log, diagnosis.record.late
        settings.append(("motion used", f"up to {diagnosis.record.motion_hz:.3g} Hz"))
        settings.append(("sampled", f"every {1e3 * log.sampling_period:.4g} ms"))
        times = ", ".join(f"{name} {1e6 * by:.4g} us" for name, by in late.items() if by)
        settings.append(("recorded late", times or "nothing"))
    return settings


_ENTRY: Final = re.compile(
    r"^## (?P<name>\w+)\n.*?^\*\*Law\.\*\* (?P<law>.*?)\n\*At\*.*?^\*\*On the machine\.\*\* (?P<remedy>.*?)(?=\n\n|\Z)",
    re.MULTILINE | re.DOTALL,
)
_LINK: Final = re.compile(r"\[([^\]]*)\]\([^)]*\)")


@dataclass(frozen=True)
class CatalogueEntry:
    """An effect in the catalogue."""

    law: str
    remedy: str


@cache
def effect_catalogue() -> Mapping[str, CatalogueEntry]:
    """Entries of the catalogue by the name of the effect, as plain text.

    >>> effect_catalogue()["delay"].law
    'The force acts T later than logged: u(t - T).'
    """
    text = (shipped_folder("docs") / "effects" / "index.md").read_text(encoding="utf-8")
    return {
        entry["name"]: CatalogueEntry(_plain(entry["law"]), _plain(entry["remedy"]))
        for entry in _ENTRY.finditer(text)
    }


def _plain(text: str) -> str:
    r"""Text without links and emphasis, in one line.

    >>> _plain("of the *commanded* velocity, see\n[there](#delay) and `--held`; 2 * 3")
    'of the commanded velocity, see there and --held; 2 * 3'
    """
    shown = _LINK.sub(r"\1", " ".join(text.split()))
    return re.sub(r"\*(\S[^*]*?\S|\S)\*", r"\1", shown).replace("`", "")
