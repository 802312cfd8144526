"""Figures of an identification: model and measurement over time, residual over motion and frequency, Bode, ellipses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import matplotlib as mpl

from symid.axis import Axis
from symid.data import Log
from symid.identification import Identification, OutputPrediction
from symid.report.figures.colours import LIGHT, Palette
from symid.report.figures.drawn import Drawn, label_log_scales
from symid.report.figures.identification_curves import (
    IdentificationCurves,
    correlated_pairs,
    draw_ellipse,
    identification_curves,
    parameters_shown,
)
from symid.report.figures.panels import draw_bode, draw_panel

if TYPE_CHECKING:
    from symid.output_error import OutputErrorIdentification, OutputErrorPrediction

_MOST_ELLIPSES = 4
_PANEL, _BODE, _ELLIPSES, _WIDTH = 6.0, 5.2, 3.2, 12.0
"""Heights of a panel, of the Bode diagrams and of the ellipses, and width, in inches."""
_NARROW_PANEL, _NARROW_PANEL_IN_MOTION, _NARROW_WIDTH = 8.4, 13.0, 4.2
"""Heights of a panel without and with the motion, and width, of a figure for a phone."""


def plot_identification(
    result: Identification | OutputErrorIdentification,
    validation: OutputPrediction | OutputErrorPrediction | None = None,
    *,
    axis: Axis | None = None,
    runs: Sequence[Log] = (),
    palette: Palette = LIGHT,
    curves: IdentificationCurves | None = None,
    narrow: bool = False,
) -> Drawn:
    """Figure of an identification, of its curves if they are known already, or `narrow`, in one column of diagrams.

    For each output of each log: measured and predicted output over time and against each other, the residual over
    time, velocity, position and frequency. With the axis and its logs, that of the validation last (without one, those
    that the result keeps): the frequency response of the identified axis beside the measured one. Parameters that are
    correlated get confidence ellipses.
    """
    curves = curves or identification_curves(result, validation, axis=axis, runs=runs)
    panels, responses = curves.panels, curves.responses
    parameters = parameters_shown(result)
    pairs = correlated_pairs(parameters.covariance)[:_MOST_ELLIPSES]
    across = len(responses) if not narrow else 1
    down = -(-len(responses) // max(across, 1))
    alone, in_motion = (_NARROW_PANEL, _NARROW_PANEL_IN_MOTION) if narrow else (_PANEL, _PANEL)
    heights = [alone if panel.motion is None else in_motion for panel in panels]
    heights += [_BODE * down] * bool(responses)
    heights += [_ELLIPSES * (len(pairs) if narrow else 1)] * bool(pairs)
    with mpl.rc_context(palette.style):
        figure = Drawn(figsize=(_NARROW_WIDTH if narrow else _WIDTH, sum(heights)), layout="constrained")
        places: Any = figure.subfigures(len(heights), 1, height_ratios=heights, squeeze=False)[:, 0]
        for place, panel in zip(places, panels, strict=False):
            draw_panel(place, panel, palette, narrow=narrow)
        if responses:
            columns: Any = places[len(panels)].subfigures(down, across, squeeze=False).ravel()
            for place, (response, band) in zip(columns, responses, strict=True):
                draw_bode(place, response, palette, band)
        if pairs:
            shape = (len(pairs), 1) if narrow else (1, max(len(pairs), 3))
            grid: Any = places[-1].subplots(*shape, squeeze=False).ravel()
            for axes, pair in zip(grid, pairs, strict=False):
                draw_ellipse(axes, pair, parameters, palette)
            for axes in grid[len(pairs) :]:
                axes.axis("off")
            handles, labels = grid[0].get_legend_handles_labels()
            where = "outside upper center" if narrow else "outside upper right"
            places[-1].legend(handles, labels, loc=where, ncols=3, frameon=False)
        for axes in figure.axes:
            label_log_scales(axes)
    return figure
