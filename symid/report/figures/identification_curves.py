"""Curves of an identification: outputs of each log, frequency responses and their bands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np

from symid.axis import Axis
from symid.data import Log
from symid.data.sensor_motion import SensorMotion
from symid.errors import SettingError
from symid.identification import Identification, OutputPrediction
from symid.report.figures.ellipses import ShownParameters
from symid.report.figures.panels import Panel
from symid.simulation.frequency_response import FrequencyResponse, has_response, response_of
from symid.simulation.response_band import ResponseBand, response_band
from symid.text import visible

if TYPE_CHECKING:
    from symid.output_error import OutputErrorIdentification, OutputErrorPrediction

_MOST_RESPONSES = 2


@dataclass(frozen=True, eq=False)
class IdentificationCurves:
    """Curves that the figures of an identification show."""

    panels: tuple[Panel, ...]  # for each output of each log
    # of the first sensors to the only drive; none without the axis, or where it is not known well enough
    responses: tuple[tuple[FrequencyResponse, ResponseBand], ...]


def identification_curves(
    found: Identification | OutputErrorIdentification,
    validation: OutputPrediction | OutputErrorPrediction | None = None,
    *,
    axis: Axis | None,
    runs: Sequence[Log],
) -> IdentificationCurves:
    """Curves of an identification; the log of the validation is the last of `runs`.

    Without a validation, axis and logs are those that the result keeps.
    """
    if axis is None and validation is None:
        axis, runs = found.axis, found.runs if isinstance(found, Identification) else found.logs
    panels = (
        _panels_of_equations(found, cast("OutputPrediction | None", validation))
        if isinstance(found, Identification)
        else _panels_of_readings(found, cast("OutputErrorPrediction | None", validation))
    )
    if axis is not None and runs:
        each = len(panels) // len(runs)  # panels of one log
        motions = [motion for run in runs for motion in [SensorMotion.of(axis, run)] * each]
        panels = [replace(panel, motion=motion) for panel, motion in zip(panels, motions, strict=True)]
    return IdentificationCurves(tuple(panels), tuple(_responses(found, axis, runs)))


def parameters_shown(found: Identification | OutputErrorIdentification) -> ShownParameters:
    """The physical parameters, or the minimal ones if there are none."""
    model = found.model
    if not isinstance(found, Identification):
        values = np.array(list(found.physical_parameters.values()))
        return ShownParameters(model.physical_units, values, found.physical_covariance(corrected=True))
    if not found.physical:
        return ShownParameters(model.minimal_units, found.fit.parameters, found.covariance)
    first = found.physical[0]
    covariance = first.sensitivity @ found.covariance @ first.sensitivity.T
    return ShownParameters(model.physical_units, first.parameters, covariance)


def _responses(
    found: Identification | OutputErrorIdentification, axis: Axis | None, runs: Sequence[Log]
) -> list[tuple[FrequencyResponse, ResponseBand]]:
    values = found.physical_parameters
    if axis is None or len(axis.drives) > 1 or not runs or not has_response(axis, values):
        return []
    late, covariance = None, parameters_shown(found).covariance
    if isinstance(found, Identification):
        late, deviations = found.observations[0].preparation.late, found.physical_deviations
    else:
        deviations = np.sqrt(np.diag(covariance))
    identified, signals = runs[: len(found.logs)], found.model.measured[:_MOST_RESPONSES]
    responses = [response_of(axis, values, signal, identified, late) for signal in signals]
    return [(one, response_band(axis, values, deviations, covariance, one)) for one in responses]


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
