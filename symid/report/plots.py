"""Figures of an identification: measured and predicted output, residual over time, velocity and frequency."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import matplotlib as mpl
import numpy as np
import scipy
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from symid.arrays import FloatArray
from symid.errors import SettingError
from symid.identification import Identification, Prediction
from symid.report.colours import MEASURED, MODEL, RESIDUAL

if TYPE_CHECKING:
    from symid.output_error import OutputErrorIdentification, OutputErrorPrediction

PLOT_STYLE: Any = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.alpha": 0.3,
}
_MOST_POINTS = 20_000


@dataclass(frozen=True, eq=False)
class Panel:
    """What is drawn of one output of one log.

    Parameters
    ----------
    title : str
        Above it.
    output, unit : str
        What is compared.
    time, measured, predicted : array of shape (n,)
        The curves; nan where nothing is compared.
    """

    title: str
    output: str
    unit: str
    time: FloatArray
    measured: FloatArray
    predicted: FloatArray


def figure_path(file: str | Path) -> Path:
    """Path of a figure; SettingError if its suffix is not that of a kind that can be drawn."""
    path = Path(file)
    if path.suffix.lower() not in (".png", ".svg", ".pdf"):
        raise SettingError(f"figure {path.name!r} is of no known kind: end its name with .png, .svg or .pdf")
    return path


def plot_identification(
    found: Identification | OutputErrorIdentification,
    file: str | Path,
    validation: Prediction | OutputErrorPrediction | None = None,
) -> None:
    """Draw an identification into a file.

    For each output: measured and predicted output over time, the residual below it, and on the right the residual
    against the predicted output and its spectrum beside that of the output. A validation log gets rows of its own.

    Parameters
    ----------
    found : Identification or OutputErrorIdentification
        What `identify` or `identify_output_error` returned.
    file : path-like
        png, svg or pdf, by its suffix.
    validation : Prediction or OutputErrorPrediction, optional
        The parameters applied to another log.

    Raises
    ------
    SettingError
        If the suffix is not known, or the parameters are not determined.
    """
    path = figure_path(file)
    panels = (
        _panels_of_equations(found, cast("Prediction | None", validation))
        if isinstance(found, Identification)
        else _panels_of_readings(found, cast("OutputErrorPrediction | None", validation))
    )
    with mpl.rc_context(PLOT_STYLE):
        figure = Figure(figsize=(11, 3.6 * len(panels)), layout="constrained")
        grids = figure.add_gridspec(len(panels), 1)
        for place, panel in enumerate(panels):
            _draw(figure, grids[place], panel)
        figure.savefig(path, dpi=150)


def _panels_of_equations(found: Identification, validation: Prediction | None) -> list[Panel]:
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
    return [
        Panel(
            _short(source),
            signal,
            unit,
            run.time,
            run.readings[:, j],
            run.readings[:, j] - run.innovations[:, j],
        )
        for source, run in runs
        for j, (signal, unit) in enumerate(found.reading_units.items())
    ]


def _draw(figure: Figure, place: Any, panel: Panel) -> None:
    grid = place.subgridspec(2, 2, width_ratios=(2.2, 1), height_ratios=(1.6, 1))
    error, used = panel.measured - panel.predicted, np.isfinite(panel.measured)
    top = figure.add_subplot(grid[0, 0])
    below = figure.add_subplot(grid[1, 0], sharex=top)
    curves = {"measured": (panel.measured, MEASURED, 2.0), "predicted": (panel.predicted, MODEL, 0.7)}
    draw_over_time(top, panel.time, curves, f"{panel.output} [{panel.unit}]")
    top.set_title(panel.title, loc="left")
    top.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, frameon=False)
    top.tick_params(labelbottom=False)
    draw_over_time(below, panel.time, {"residual": (error, RESIDUAL, 0.7)}, f"residual [{panel.unit}]")
    below.set_xlabel("time [s]")
    _draw_scatter(
        figure.add_subplot(grid[0, 1]), panel.predicted[used], error[used], panel.output, panel.unit
    )
    _draw_spectrum(figure.add_subplot(grid[1, 1]), panel.time, panel.measured, error, panel.unit)


def _short(source: str) -> str:
    """Name of a log without its folder."""
    *words, path = source.split(" ")
    return " ".join([*words, Path(path).name])


def draw_over_time(
    axes: Axes, time: FloatArray, curves: dict[str, tuple[FloatArray, str, float]], label: str
) -> None:
    """Curves over time; of long logs the envelope of each bundle of samples, so that no peak is lost."""
    for name, (values, colour, width) in curves.items():
        bundle = -(-values.size // _MOST_POINTS)
        if bundle == 1:
            axes.plot(time, values, color=colour, linewidth=width, label=name)
            continue
        whole = values.size // bundle * bundle
        parts = values[:whole].reshape(-1, bundle)
        low, high = np.fmin.reduce(parts, axis=1), np.fmax.reduce(parts, axis=1)
        axes.fill_between(time[:whole:bundle], low, high, color=colour, alpha=0.8, linewidth=0.4, label=name)
    axes.set_ylabel(label)
    axes.margins(x=0.01)


def _draw_scatter(axes: Axes, predicted: FloatArray, error: FloatArray, output: str, unit: str) -> None:
    step = -(-predicted.size // _MOST_POINTS)
    axes.plot(
        predicted[::step], error[::step], ".", color=RESIDUAL, markersize=1.5, alpha=0.4, rasterized=True
    )
    axes.set_xlabel(f"predicted {output} [{unit}]")
    axes.set_ylabel(f"residual [{unit}]")


def _draw_spectrum(axes: Axes, time: FloatArray, y: FloatArray, error: FloatArray, unit: str) -> None:
    """Amplitude densities of output and residual; rows that were left out count as zero."""
    rate = 1.0 / (time[1] - time[0])
    for values, colour, name in ((y, MEASURED, "output"), (error, RESIDUAL, "residual")):
        frequency, power = scipy.signal.welch(np.nan_to_num(values), fs=rate, nperseg=min(1024, values.size))
        axes.loglog(frequency[1:], np.sqrt(power[1:]), color=colour, linewidth=0.9, label=name)
    axes.set_xlabel("frequency [Hz]")
    axes.set_ylabel(f"{unit}/√Hz")
    axes.legend(loc="lower left", frameon=False)
