"""An identification as one HTML file: fit, parameters, residual and provenance."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, TypeAlias, cast

import numpy as np
import scipy

from symid import __version__
from symid.axis import Axis
from symid.data import Log
from symid.diagnosis.in_motion.identified_motion import IdentifiedMotion, identified_motion
from symid.estimation.correlation import correlation_matrix
from symid.estimation.residual_measures import fit_percent
from symid.files import write_whole
from symid.identification import Identification, OutputPrediction
from symid.identification.residual_correlation import PredictedOutput, residual_correlations
from symid.output_error import OutputErrorIdentification, OutputErrorPrediction
from symid.report.figures.drawn import wide_and_narrow
from symid.report.figures.identification_curves import identification_curves, parameters_shown
from symid.report.figures.identification_figure import identification_figure
from symid.report.pages.identification_content import IdentifiedEquations, IdentifiedReadings
from symid.report.pages.page import as_it_is, html_path, page_templates, provenance
from symid.report.pages.plot_data import correlation_fields, curve_data

Content: TypeAlias = "IdentifiedEquations | IdentifiedReadings"
_INTERVAL = float(scipy.special.ndtri(0.975))
"""Half width of a 95 % interval, in deviations."""


def write_identification_html(
    found: Identification | OutputErrorIdentification,
    file: str | Path,
    validation: OutputPrediction | OutputErrorPrediction | None = None,
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
    content: Content
    if isinstance(found, Identification):
        content = IdentifiedEquations(found, cast("OutputPrediction | None", validation))
    else:
        content = IdentifiedReadings(found, cast("OutputErrorPrediction | None", validation))
    if axis is None and validation is None:
        axis, runs = found.axis, content.logs
    record = reword(content.record)
    page = page_templates().get_template("identification.html")
    curves = identification_curves(found, validation, axis=axis, runs=runs)
    outputs = content.outputs
    text = page.render(
        r=record,
        fits=[_fit(one) for one in (*outputs, *content.validating)],
        parameters=_parameters(content),
        half_width=_INTERVAL,
        correlations=_correlations(content),
        settings=content.settings(record),
        fit=wide_and_narrow(
            lambda narrow: identification_figure(found, curves=curves, narrow=narrow), "fit-plot"
        ),
        fit_data=curve_data(curves),
        motions=[asdict(one) for one in _motions(content, axis, runs)],
        **correlation_fields(residual_correlations(outputs)),
        made=provenance(content.sources, command),
        version=__version__,
    )
    write_whole(path, text)


def _fit(one: PredictedOutput) -> dict[str, Any]:
    y, predicted = one.measured[one.used], one.predicted[one.used]
    rms = float(np.sqrt(np.mean(np.square(y - predicted)))) if y.size else float("nan")
    of_output = {"log": one.log, "output": one.name, "unit": one.unit, "rms": rms, "rows": y.size}
    return {**of_output, "fit": fit_percent(y, predicted)}


def _motions(content: Content, axis: Axis | None, runs: Sequence[Log]) -> list[IdentifiedMotion]:
    """The identified axis simulated along each log; none without the axis."""
    if axis is None:
        return []
    return [
        replace(identified_motion(axis, content.values, run, late), log=title)
        for (title, late), run in zip(content.late, runs, strict=False)
    ]


def _parameters(content: Content) -> list[dict[str, Any]]:
    """Physical parameters, or minimal ones where there are none, with their 95 % intervals."""
    shown = parameters_shown(content.found)
    return [
        {"name": name, "unit": unit, "value": float(value), "std": float(std)}
        for (name, unit), value, std in zip(
            shown.units.items(), shown.values, content.deviations, strict=True
        )
    ]


def _correlations(content: Content) -> list[tuple[str, list[float]]]:
    """Correlations of the parameters that the logs determine."""
    shown = parameters_shown(content.found)
    known = np.flatnonzero(np.isfinite(np.diag(shown.covariance)))
    names = [name for place, name in enumerate(shown.units) if place in known]
    rows = correlation_matrix(shown.covariance[np.ix_(known, known)])
    return [(name, row.tolist()) for name, row in zip(names, rows, strict=True)]
