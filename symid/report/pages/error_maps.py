"""The force error of a diagnosis over velocity and over position: the missing force by speed and position."""

from __future__ import annotations

from typing import Any

import numpy as np
from bokeh.models.annotations.geometry import Span
from bokeh.models.plots import GridPlot
from bokeh.models.sources import ColumnDataSource
from bokeh.plotting import figure

from symid.arrays import BoolArray, FloatArray
from symid.axis import length_unit
from symid.diagnosis.findings.diagnosis_result import Diagnosis
from symid.estimation.residual_measures import Means, means_over
from symid.report.figures.colours import EXPLAINED, INK, MODEL, PAPER
from symid.report.figures.scales import seen_range
from symid.report.pages.page_plots import add_legend, new_plot, noise_band, stacked
from symid.units import Unit

_MOST_DOTS = 3000
_HEIGHT = 300


def error_maps(found: Diagnosis) -> tuple[GridPlot, GridPlot]:
    """Error of the re-identified model, and with the effects found, over velocity and over position.

    Dots are samples of the gap; means in bins carry twice their deviation, forward and backward motion each its own:
    friction opposes both, a force of the position does not.
    """
    signals, unit = found.signals, length_unit(found.drive.at)
    used = signals.compared & np.isfinite(signals.reidentified)
    speed, place = signals.velocity[used], signals.position[used]
    errors = {"re-identified": (MODEL, (signals.measured - signals.reidentified)[used])}
    if found.effects:
        errors["with effects"] = (EXPLAINED, (signals.measured - signals.explained)[used])
    ways = (speed > 0, speed < 0)
    over_velocity = _map(found, "velocity", speed, errors, ways)
    over_velocity.xaxis.axis_label = f"velocity [{unit / Unit.of('s')}]"
    over_position = _map(found, "position", place, errors, ways)
    over_position.xaxis.axis_label = f"position [{unit}]"
    return stacked(over_velocity), stacked(over_position)


def _map(
    found: Diagnosis,
    name: str,
    x: FloatArray,
    errors: dict[str, tuple[str, FloatArray]],
    ways: tuple[BoolArray, BoolArray],
) -> figure:
    """Errors over a signal, with means forward and backward."""
    means = {label: [means_over(x[way], error[way]) for way in ways] for label, (_, error) in errors.items()}
    every = np.concatenate([error for _, error in errors.values()])
    seen = seen_range(every, *(one for both in means.values() for one in both))
    plot = new_plot(f"error over {name}", f"error [{found.gap.unit}]", _HEIGHT, y_range=seen)
    some = np.random.default_rng(0).permutation(x.size)[:_MOST_DOTS]
    items: dict[str, list[Any]] = {}
    for label, (colour, error) in errors.items():
        dots = ColumnDataSource({"x": x[some].astype(np.float32), "y": error[some].astype(np.float32)})
        items[label] = [plot.scatter("x", "y", source=dots, size=2, color=colour, alpha=0.3)]
    for label, (colour, _) in errors.items():
        for one, fill in zip(means[label], (colour, PAPER), strict=True):
            items[label] += _means(plot, one, colour, fill)
    plot.add_layout(noise_band(2 * found.gap.noise_floor.rms))
    plot.add_layout(Span(location=0.0, dimension="width", line_color=INK, line_width=0.6))
    add_legend(plot, items)
    return plot


def _means(plot: figure, means: Means, colour: str, fill: str) -> list[Any]:
    """Means with their error bars, joined by a line."""
    low, high = means.values - means.doubt, means.values + means.doubt
    source = ColumnDataSource({"x": means.places, "mean": means.values, "low": low, "high": high})
    return [
        plot.line("x", "mean", source=source, color=colour, line_width=1.4),
        plot.segment("x", "low", "x", "high", source=source, color=colour),
        plot.scatter("x", "mean", source=source, size=5.5, line_color=colour, fill_color=fill),
    ]
