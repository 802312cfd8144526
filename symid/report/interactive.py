"""Plots of a diagnosis that can be zoomed: force, its error, motion over time, and the spectrum of the error."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from bokeh.core.properties import value
from bokeh.embed import components
from bokeh.layouts import gridplot
from bokeh.models.annotations.geometry import BoxAnnotation, Span
from bokeh.models.annotations.legends import Legend, LegendItem
from bokeh.models.plots import GridPlot
from bokeh.models.sources import ColumnDataSource
from bokeh.models.tools import (
    BoxZoomTool,
    CrosshairTool,
    HoverTool,
    PanTool,
    ResetTool,
    SaveTool,
    WheelZoomTool,
)
from bokeh.plotting import figure
from bokeh.resources import Resources

from symid.axis.axis import length_unit
from symid.diagnosis.result import Diagnosis
from symid.report.colours import EXPLAINED, INK, MEASURED, MODEL, NOISE, NOMINAL
from symid.report.thinning import envelope, envelope_places
from symid.units import Unit

_MOST_POINTS = 20_000
_LEFT = 82
"""Room for the numbers beside an axis in pixels, the same in all plots so that their times are in line."""


@dataclass(frozen=True)
class Plots:
    """Plots as pieces of a page.

    Parameters
    ----------
    library : str
        Script of the plotting library.
    script : str
        Script that draws.
    signals, spectrum : str
        Where it draws.
    """

    library: str
    script: str
    signals: str
    spectrum: str


@dataclass(frozen=True)
class _Curve:
    """How a column is drawn."""

    column: str
    label: str
    colour: str
    width: float = 1.1


def plots_of(found: Diagnosis) -> Plots:
    """Plots of the signals and of the spectrum, with all that they need."""
    library = Resources(mode="inline", components=["bokeh"]).render_js()
    script, places = components({"signals": _over_time(found), "spectrum": _spectrum(found)})
    return Plots(library, script, places["signals"], places["spectrum"])


def _over_time(found: Diagnosis) -> GridPlot:
    """Force, error, position and velocity below each other with one time."""
    source, gap, length = _thinned(found), found.gap, length_unit(found.axis.drive.at)
    curves = _curves(found)
    force = _figure("force", f"{gap.signal} [{gap.unit}]", 320)
    _draw(force, source, curves)
    error = _figure("error", f"error [{gap.unit}]", 210, force)
    _draw(error, source, [replace(curve, column=f"error_{curve.column}") for curve in _compared(curves)])
    error.add_layout(_noise_band(2 * gap.noise_floor.rms))
    position = _figure("position", f"position [{length}]", 130, force)
    _draw(position, source, [_Curve("position", "", NOISE)])
    velocity = _figure("velocity", f"velocity [{length / Unit.of('s')}]", 155, force)
    _draw(velocity, source, [_Curve("velocity", "", NOISE)])
    velocity.xaxis.axis_label = "time [s]"
    _link(force, error, position, velocity)
    force.add_tools(_reading(force, curves))
    return _stacked(force, error, position, velocity)


def _stacked(*plots: figure) -> GridPlot:
    """Plots below each other, as wide as the page, with one toolbar."""
    rows: list[list[Any]] = [[plot] for plot in plots]
    return gridplot(rows, sizing_mode="stretch_width", toolbar_options={"logo": None})


def _curves(found: Diagnosis) -> list[_Curve]:
    """Measured force, and that of each model that there is; where no effect was found, none with effects."""
    curves = [
        _Curve("measured", "measured", MEASURED, 3.4),
        _Curve("nominal", "nominal values", NOMINAL),
        _Curve("reidentified", "re-identified", MODEL),
    ]
    if not np.isfinite(found.signals.nominal).any():
        del curves[1]
    return [*curves, *([_Curve("explained", "with effects", EXPLAINED)] if found.effects else [])]


def _compared(curves: list[_Curve]) -> list[_Curve]:
    """Curves whose error is drawn: that of the nominal values would dwarf the others."""
    return [curve for curve in curves if curve.column in ("reidentified", "explained")]


def _thinned(found: Diagnosis) -> ColumnDataSource:
    """Columns of the plots over time; errors only where samples are part of the gap."""
    signals, columns = found.signals, {}
    for name in ("measured", "nominal", "reidentified", "explained", "position", "velocity"):
        columns[name] = getattr(signals, name)
    for name in ("reidentified", "explained"):
        error = signals.measured - columns[name]
        columns[f"error_{name}"] = np.where(signals.compared, error, np.nan)
    thin = {name: envelope(values, _MOST_POINTS).astype(np.float32) for name, values in columns.items()}
    return ColumnDataSource({"time": envelope_places(signals.time, _MOST_POINTS), **thin})


def _figure(name: str, label: str, height: int, above: figure | None = None) -> figure:
    """An empty plot; those below another share its time, and their values follow the time that is shown."""
    plot = figure(
        name=f"plot of {name}",
        height=height,
        tools=[],
        min_border_left=_LEFT,
        window_axis="x",
        lod_threshold=None,
    )
    if above is not None:
        plot.x_range = above.x_range
    zoom = BoxZoomTool(dimensions="width")
    wheel = WheelZoomTool(dimensions="width", modifiers="ctrl")
    plot.add_tools(zoom, wheel, PanTool(), ResetTool(), SaveTool())
    plot.toolbar.active_drag, plot.toolbar.active_scroll = zoom, wheel
    plot.yaxis.axis_label = label
    _style(plot)
    return plot


def _style(plot: figure) -> None:
    plot.outline_line_color = None
    plot.axis.axis_label_text_font_style = "normal"
    plot.axis.axis_label_text_color = plot.axis.major_label_text_color = INK
    plot.axis.minor_tick_line_color = None
    plot.grid.grid_line_color = "#E5E5E5"


def _draw(plot: figure, source: ColumnDataSource, curves: list[_Curve], x: str = "time") -> None:
    """Draw columns, and a legend of those that have a label: a click hides a curve."""
    items = []
    for curve in curves:
        line: Any = plot.line(
            x, curve.column, source=source, name=curve.column, color=curve.colour, line_width=curve.width
        )
        if curve.label:
            items.append(LegendItem(label=value(curve.label), renderers=[line]))
    if items:
        legend = Legend(items=items, orientation="horizontal", click_policy="hide", margin=4, spacing=16)
        legend.border_line_color, legend.label_text_color = None, INK
        plot.add_layout(legend, "above")


def _noise_band(limit: float) -> BoxAnnotation:
    return BoxAnnotation(bottom=-limit, top=limit, fill_color=NOISE, fill_alpha=0.2, level="underlay")


def _link(*plots: figure) -> None:
    """One cross-hair through all plots; only the lowest one has numbers below its axis."""
    here = Span(dimension="height", line_color="#999999", line_width=1)
    for plot in plots:
        plot.add_tools(CrosshairTool(overlay=here))
    for plot in plots[:-1]:
        plot.xaxis.visible = False


def _reading(force: figure, curves: list[_Curve]) -> HoverTool:
    """Values at the cross-hair."""
    first: Any = force.select_one({"name": "measured"})
    values = [(curve.label, f"@{curve.column}{{0.00}}") for curve in curves]
    return HoverTool(mode="vline", renderers=[first], tooltips=[("time", "@time{0.0000} s"), *values])


def _spectrum(found: Diagnosis) -> GridPlot:
    """Densities of the error of both models against that of the noise, up to the band of the gap and beyond it."""
    density, gap = found.spectrum, found.gap
    rows = density.frequency > 0
    names = ("frequency", "reidentified", "explained", "noise")
    source = ColumnDataSource({name: getattr(density, name)[rows] for name in names})
    plot = figure(
        name="plot of spectrum",
        height=340,
        x_axis_type="log",
        y_axis_type="log",
        tools="box_zoom,pan,reset,save",
        active_drag="box_zoom",
        min_border_left=_LEFT,
        x_axis_label="frequency [Hz]",
        y_axis_label=f"density of the error [{gap.unit}/√Hz]",
    )
    _style(plot)
    _draw(plot, source, [*_compared(_curves(found)), _Curve("noise", "noise", INK, 1.6)], "frequency")
    plot.add_layout(BoxAnnotation(left=gap.band_hz, fill_color=NOISE, fill_alpha=0.12, level="underlay"))
    return _stacked(plot)
