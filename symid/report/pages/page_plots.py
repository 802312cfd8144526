"""Common parts of the plots of a page: tools, axes, curves that a click hides, rows of plots with one toolbar.

They are drawn in light colours; in the dark the style of the page turns them.
"""

from dataclasses import dataclass
from typing import Any

from bokeh.core.properties import value
from bokeh.layouts import gridplot
from bokeh.models.annotations.geometry import BoxAnnotation, Span
from bokeh.models.annotations.legends import Legend, LegendItem
from bokeh.models.plots import GridPlot
from bokeh.models.sources import ColumnDataSource
from bokeh.models.tools import BoxZoomTool, CrosshairTool, PanTool, ResetTool, SaveTool, WheelZoomTool
from bokeh.plotting import figure

from symid.report.figures.colours import INK, NOISE

_LEFT = 82
"""Room for the numbers beside an axis in pixels, the same in all plots so that their times are in line."""


@dataclass(frozen=True)
class Curve:
    """Style of a curve: name in the legend (none if empty), and width of the line in pixels or size of dots."""

    column: str
    label: str
    colour: str
    width: float = 1.1
    dots: bool = False
    alpha: float = 1.0


def new_plot(name: str, label: str, height: int, above: figure | None = None, **settings: Any) -> figure:
    """An empty plot that is zoomed along its horizontal axis; it shares the range of the plot `above`."""
    plot = figure(
        name=f"plot of {name}",
        height=height,
        tools=[],
        min_border_left=_LEFT,
        lod_threshold=None,
        y_axis_label=label,
        **settings,
    )
    if above is not None:
        plot.x_range = above.x_range
    zoom = BoxZoomTool(dimensions="width")
    wheel = WheelZoomTool(dimensions="width", modifiers="ctrl")
    plot.add_tools(zoom, wheel, PanTool(), ResetTool(), SaveTool())
    plot.toolbar.active_drag, plot.toolbar.active_scroll = zoom, wheel
    plot.outline_line_color = None
    plot.axis.axis_label_text_font_style = "normal"
    plot.axis.axis_label_text_color = plot.axis.major_label_text_color = INK
    plot.axis.minor_tick_line_color = None
    plot.grid.grid_line_color = "#E5E5E5"
    return plot


def draw_curves(plot: figure, source: ColumnDataSource, curves: list[Curve], x: str = "time") -> None:
    """Draw columns, and a legend of those that have a label: a click hides a curve."""
    items: dict[str, list[Any]] = {}
    for curve in curves:
        look: Any = {"source": source, "name": curve.column, "color": curve.colour, "alpha": curve.alpha}
        drawn: Any = (
            plot.scatter(x, curve.column, size=curve.width, line_color=None, **look)
            if curve.dots
            else plot.line(x, curve.column, line_width=curve.width, **look)
        )
        if curve.label:
            items.setdefault(curve.label, []).append(drawn)
    if items:
        add_legend(plot, items)


def add_legend(plot: figure, items: dict[str, list[Any]]) -> None:
    """Names above a plot; a click on one hides its curve."""
    legend = Legend(
        items=[LegendItem(label=value(label), renderers=drawn) for label, drawn in items.items()],
        orientation="horizontal",
        ncols=2 if len(items) > 3 else "auto",  # four names are wider than a phone
        click_policy="hide",
        margin=4,
        spacing=16,
    )
    legend.border_line_color, legend.label_text_color = None, INK
    plot.add_layout(legend, "above")


def noise_band(limit: float) -> BoxAnnotation:
    """A grey band from -limit to limit."""
    return BoxAnnotation(bottom=-limit, top=limit, fill_color=NOISE, fill_alpha=0.2, level="underlay")


def stacked(*plots: figure) -> GridPlot:
    """Plots below each other, as wide as their place, with one toolbar; only the lowest has numbers below its axis."""
    for plot in plots[:-1]:
        plot.xaxis.visible = False
    rows: list[list[Any]] = [[plot] for plot in plots]
    return gridplot(rows, sizing_mode="stretch_width", toolbar_options={"logo": None})


def with_one_crosshair(*plots: figure) -> None:
    """One vertical line under the mouse through all plots."""
    here = Span(dimension="height", line_color="#999999", line_width=1)
    for plot in plots:
        plot.add_tools(CrosshairTool(overlay=here))
