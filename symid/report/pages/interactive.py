"""Plots of a diagnosis that can be zoomed: force, error and motion over time, error over motion and frequency, Bode."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from bokeh.embed import components
from bokeh.models.annotations.geometry import BoxAnnotation, Span
from bokeh.models.plots import GridPlot
from bokeh.models.sources import ColumnDataSource
from bokeh.models.tools import HoverTool
from bokeh.plotting import figure
from bokeh.resources import Resources

from symid.arrays import BoolArray, FloatArray
from symid.axis import length_unit
from symid.diagnosis import Diagnosis
from symid.report.figures.binned_means import Means, means_over
from symid.report.figures.colours import EXPLAINED, INK, MEASURED, MODEL, NOISE, NOMINAL, PAPER
from symid.report.figures.drawn import seen_range
from symid.report.figures.envelope import envelope, envelope_places
from symid.report.pages.page_bode import bode_plots
from symid.report.pages.page_plots import (
    Curve,
    add_legend,
    draw_curves,
    new_plot,
    noise_band,
    stacked,
    with_one_crosshair,
)
from symid.units import Unit

_MOST_POINTS = 6_000


@dataclass(frozen=True)
class Plots:
    """Plots as pieces of a page."""

    script: str  # the plotting library and the calls that draw, in JavaScript
    # signals, over_velocity, over_position, spectrum: where it draws
    signals: str
    over_velocity: str
    over_position: str
    spectrum: str
    # where it draws the frequency response of each sensor; none where the log does not excite the axis
    responses: Mapping[str, str]
    others: Mapping[str, str]  # where it draws the signals of further drives


def plots_of(diagnosis: Diagnosis) -> Plots:
    """Plots of the signals, the error and the frequency responses, with all that they need."""
    library = Resources(mode="inline", components=["bokeh"]).js_raw
    over_velocity, over_position = error_maps(diagnosis)
    fixed = {
        "signals": _over_time(diagnosis),
        "over_velocity": over_velocity,
        "over_position": over_position,
        "spectrum": _spectrum(diagnosis),
    }
    others = {
        drive.gap.signal: _over_time(
            replace(diagnosis, gap=drive.gap, signals=drive.signals, spectrum=drive.spectrum)
        )
        for drive in diagnosis.drives
        if drive.gap.signal != diagnosis.gap.signal
    }
    drawing, places = components({**fixed, **others, **bode_plots(diagnosis)}, wrap_script=False)
    responses = {name: place for name, place in places.items() if name not in {**fixed, **others}}
    drawn = {name: places[name] for name in fixed}
    further = {name: places[name] for name in others}
    return Plots("\n".join([*library, drawing]), **drawn, responses=responses, others=further)


def _over_time(diagnosis: Diagnosis) -> GridPlot:
    """Force, error, position and velocity below each other with one time; values follow the time that is shown."""
    source, gap, length = _thinned(diagnosis), diagnosis.gap, length_unit(diagnosis.drive.at)
    curves = _curves(diagnosis)
    force = new_plot("force", f"{gap.signal} [{gap.unit}]", 320, window_axis="x")
    draw_curves(force, source, curves)
    error = new_plot("error", f"error [{gap.unit}]", 210, force, window_axis="x")
    errors = [replace(curve, column=f"error_{curve.column}") for curve in _compared(curves)]
    draw_curves(error, source, errors)
    error.add_layout(noise_band(2 * gap.noise_floor.rms))
    position = new_plot("position", f"position [{length}]", 130, force, window_axis="x")
    draw_curves(position, source, [Curve("position", "", NOISE)])
    velocity = new_plot("velocity", f"velocity [{length / Unit.of('s')}]", 155, force, window_axis="x")
    draw_curves(velocity, source, [Curve("velocity", "", NOISE)])
    velocity.xaxis.axis_label = "time [s]"
    with_one_crosshair(force, error, position, velocity)
    first: Any = force.select_one({"name": "measured"})
    values = [(curve.label, f"@{curve.column}{{0.00}}") for curve in curves]
    tips = [("time", "@time{0.0000} s"), *values]
    force.add_tools(HoverTool(mode="vline", renderers=[first], tooltips=tips))  # at the cross-hair
    return stacked(force, error, position, velocity)


def _curves(diagnosis: Diagnosis) -> list[Curve]:
    """Measured force, and the force of each available model."""
    curves = [
        Curve("measured", "measured", MEASURED, 3.4),
        Curve("nominal", "nominal values", NOMINAL),
        Curve("reidentified", "re-identified", MODEL),
    ]
    if not np.isfinite(diagnosis.signals.nominal).any():
        del curves[1]
    return [*curves, *([Curve("explained", "with effects", EXPLAINED)] if diagnosis.effects else [])]


def _compared(curves: list[Curve]) -> list[Curve]:
    """Curves whose error is drawn: that of the nominal values would dwarf the others."""
    return [curve for curve in curves if curve.column in ("reidentified", "explained")]


def _thinned(diagnosis: Diagnosis) -> ColumnDataSource:
    """Columns of the plots over time; errors only where samples are part of the gap.

    Predictions at the ends of a log far beyond the measured range are left out: they would dwarf the rest.
    """
    signals = diagnosis.signals
    columns = {name: getattr(signals, name) for name in ("measured", "position", "velocity")}
    low, high = np.nanmin(signals.measured), np.nanmax(signals.measured)
    margin = 0.5 * (high - low)
    for name in ("nominal", "reidentified", "explained"):
        force = getattr(signals, name)
        credible = signals.compared | ((force > low - margin) & (force < high + margin))
        columns[name] = np.where(credible, force, np.nan)
        columns[f"error_{name}"] = np.where(signals.compared, signals.measured - force, np.nan)
    del columns["error_nominal"]
    thin = {name: envelope(values, _MOST_POINTS).astype(np.float32) for name, values in columns.items()}
    return ColumnDataSource({"time": envelope_places(signals.time, _MOST_POINTS), **thin})


def _spectrum(diagnosis: Diagnosis) -> GridPlot:
    """Densities of the error of both models against that of the noise, up to the band of the gap and beyond it."""
    density, gap = diagnosis.spectrum, diagnosis.gap
    rows = density.frequency > 0
    names = ("frequency", "reidentified", "explained", "noise")
    source = ColumnDataSource({name: getattr(density, name)[rows] for name in names})
    plot = new_plot(
        "spectrum",
        f"density of the error [{gap.unit}/√Hz]",
        340,
        x_axis_type="log",
        y_axis_type="log",
        x_axis_label="frequency [Hz]",
    )
    draw_curves(
        plot, source, [*_compared(_curves(diagnosis)), Curve("noise", "noise", INK, 1.6)], "frequency"
    )
    plot.add_layout(BoxAnnotation(left=gap.band_hz, fill_color=NOISE, fill_alpha=0.12, level="underlay"))
    return stacked(plot)


_MOST_DOTS = 3000
_HEIGHT = 300


def error_maps(diagnosis: Diagnosis) -> tuple[GridPlot, GridPlot]:
    """Error of the re-identified model, and with the effects found, over velocity and over position.

    Dots are samples of the gap; means in bins carry twice their deviation, forward and backward motion each its own:
    friction opposes both, a force of the position does not.
    """
    signals, unit = diagnosis.signals, length_unit(diagnosis.drive.at)
    used = signals.compared & np.isfinite(signals.reidentified)
    speed, place = signals.velocity[used], signals.position[used]
    errors = {"re-identified": (MODEL, (signals.measured - signals.reidentified)[used])}
    if diagnosis.effects:
        errors["with effects"] = (EXPLAINED, (signals.measured - signals.explained)[used])
    ways = (speed > 0, speed < 0)
    over_velocity = _map(diagnosis, "velocity", speed, errors, ways)
    over_velocity.xaxis.axis_label = f"velocity [{unit / Unit.of('s')}]"
    over_position = _map(diagnosis, "position", place, errors, ways)
    over_position.xaxis.axis_label = f"position [{unit}]"
    return stacked(over_velocity), stacked(over_position)


def _map(
    diagnosis: Diagnosis,
    name: str,
    x: FloatArray,
    errors: dict[str, tuple[str, FloatArray]],
    ways: tuple[BoolArray, BoolArray],
) -> figure:
    """Errors over a signal, with means forward and backward."""
    means = {label: [means_over(x[way], error[way]) for way in ways] for label, (_, error) in errors.items()}
    all_errors = np.concatenate([error for _, error in errors.values()])
    seen = seen_range(all_errors, *(one for both in means.values() for one in both))
    plot = new_plot(f"error over {name}", f"error [{diagnosis.gap.unit}]", _HEIGHT, y_range=seen)
    some = np.random.default_rng(0).permutation(x.size)[:_MOST_DOTS]
    items: dict[str, list[Any]] = {}
    for label, (colour, error) in errors.items():
        dots = ColumnDataSource({"x": x[some].astype(np.float32), "y": error[some].astype(np.float32)})
        items[label] = [plot.scatter("x", "y", source=dots, size=2, color=colour, alpha=0.3)]
    for label, (colour, _) in errors.items():
        for one, fill in zip(means[label], (colour, PAPER), strict=True):
            items[label] += _means(plot, one, colour, fill)
    plot.add_layout(noise_band(2 * diagnosis.gap.noise_floor.rms))
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
