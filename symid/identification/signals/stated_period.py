"""Sampling period that a text file states above its values."""

import re
from pathlib import Path

from symid.data import Layout
from symid.data.text_files import first_lines
from symid.units import to_si

_PERIOD = re.compile(
    r"(?:cycle|sampl|period|interval|abtast|takt)(?:[^\d\n]*?[\[(](?P<before>s|ms|us|µs|ns|Hz|kHz)[\])])?"
    r"[^\d\n]*(?P<value>\d+(?:[.,]\d+)?)[\s,;'\x22]*[\[(]?(?P<unit>s|ms|us|µs|ns|Hz|kHz)?\b",
    re.IGNORECASE,
)


def stated_period(path: Path, layout: Layout) -> float | None:
    """Sampling period that a line above the header states, s; None without such a line.

    Parameters
    ----------
    path : Path
        A text file.
    layout : Layout
        Its layout: its lines above the header are searched.

    Examples
    --------
    >>> _period_in("Sampling interval: 2 ms"), _period_in("SampleRate;4 kHz"), _period_in("Samples: 9")
    (0.002, 0.00025, None)
    >>> _period_in("Sampling cycle,1[ms]"), _period_in("Sampling time [us];250"), _period_in('"Period","250","us"')
    (0.001, 0.00025, 0.00025)
    """
    found = (_period_in(line) for line in first_lines(path, layout.encoding)[: layout.above])
    return next((period for period in found if period), None)


def _period_in(line: str) -> float | None:
    match = _PERIOD.search(line)
    unit = (match["unit"] or match["before"]) if match else None
    if match is None or unit is None:
        return None
    value = float(match["value"].replace(",", ".")) * to_si(unit.replace("µ", "u"))
    if not value:
        return None
    return 1.0 / value if "Hz" in unit else value
