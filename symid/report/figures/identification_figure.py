"""Figures of an identification: model and measurement over time, residual over motion and frequency, Bode, ellipses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import matplotlib as mpl

from symid.axis import Axis
from symid.data import Log
from symid.identification import Identification, OutputPrediction
from symid.report.figures.bode import correlated_pairs, draw_bode, draw_ellipse
from symid.report.figures.colours import LIGHT, Palette
from symid.report.figures.drawn import Drawn
from symid.report.figures.identification_curves import (
    IdentificationCurves,
    identification_curves,
    parameters_shown,
)
from symid.report.figures.panels import draw_panel

if TYPE_CHECKING:
    from symid.output_error import OutputErrorIdentification, OutputErrorPrediction

PLOT_STYLE: Any = LIGHT.style
_MOST_ELLIPSES = 4
_PANEL, _BODE, _ELLIPSES, _WIDTH = 6.0, 5.2, 3.2, 12.0
"""Heights of a panel, of the Bode diagrams and of the ellipses, and width, in inches."""


def identification_figure(
    found: Identification | OutputErrorIdentification,
    validation: OutputPrediction | OutputErrorPrediction | None = None,
    *,
    axis: Axis | None = None,
    runs: Sequence[Log] = (),
    palette: Palette = LIGHT,
    curves: IdentificationCurves | None = None,
) -> Drawn:
    """Figure of an identification, of its curves if they are known already.

    For each output of each log: measured and predicted output over time and against each other, the residual over
    time, velocity, position and frequency. With the axis and its logs, that of the validation last: the frequency
    response of the identified axis beside the measured one. Parameters that are correlated get confidence ellipses.
    """
    curves = curves or identification_curves(found, validation, axis=axis, runs=runs)
    panels, responses = curves.panels, curves.responses
    units, values, covariance = parameters_shown(found)
    pairs = correlated_pairs(covariance)[:_MOST_ELLIPSES]
    heights = [_PANEL] * len(panels) + [_BODE] * bool(responses) + [_ELLIPSES] * bool(pairs)
    with mpl.rc_context(palette.style):
        figure = Drawn(figsize=(_WIDTH, sum(heights)), layout="constrained")
        places: Any = figure.subfigures(len(heights), 1, height_ratios=heights, squeeze=False)[:, 0]
        for place, panel in zip(places, panels, strict=False):
            draw_panel(place, panel, palette)
        if responses:
            columns: Any = places[len(panels)].subfigures(1, len(responses), squeeze=False)[0]
            for place, (response, band) in zip(columns, responses, strict=True):
                draw_bode(place, response, palette, band)
        if pairs:
            grid: Any = places[-1].subplots(1, max(len(pairs), 3), squeeze=False)[0]
            for axes, pair in zip(grid, pairs, strict=False):
                draw_ellipse(axes, pair, values, covariance, units, palette)
            for axes in grid[len(pairs) :]:
                axes.axis("off")
            handles, labels = grid[0].get_legend_handles_labels()
            places[-1].legend(handles, labels, loc="outside upper right", ncols=3, frameon=False)
    return figure
