"""The review of a fleet as one HTML file: summary, axes with their charts, outliers, and a table of all logs."""

import math
import re
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import polars as pl

from symid import __version__
from symid.files import write_whole
from symid.fleet import AxisReview, FleetReview, JointIdentification, numbers_in, parameter_names
from symid.report.pages import control_chart_svg
from symid.report.pages.control_chart_svg import (
    ChartShapes,
    DistributionShapes,
    chart_shapes,
    distribution_shapes,
)
from symid.report.pages.page import html_path, page_templates
from symid.report.tables.fleet import fleet_record

_MOST_OPEN = 6
"""Number of axes that are open at first; the others open on a click."""
_MOST_OUTLIERS = 40
_FIRST = ("log", "axis", "status", "recorded", "verdict", "effect", "at", "probability")
_LAST = ("message", "residual_relative", "condition_number", "cutoff_hz", "samples", "seconds")
"""Columns of the table of logs before and after the parameters, where the results have them."""
_SECONDS = re.compile(r"^(\d{4}-\d\d-\d\d)[T ](\d\d:\d\d(:\d\d)?)\S*$")
"""A time, which the table shows to the second."""
_TEXTS = {"log", "axis", "status", "recorded", "verdict", "effect", "at", "message"}


@dataclass(frozen=True)
class _Drawn:
    """A parameter as the page shows it."""

    name: str
    record: dict[str, Any]
    chart: ChartShapes | None
    distribution: DistributionShapes | None


@dataclass(frozen=True)
class _Section:
    """An axis as the page shows it."""

    record: dict[str, Any]
    parameters: tuple[_Drawn, ...]
    opened: bool


def write_fleet_html(
    review: FleetReview, file: str | Path, joined: Mapping[str, JointIdentification] | None = None
) -> Path:
    """Write the review of a fleet, with joint results by axis, as one self-contained HTML file; return its path.

    Without JavaScript only the table of all logs is missing.
    """
    path = html_path(file)
    record = fleet_record(review, joined)
    places = {log: row for row, log in enumerate(map(str, review.table["log"]))}
    sections, outliers = _sections(review, record, places), _outliers(record)
    page = page_templates().get_template("fleet.html")
    text = page.render(
        r=record,
        sections=sections,
        changes=[
            {
                "axis": section.record["name"],
                "place": place,
                "parameter": name,
                "sentence": change["sentence"],
            }
            for place, section in enumerate(sections)
            for name, parameter in section.record["parameters"].items()
            for change in parameter["changes"]
        ],
        outliers=outliers[:_MOST_OUTLIERS],
        outlying=len(outliers),
        logs=_logs(review),
        drawing=control_chart_svg,
        version=__version__,
    )
    write_whole(path, text)
    return path


def _sections(review: FleetReview, record: dict[str, Any], places: dict[str, int]) -> list[_Section]:
    """Axes, those with findings first; the first few are open."""

    def findings(axis: AxisReview) -> int:
        return sum(len(parameter.chart.changes) for parameter in axis.parameters) + axis.verdict.differs

    pairs = sorted(zip(review.axes, record["axes"], strict=True), key=lambda pair: -findings(pair[0]))
    sections = []
    for k, (axis, of_record) in enumerate(pairs):
        drawn = []
        for parameter in axis.parameters:
            shapes = distribution = None
            if parameter.chart.values.size:
                shapes = chart_shapes(parameter, [places[log] for log in parameter.logs])
                distribution = distribution_shapes(parameter, parameter.chart.values)
            drawn.append(
                _Drawn(parameter.name, of_record["parameters"][parameter.name], shapes, distribution)
            )
        sections.append(_Section(of_record, tuple(drawn), opened=k < _MOST_OPEN))
    return sections


def _outliers(record: dict[str, Any]) -> list[dict[str, Any]]:
    """Outliers of all axes, the farthest first."""
    outliers = [
        {"axis": axis["name"], "parameter": name, "unit": parameter["unit"], **far}
        for axis in record["axes"]
        for name, parameter in axis["parameters"].items()
        for far in parameter["outliers"]
    ]
    return sorted(outliers, key=lambda far: -abs(far["z"]))


def _logs(review: FleetReview) -> dict[str, Any]:
    """Columns of the table of logs; a parameter's deviation stands beside its value, its unit in its heading."""
    table, units = review.table, defaultdict[str, set[str]](set)
    for axis in review.axes:
        for parameter in axis.parameters:
            units[parameter.name].add(parameter.unit)
    columns: list[dict[str, Any]] = []
    parameters = [name for name in parameter_names(table) if name in units]  # those that an axis shows
    for name in (*_FIRST, *parameters, *_LAST):
        if name not in table.columns:
            continue
        if name in _TEXTS:
            texts = ["" if value is None else _SECONDS.sub(r"\1 \2", str(value)) for value in table[name]]
            columns.append({"name": name, "text": True, "values": texts})
            continue
        column = {"name": name, "text": False, "values": _plain(table, name)}
        if name in parameters:
            column["unit"] = "".join(units[name]) if len(units[name]) == 1 else ""  # not the same in all axes
            column["deviations"] = _plain(table, f"{name}_std")
        columns.append(column)
    return {"count": table.height, "columns": columns}


def _plain(table: pl.DataFrame, name: str) -> list[float | None]:
    """Numbers of seven digits; None for nan."""
    return [float(f"{value:.7g}") if math.isfinite(value) else None for value in numbers_in(table, name)]
