"""An identification as one HTML file: fit, parameters, residual and provenance."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import scipy

from symid import __version__
from symid.arrays import FloatArray
from symid.axis import Axis
from symid.data import Log
from symid.diagnosis.in_motion.identified_motion import IdentifiedMotion, identified_motion
from symid.estimation.correlation import correlation_matrix
from symid.estimation.residual_measures import fit_percent
from symid.files import write_whole
from symid.identification import Identification, OutputPrediction
from symid.identification.observation import Observation
from symid.identification.residual_correlation import residual_correlations
from symid.report.figures.drawn import wide_and_narrow
from symid.report.figures.identification_curves import identification_curves
from symid.report.figures.identification_figure import identification_figure
from symid.report.pages.correlation_section import correlation_fields
from symid.report.pages.page import as_it_is, html_path, page_templates
from symid.report.pages.plot_data import curve_data
from symid.report.pages.provenance import provenance
from symid.report.tables.identification import identification_record
from symid.report.tables.number_text import significant

_METHODS = {
    "wls": "weighted least squares (wls)",
    "ols": "ordinary least squares (ols)",
    "iv": "instrumental variables (iv)",
}
_INTERVAL = float(scipy.special.ndtri(0.975))
"""Half width of a 95 % interval, in deviations."""


def write_identification_html(
    found: Identification,
    file: str | Path,
    validation: OutputPrediction | None = None,
    *,
    axis: Axis | None = None,
    runs: Sequence[Log] = (),
    command: str = "",
    reword: Callable[[Any], Any] = as_it_is,
) -> None:
    """Write an identification as one HTML file, which loads nothing.

    With the axis and its logs, that of the validation last (without one, those that the result keeps), the page shows
    the residual over the motion, the simulated motion and the frequency response; `command` is the command line that
    made it, `reword` writes the settings that messages name.
    """
    path = html_path(file)
    if axis is None and validation is None:
        axis, runs = found.axis, found.runs
    record = reword(identification_record(found, validation))
    page = page_templates().get_template("identification.html")
    curves = identification_curves(found, validation, axis=axis, runs=runs)
    text = page.render(
        r=record,
        fits=_fits(found, validation),
        parameters=_parameters(found),
        half_width=_INTERVAL,
        correlations=_correlations(found),
        settings=_settings(record),
        fit=wide_and_narrow(
            lambda narrow: identification_figure(found, curves=curves, narrow=narrow), "fit-plot"
        ),
        fit_data=curve_data(curves),
        motions=[asdict(one) for one in _motions(found, validation, axis, runs)],
        **correlation_fields(residual_correlations(found)),
        made=provenance([*found.logs, *([validation.log] if validation is not None else [])], command),
        version=__version__,
    )
    write_whole(path, text)


def _fits(found: Identification, validation: OutputPrediction | None) -> list[dict[str, Any]]:
    logs = zip(found.logs, found.observations, strict=True)
    runs: list[tuple[str, Observation, FloatArray]] = [(log, run, found.fit.solution) for log, run in logs]
    if validation is not None:
        runs.append((f"{validation.log} (validation)", validation.observation, validation.parameters))
    rows = []
    for source, run, parameters in runs:
        for j, (output, unit) in enumerate(found.output_units.items()):
            y, predicted = run.y[j][run.valid[j]], (run.W[j] @ parameters)[run.valid[j]]
            rms = float(np.sqrt(np.mean(np.square(y - predicted)))) if y.size else float("nan")
            row = {"log": source, "output": output, "unit": unit, "rms": rms, "rows": y.size}
            rows.append({**row, "fit": fit_percent(y, predicted)})
    return rows


def _motions(
    found: Identification, validation: OutputPrediction | None, axis: Axis | None, runs: Sequence[Log]
) -> list[IdentifiedMotion]:
    """The identified axis simulated along each log; none without the axis."""
    if axis is None:
        return []
    observations = [*found.observations, *([validation.observation] if validation is not None else [])]
    titles = [*found.logs, *([f"{validation.log} (validation)"] if validation is not None else [])]
    return [
        replace(
            identified_motion(axis, found.physical_parameters, run, observation.preparation.late), log=title
        )
        for title, run, observation in zip(titles, runs, observations, strict=False)
    ]


def _parameters(found: Identification) -> list[dict[str, Any]]:
    """Physical parameters, or minimal ones where there are none, with their 95 % intervals."""
    deviations = found.physical_deviations if found.physical else found.standard_deviations
    units: Mapping[str, str] = found.model.physical_units if found.physical else found.model.minimal_units
    return [
        {
            "name": name,
            "unit": units[name],
            "value": value,
            "std": float(std),
        }
        for (name, value), std in zip(found.parameters.items(), deviations, strict=True)
    ]


def _settings(record: dict[str, Any]) -> list[tuple[str, str]]:
    """Name and value of each setting, in words."""
    one = record["filter"]
    ends = " and ".join(str(samples) for samples in one["trim"]) or "no"
    late = [f"{signal} by {significant(1e6 * by)} us" for signal, by in one["late_s"].items() if by]
    condition = (f"{significant(record[name])}" for name in ("condition_number", "condition_number_scaled"))
    return [
        ("method", _METHODS.get(record["method"], record["method"])),
        ("cutoff frequency", f"{significant(one['cutoff_hz'])} Hz, order {one['order']}"),
        ("force", "filtered as the motion is" if one["force_filtered"] else "not filtered"),
        ("decimation", f"one row for every {one['decimation']} samples"),
        ("differences", f"of order of accuracy {one['difference_order']}"),
        ("left out at the ends", f"{ends} samples"),
        ("recorded late", ", ".join(late) or "nothing"),
        ("condition number", " scaled, ".join(reversed(list(condition))) + " as it is"),
    ]


def _correlations(found: Identification) -> list[tuple[str, list[float]]]:
    """Correlations of the same parameters."""
    covariance = found.physical[0].propagated(found.covariance) if found.physical else found.covariance
    names = found.model.physical_units if found.physical else found.model.minimal_units
    return [(name, row.tolist()) for name, row in zip(names, correlation_matrix(covariance), strict=True)]
