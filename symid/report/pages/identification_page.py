"""An identification as one HTML file: fit, parameters, residual and provenance."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, cast

import numpy as np
import scipy

from symid import __version__
from symid.axis import Axis
from symid.data import Log
from symid.diagnosis.in_motion import IdentifiedMotion, identified_motion
from symid.estimation import correlation_matrix, fit_percent
from symid.files import write_whole
from symid.identification import Identification, OutputPrediction
from symid.output_error import OutputErrorIdentification, OutputErrorPrediction
from symid.report.figures.drawn import wide_and_narrow
from symid.report.figures.identification_curves import (
    IdentificationCurves,
    identification_curves,
    parameters_shown,
)
from symid.report.figures.identification_figure import plot_identification
from symid.report.figures.residual_correlation import PredictedOutput, residual_correlations
from symid.report.pages.page import as_it_is, html_path, page_templates, provenance
from symid.report.pages.plot_data import correlation_fields, curve_data
from symid.report.tables.identification import identification_record
from symid.report.tables.number_text import significant
from symid.report.tables.output_error import output_error_record

_METHODS = {
    "wls": "weighted least squares (wls)",
    "ols": "ordinary least squares (ols)",
    "iv": "instrumental variables (iv)",
    "oe": "output error, by maximum likelihood (oe)",
}

_INTERVAL = float(scipy.special.ndtri(0.975))
"""Half width of a 95 % interval, in deviations."""


def write_identification_html(
    result: Identification | OutputErrorIdentification,
    file: str | Path,
    validation: OutputPrediction | OutputErrorPrediction | None = None,
    *,
    axis: Axis | None = None,
    runs: Sequence[Log] = (),
    command: str = "",
    reword: Callable[[Any], Any] = as_it_is,
) -> Path:
    """Write an identification as one self-contained HTML file; return its path.

    With the axis and its logs, that of the validation last (without one, those that the result keeps), the page shows
    the residual over the motion, the simulated motion and the frequency response; `command` is the command line that
    made it, `reword` writes the settings that messages name.
    """
    path, page = html_path(file), page_templates().get_template("identification.html")
    record = reword(_record(result, validation))
    curves = identification_curves(result, validation, axis=axis, runs=runs)
    outputs = [one for log in curves.logs[: len(result.logs)] for one in log.outputs]
    sources = [log if isinstance(log, str) else log.source for log in result.logs]
    text = page.render(
        r=record,
        fits=[_fit(one) for log in curves.logs for one in log.outputs],
        parameters=_parameters(result),
        half_width=_INTERVAL,
        correlations=_correlations(result),
        settings=_settings(record),
        fit=wide_and_narrow(
            lambda narrow: plot_identification(result, curves=curves, narrow=narrow), "fit-plot"
        ),
        fit_data=curve_data(curves),
        motions=[asdict(one) for one in _motions(result, curves)],
        **correlation_fields(residual_correlations(outputs)),
        made=provenance([*sources, *([validation.log] if validation else [])], command),
        version=__version__,
    )
    write_whole(path, text)
    return path


def _record(
    result: Identification | OutputErrorIdentification,
    validation: OutputPrediction | OutputErrorPrediction | None,
) -> dict[str, Any]:
    """Record of the command line."""
    if isinstance(result, Identification):
        return identification_record(result, cast("OutputPrediction | None", validation))
    return output_error_record(result, cast("OutputErrorPrediction | None", validation))


def _settings(record: dict[str, Any]) -> list[tuple[str, str]]:
    """Name and value of each setting, in words."""
    scaled, plain = (significant(record[name]) for name in ("condition_number_scaled", "condition_number"))
    method = ("method", _METHODS.get(record["method"], record["method"]))
    condition = ("condition number", f"{scaled} scaled, {plain} as it is")
    if record["method"] == "oe":
        force, noise = record["force"], record["noise"].items()
        return [
            method,
            ("course of the force between samples", force["course"]),
            ("timing of the force", f"{_later(force['late_s'])}, {force['timing']}"),
            ("noise, rms", ", ".join(f"{name} {significant(n['std'])} {n['unit']}" for name, n in noise)),
            ("samples", str(record["samples"])),
            condition,
        ]
    used = record["filter"]
    ends = " and ".join(str(samples) for samples in used["trim"]) or "no"
    delays = [f"{signal} by {significant(1e6 * by)} us" for signal, by in used["late_s"].items() if by]
    return [
        method,
        ("cutoff frequency", f"{significant(used['cutoff_hz'])} Hz, order {used['order']}"),
        ("force", "filtered as the motion is" if used["force_filtered"] else "not filtered"),
        ("decimation", f"one row for every {used['decimation']} samples"),
        ("differences", f"of order of accuracy {used['difference_order']}"),
        ("left out at the ends", f"{ends} samples"),
        ("recorded late", ", ".join(delays) or "nothing"),
        condition,
    ]


def _later(late: float) -> str:
    """When a force acts that was recorded late, by seconds.

    >>> _later(-125e-6), _later(0.0)
    ('acts 125 us after its record', 'acts when it was recorded')
    """
    if late == 0.0:
        return "acts when it was recorded"
    return f"acts {significant(abs(1e6 * late))} us {'before' if late > 0 else 'after'} its record"


def _fit(output: PredictedOutput) -> dict[str, Any]:
    y, predicted = output.measured[output.used], output.predicted[output.used]
    rms = float(np.sqrt(np.mean(np.square(y - predicted)))) if y.size else float("nan")
    of_output = {"log": output.log, "output": output.name, "unit": output.unit, "rms": rms, "rows": y.size}
    return {**of_output, "fit": fit_percent(y, predicted)}


def _motions(
    result: Identification | OutputErrorIdentification, curves: IdentificationCurves
) -> list[IdentifiedMotion]:
    """The identified axis simulated along each log; none without the axis."""
    if curves.axis is None:
        return []
    values = result.physical_parameters
    return [
        replace(identified_motion(curves.axis, values, run, log.late), log=log.title)
        for log, run in zip(curves.logs, curves.runs, strict=False)
    ]


def _parameters(result: Identification | OutputErrorIdentification) -> list[dict[str, Any]]:
    """Physical parameters, or minimal ones where there are none, with their 95 % intervals."""
    shown = parameters_shown(result)
    rows = zip(shown.units.items(), shown.values.tolist(), shown.deviations.tolist(), strict=True)
    return [{"name": name, "unit": unit, "value": value, "std": std} for (name, unit), value, std in rows]


def _correlations(result: Identification | OutputErrorIdentification) -> list[tuple[str, list[float]]]:
    """Correlations of the parameters that the logs determine."""
    shown = parameters_shown(result)
    known = np.flatnonzero(np.isfinite(np.diag(shown.covariance)))
    names = [name for place, name in enumerate(shown.units) if place in known]
    rows = correlation_matrix(shown.covariance[np.ix_(known, known)])
    return [(name, row.tolist()) for name, row in zip(names, rows, strict=True)]
