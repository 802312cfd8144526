"""Curves of the figures of an identification: outputs of each log, frequency responses, ellipses of parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, cast

import numpy as np
import scipy
from matplotlib.axes import Axes

from symid.arrays import FloatArray
from symid.axis import Axis
from symid.data import Log
from symid.errors import SettingError
from symid.identification import Identification, Observation, OutputPrediction
from symid.report.figures.colours import Palette
from symid.report.figures.panels import Panel, SensorMotion
from symid.report.figures.residual_correlation import PredictedOutput
from symid.simulation.plants import FrequencyResponse, ResponseBand, has_response, response_band, response_of
from symid.text import visible

if TYPE_CHECKING:
    from symid.output_error import OutputErrorIdentification, OutputErrorPrediction

_MOST_RESPONSES = 2


@dataclass(frozen=True, eq=False)
class ShownLog:
    """A log with its outputs as measured and as predicted, by equations of the motion or by maximum likelihood."""

    title: str  # its source, with a remark if the parameters come from other logs
    heading: str  # the same for a diagram, without the folder
    time: FloatArray
    late: Mapping[str, float]  # times by which its signals are taken as recorded late, s
    outputs: tuple[PredictedOutput, ...]


@dataclass(frozen=True, eq=False)
class IdentificationCurves:
    """Curves that the figures of an identification show."""

    axis: Axis | None
    runs: tuple[Log, ...]  # the logs as they were recorded, where they are known
    logs: tuple[ShownLog, ...]  # that of the validation is the last
    panels: tuple[Panel, ...]  # for each output of each log
    # of the first sensors to the only drive; none without the axis, or where it is not known well enough
    responses: tuple[tuple[FrequencyResponse, ResponseBand], ...]


def identification_curves(
    result: Identification | OutputErrorIdentification,
    validation: OutputPrediction | OutputErrorPrediction | None = None,
    *,
    axis: Axis | None,
    runs: Sequence[Log],
) -> IdentificationCurves:
    """Curves of an identification; the log of the validation is the last of `runs`.

    Without a validation, axis and logs are those that the result keeps.
    """
    if axis is None and validation is None:
        axis, runs = result.axis, result.runs if isinstance(result, Identification) else result.logs
    logs = _logs(result, validation)
    motions = (
        [SensorMotion.of(axis, run) for run in runs] if axis is not None and runs else [None] * len(logs)
    )
    panels = [
        _panel(log, j, motion, by_equations=isinstance(result, Identification))
        for log, motion in zip(logs, motions, strict=True)
        for j in range(len(log.outputs))
    ]
    return IdentificationCurves(
        axis, tuple(runs), tuple(logs), tuple(panels), tuple(_responses(result, axis, runs))
    )


def _logs(
    result: Identification | OutputErrorIdentification,
    validation: OutputPrediction | OutputErrorPrediction | None,
) -> list[ShownLog]:
    sources = [log if isinstance(log, str) else log.source for log in result.logs]
    titles = [(source, _short(source)) for source in sources]
    if validation is not None:
        titles.append((f"{validation.log} (validation)", _short(f"validation on {validation.log}")))
    if isinstance(result, Identification):
        seen = [(run, result.fit.solution) for run in result.observations]
        if validation is not None:
            prediction = cast("OutputPrediction", validation)
            seen.append((prediction.observation, prediction.parameters))
        pairs = zip(titles, seen, strict=True)
        return [_of_equations(title, *run, result.output_units) for title, run in pairs]
    if result.fit is None:
        raise SettingError(f"there is nothing to draw: {result.message}")
    delays = {drive.signal: result.late for drive in result.axis.drives}
    others = [] if validation is None else [cast("OutputErrorPrediction", validation)]
    predicted = zip(titles, [*result.predictions, *others], strict=True)
    return [_of_readings(title, run, result.reading_units, delays) for title, run in predicted]


def _of_equations(
    title: tuple[str, str], seen: Observation, parameters: FloatArray, units: Mapping[str, str]
) -> ShownLog:
    outputs = (
        PredictedOutput(name, title[0], unit, seen.y[j], seen.W[j] @ parameters, seen.valid[j])
        for j, (name, unit) in enumerate(units.items())
    )
    return ShownLog(*title, seen.time, seen.preparation.late, tuple(outputs))


def _of_readings(
    title: tuple[str, str], run: OutputErrorPrediction, units: Mapping[str, str], late: Mapping[str, float]
) -> ShownLog:
    of_readings = zip(units.items(), run.readings.T, run.innovations.T, strict=True)
    outputs = (
        PredictedOutput(name, title[0], unit, read, read - np.nan_to_num(errors), np.isfinite(errors))
        for (name, unit), read, errors in of_readings
    )
    return ShownLog(*title, run.time, late, tuple(outputs))


def _panel(log: ShownLog, place: int, motion: SensorMotion | None, *, by_equations: bool) -> Panel:
    output = log.outputs[place]
    which = f", equation {place + 1}" if by_equations and len(log.outputs) > 1 else ""
    measured, predicted = (
        np.where(output.used, curve, np.nan) for curve in (output.measured, output.predicted)
    )
    return Panel(log.heading + which, output.name, output.unit, log.time, measured, predicted, motion)


def parameters_shown(result: Identification | OutputErrorIdentification) -> ShownParameters:
    """The physical parameters, or the minimal ones if there are none."""
    model = result.model
    if not isinstance(result, Identification):
        values, covariance = (
            list(result.physical_parameters.values()),
            result.physical_covariance(corrected=True),
        )
        return ShownParameters(model.physical_units, np.array(values), covariance, result.physical_deviations)
    if not result.physical:
        alone = result.fit.parameters, result.covariance, result.standard_deviations
        return ShownParameters(model.minimal_units, *alone)
    first = result.physical[0]
    covariance = first.sensitivity @ result.covariance @ first.sensitivity.T
    return ShownParameters(model.physical_units, first.parameters, covariance, result.physical_deviations)


def _responses(
    result: Identification | OutputErrorIdentification, axis: Axis | None, runs: Sequence[Log]
) -> list[tuple[FrequencyResponse, ResponseBand]]:
    values, of = result.physical_parameters, parameters_shown(result)
    if axis is None or len(axis.drives) > 1 or not runs or not has_response(axis, values):
        return []
    late = result.observations[0].preparation.late if isinstance(result, Identification) else None
    identified, signals = runs[: len(result.logs)], result.model.measured[:_MOST_RESPONSES]
    responses = [response_of(axis, values, signal, identified, late) for signal in signals]
    return [
        (response, response_band(axis, values, of.deviations, of.covariance, response))
        for response in responses
    ]


def _short(source: str) -> str:
    """Name of a log without its folder."""
    *words, path = source.split(" ")
    return visible(" ".join([*words, Path(path).name]))


CORRELATED = 0.5
"""Absolute correlation beyond which two parameters get an ellipse."""


class ShownParameters(NamedTuple):
    """Parameters of a result as its figures and pages show them."""

    units: Mapping[str, str]  # by name
    values: FloatArray
    covariance: FloatArray
    deviations: FloatArray  # as they are printed


class CorrelatedPair(NamedTuple):
    """Indices of two parameters, and their correlation."""

    first: int
    second: int
    correlation: float


def correlated_pairs(covariance: FloatArray) -> list[CorrelatedPair]:
    """Pairs of parameters whose correlation exceeds `CORRELATED` in size, the strongest first.

    >>> correlated_pairs(np.array([[1.0, 0.9, 0.1], [0.9, 1.0, -0.6], [0.1, -0.6, 1.0]]))[1]
    CorrelatedPair(first=1, second=2, correlation=-0.6)
    """
    deviations = np.sqrt(np.diag(covariance))
    pairs = [
        CorrelatedPair(i, j, float(covariance[i, j] / (deviations[i] * deviations[j])))
        for i, j in combinations(range(len(covariance)), 2)
        if deviations[i] > 0 and deviations[j] > 0
    ]
    strong = (pair for pair in pairs if abs(pair.correlation) > CORRELATED)
    return sorted(strong, key=lambda pair: -abs(pair.correlation))


def draw_ellipse(axes: Axes, pair: CorrelatedPair, of: ShownParameters, palette: Palette) -> None:
    """Regions that hold both parameters with a probability of 68 % and 95 %, and the deviations of each alone."""
    i, j, rho = pair
    names = list(of.units)
    part = of.covariance[np.ix_((i, j), (i, j))]
    # in percent of the value where it is not 0
    percent = [100.0 / abs(of.values[k]) if of.values[k] else 1.0 for k in (i, j)]
    deviations = np.array(percent) * np.sqrt(np.diag(part))
    spread, directions = np.linalg.eigh(part / np.sqrt(np.outer(np.diag(part), np.diag(part))))
    turn = np.linspace(0, 2 * np.pi, 181)
    for level, style in ((0.95, "-"), (0.68, "--")):
        radii = np.sqrt(scipy.special.chdtri(2, 1 - level) * np.maximum(spread, 0.0))
        outline = directions @ (radii[:, None] * np.array([np.cos(turn), np.sin(turn)]))
        x, y = deviations[:, None] * outline
        axes.fill(x, y, facecolor=palette.fill, edgecolor="none", alpha=0.6)
        axes.plot(x, y, color=palette.model, linewidth=1.3, linestyle=style, label=f"{level:.0%} together")
    x_alone, y_alone = deviations[:1], deviations[1:]
    axes.errorbar(0.0, 0.0, y_alone, x_alone, color=palette.ink, capsize=2, linewidth=0.9, label="each alone")
    axes.set_xlabel(_label(names[i], of.values[i], of.units[names[i]]))
    axes.set_ylabel(_label(names[j], of.values[j], of.units[names[j]]))
    axes.set_title(f"{names[i]}, {names[j]}: correlation {rho:+.2f}".replace("-", "−"), loc="left")
    axes.locator_params(nbins=5)


def _label(name: str, value: float, unit: str) -> str:
    return f"{name} [% of {abs(value):.4g} {unit}]" if value else f"{name} [{unit}]"
