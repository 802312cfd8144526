"""Figures of an identification: model and measurement over time, residual over motion and frequency, Bode, ellipses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import matplotlib as mpl
import numpy as np

from symid.arrays import ComplexArray, FloatArray
from symid.axis import Axis
from symid.data import Log
from symid.data.sensor_motion import SensorMotion
from symid.errors import SettingError
from symid.identification import Identification, OutputPrediction
from symid.report.figures.bode import correlated_pairs, draw_bode, draw_ellipse
from symid.report.figures.colours import LIGHT, Palette
from symid.report.figures.drawn import Drawn
from symid.report.figures.panels import Panel, draw_panel
from symid.simulation.frequency_response import (
    FrequencyResponse,
    has_response,
    log_response_slopes,
    response_of,
)
from symid.text import visible

if TYPE_CHECKING:
    from symid.output_error import OutputErrorIdentification, OutputErrorPrediction

PLOT_STYLE: Any = LIGHT.style
_MOST_ELLIPSES, _MOST_RESPONSES = 4, 2
_PANEL, _BODE, _ELLIPSES, _WIDTH = 6.0, 5.2, 3.2, 12.0
"""Heights of a panel, of the Bode diagrams and of the ellipses, and width, in inches."""


def identification_figure(
    found: Identification | OutputErrorIdentification,
    validation: OutputPrediction | OutputErrorPrediction | None = None,
    *,
    axis: Axis | None = None,
    runs: Sequence[Log] = (),
    palette: Palette = LIGHT,
) -> Drawn:
    """Figure of an identification.

    For each output of each log: measured and predicted output over time and against each other, the residual over
    time, velocity, position and frequency. With the axis and its logs, that of the validation last: the frequency
    response of the identified axis beside the measured one. Parameters that are correlated get confidence ellipses.
    """
    panels = (
        _panels_of_equations(found, cast("OutputPrediction | None", validation))
        if isinstance(found, Identification)
        else _panels_of_readings(found, cast("OutputErrorPrediction | None", validation))
    )
    if axis is not None and runs:
        each = len(panels) // len(runs)  # panels of one log
        motions = [motion for run in runs for motion in [SensorMotion.of(axis, run)] * each]
        panels = [replace(panel, motion=motion) for panel, motion in zip(panels, motions, strict=True)]
    responses = _responses(found, axis, runs)
    units, values, covariance = _parameters(found)
    pairs = correlated_pairs(covariance)[:_MOST_ELLIPSES]
    heights = [_PANEL] * len(panels) + [_BODE] * bool(responses) + [_ELLIPSES] * bool(pairs)
    with mpl.rc_context(palette.style):
        figure = Drawn(figsize=(_WIDTH, sum(heights)), layout="constrained")
        places: Any = figure.subfigures(len(heights), 1, height_ratios=heights, squeeze=False)[:, 0]
        for place, panel in zip(places, panels, strict=False):
            draw_panel(place, panel, palette)
        if responses:
            columns: Any = places[len(panels)].subfigures(1, len(responses), squeeze=False)[0]
            for place, response in zip(columns, responses, strict=True):
                assert axis is not None
                draw_bode(place, response, palette, response_deviation(found, axis, response))
        if pairs:
            grid: Any = places[-1].subplots(1, max(len(pairs), 3), squeeze=False)[0]
            for axes, pair in zip(grid, pairs, strict=False):
                draw_ellipse(axes, pair, values, covariance, units, palette)
            for axes in grid[len(pairs) :]:
                axes.axis("off")
            handles, labels = grid[0].get_legend_handles_labels()
            places[-1].legend(handles, labels, loc="outside upper right", ncols=3, frameon=False)
    return figure


def _responses(
    found: Identification | OutputErrorIdentification, axis: Axis | None, runs: Sequence[Log]
) -> list[FrequencyResponse]:
    """Frequency responses of the first sensors to the only drive, where the axis is known well enough."""
    if axis is None or len(axis.drives) > 1 or not runs or not has_response(axis, found.physical_parameters):
        return []
    identified, signals = runs[: len(found.logs)], found.model.measured[:_MOST_RESPONSES]
    late = found.observations[0].preparation.late if isinstance(found, Identification) else None
    return [response_of(axis, found.physical_parameters, signal, identified, late) for signal in signals]


def response_deviation(
    found: Identification | OutputErrorIdentification, axis: Axis, response: FrequencyResponse
) -> ComplexArray:
    """Deviation of the logarithm of an identified response, as `draw_bode` takes it, by the delta method.

    The deviations are those that are printed: for the noise, the scatter between parts of a log and the bias.
    """
    values = found.physical_parameters
    if isinstance(found, Identification):
        estimate, deviations = found.physical[0], found.physical_deviations
    else:
        covariance = found.physical_covariance(corrected=True)
        deviations = np.sqrt(np.diag(covariance))
    slopes = log_response_slopes(axis, values, dict(zip(values, deviations, strict=True)), response)
    both = np.concatenate([slopes.real, slopes.imag])
    if isinstance(found, Identification):
        variance = found.widened(both @ estimate.sensitivity) ** 2
        if estimate.restricted:
            variance += np.einsum("ki,ij,kj->k", both, estimate.restricted.by_prior, both)
    else:
        counts = both.any(axis=0)  # what is not determined has no covariance, which matters where it counts
        variance = np.einsum("ki,ij,kj->k", both, np.where(np.outer(counts, counts), covariance, 0.0), both)
    of_size, of_phase = np.split(np.sqrt(variance), 2)
    return np.asarray(of_size + 1j * of_phase)


def _parameters(
    found: Identification | OutputErrorIdentification,
) -> tuple[Mapping[str, str], FloatArray, FloatArray]:
    """Units by name, values and covariance: of the physical parameters, or of the minimal ones if there are none."""
    if not isinstance(found, Identification):
        values = np.array(list(found.physical_parameters.values()))
        return found.model.physical_units, values, found.physical_covariance(corrected=True)
    if not found.physical:
        return found.model.minimal_units, found.fit.parameters, found.covariance
    slopes = found.physical[0].sensitivity
    return found.model.physical_units, found.physical[0].parameters, slopes @ found.covariance @ slopes.T


def _panels_of_equations(found: Identification, validation: OutputPrediction | None) -> list[Panel]:
    runs = [(s, o, found.fit.solution) for s, o in zip(found.logs, found.observations, strict=True)]
    if validation is not None:
        runs.append((f"validation on {validation.log}", validation.observation, validation.parameters))
    several = len(found.model.output_names) > 1
    panels = []
    for source, run, parameters in runs:
        for j, (output, unit) in enumerate(found.output_units.items()):
            used, title = run.valid[j], _short(source) + (f", equation {j + 1}" if several else "")
            measured = np.where(used, run.y[j], np.nan)
            predicted = np.where(used, run.W[j] @ parameters, np.nan)
            panels.append(Panel(title, output, unit, run.time, measured, predicted))
    return panels


def _panels_of_readings(
    found: OutputErrorIdentification, validation: OutputErrorPrediction | None
) -> list[Panel]:
    if found.fit is None:
        raise SettingError(f"there is nothing to draw: {found.message}")
    runs = [(log.source, prediction) for log, prediction in zip(found.logs, found.predictions, strict=True)]
    if validation is not None:
        runs.append((f"validation on {validation.log}", validation))
    panels = []
    for source, run in runs:
        of_signals = zip(found.reading_units.items(), run.readings.T, run.innovations.T, strict=True)
        for (signal, unit), measured, innovations in of_signals:
            predicted = measured - innovations
            panels.append(Panel(_short(source), signal, unit, run.time, measured, predicted))
    return panels


def _short(source: str) -> str:
    """Name of a log without its folder."""
    *words, path = source.split(" ")
    return visible(" ".join([*words, Path(path).name]))
