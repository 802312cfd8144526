"""Numbers behind the figures of a page as files that a link saves without a script."""

import base64
import gzip
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from typing import Any
from urllib.parse import quote

import numpy as np

from symid.arrays import FloatArray
from symid.report.figures.drawn import wide_and_narrow
from symid.report.figures.envelope import envelope, envelope_places
from symid.report.figures.identification_curves import IdentificationCurves
from symid.report.figures.overviews import correlation_figure
from symid.report.figures.panels import Panel
from symid.report.figures.residual_correlation import Correlation, OutputCorrelations
from symid.simulation.plants import FrequencyResponse, ResponseBand

_PLAIN, _MOST_SAVED = 3_000, 30_000
"""Rows up to which a table is saved as text, and those up to which it is saved whole, compressed; of a longer one the
envelope is."""


@dataclass(frozen=True)
class PlotData:
    """A link to the numbers of a figure: title, name of the file, and the file as an address."""

    title: str
    file: str
    address: str


def curve_data(curves: IdentificationCurves) -> list[PlotData]:
    """Numbers of the outputs over time and of the frequency responses."""
    panels = [
        _data(f"{panel.output}, {panel.title}", f"output-{k}", _of_panel(panel))
        for k, panel in enumerate(curves.panels, start=1)
    ]
    responses = [
        _data(f"frequency response of {of.signal}", f"response-{of.signal}", _of_response(of, band))
        for of, band in curves.responses
    ]
    return panels + responses


def correlation_fields(parts: Sequence[OutputCorrelations]) -> dict[str, Any]:
    """Fields of `memory.html`: the figure, its numbers, and the shares outside the bands of each part."""
    return {
        "remembered": wide_and_narrow(lambda narrow: correlation_figure(parts, narrow=narrow), "memory-plot"),
        "remembered_data": [
            _data(
                title,
                f"correlation-{k}",
                {**_of_correlation("auto", with_itself), **_of_correlation("cross", across)},
            )
            for k, (title, with_itself, across) in enumerate(parts, start=1)
        ],
        "whiteness": [(title, with_itself.outside, across.outside) for title, with_itself, across in parts],
    }


def _csv_text(columns: Mapping[str, FloatArray]) -> str:
    cells = ((f"{v:.8g}" if np.isfinite(v) else "" for v in column.tolist()) for column in columns.values())
    rows = [",".join(columns), *map(",".join, zip_longest(*cells, fillvalue=""))]
    return "\n".join(rows) + "\n"


def compressed_address(columns: Mapping[str, FloatArray]) -> str:
    """A table of numbers as the address of a CSV file compressed by gzip."""
    content = gzip.compress(_csv_text(columns).encode(), mtime=0)
    return f"data:application/gzip;base64,{base64.b64encode(content).decode()}"


def csv_address(columns: Mapping[str, FloatArray]) -> str:
    """A table of numbers as the address of a CSV file; columns may differ in length, nan is empty.

    >>> csv_address({"t [s]": np.array([0.0, 0.5]), "F": np.array([np.nan])})
    'data:text/csv;charset=utf-8,t%20%5Bs%5D,F%0A0,%0A0.5,%0A'
    """
    return "data:text/csv;charset=utf-8," + quote(_csv_text(columns), safe=",")


def _data(title: str, file: str, columns: Mapping[str, FloatArray]) -> PlotData:
    """Numbers of a figure; where there are many, compressed."""
    (name, places), *others = columns.items()
    if places.size <= _PLAIN:
        return PlotData(title, f"{file}.csv", csv_address(columns))
    if places.size > _MOST_SAVED:
        thin = {other: envelope(values, _MOST_SAVED) for other, values in others}
        columns = {name: envelope_places(places, _MOST_SAVED), **thin}
        title = f"{title} (envelope of {places.size} rows)"
    return PlotData(title, f"{file}.csv.gz", compressed_address(columns))


def _of_panel(panel: Panel) -> dict[str, FloatArray]:
    columns = {
        "time [s]": panel.time,
        f"measured {panel.output} [{panel.unit}]": panel.measured,
        f"predicted {panel.output} [{panel.unit}]": panel.predicted,
        f"residual [{panel.unit}]": panel.measured - panel.predicted,
    }
    if panel.motion is not None:
        position, velocity = panel.motion.at(panel.time)
        columns[f"position {panel.motion.signal} [{panel.motion.unit}]"] = position
        columns[f"velocity [{panel.motion.unit}/s]"] = velocity
    return columns


def _of_response(of: FrequencyResponse, band: ResponseBand) -> dict[str, FloatArray]:
    return {
        "frequency [Hz]": of.frequency,
        f"measured magnitude [{of.unit}]": np.abs(of.measured),
        "measured phase [deg]": np.rad2deg(np.angle(of.measured)),
        "coherence": of.coherence,
        "identified magnitude": np.abs(of.identified),
        "identified phase [deg]": np.rad2deg(np.angle(of.identified)),
        "band: frequency [Hz]": band.frequency,
        "band: lowest magnitude": band.lowest,
        "band: highest magnitude": band.highest,
        "band: latest phase relative to it [deg]": np.rad2deg(band.latest),
        "band: earliest": np.rad2deg(band.earliest),
    }


def _of_correlation(name: str, of: Correlation) -> dict[str, FloatArray]:
    return {
        f"lag of {name} [rows]": of.lag,
        f"{name}-correlation": of.value,
        f"{name}: lower band": of.of_noise - of.band,
        f"{name}: upper band": of.of_noise + of.band,
    }
