"""Correlation of a residual with itself and with the prediction, by lag."""

from __future__ import annotations

import matplotlib as mpl

from symid.identification import Identification
from symid.identification.residual_correlation import residual_correlations
from symid.report.figures.colours import LIGHT, Palette
from symid.report.figures.drawn import Drawn


def correlation_figure(found: Identification, palette: Palette = LIGHT) -> Drawn | None:
    """Both correlations of each part with their bands; None where there are too few rows."""
    parts = residual_correlations(found)
    if not parts:
        return None
    with mpl.rc_context(palette.style):
        figure = Drawn(figsize=(11, 2.6 * len(parts)), layout="constrained")
        rows = figure.subplots(len(parts), 2, squeeze=False)
        for (title, *both), row in zip(parts, rows, strict=True):
            for axes, one, what in zip(row, both, ("with itself", "with the prediction"), strict=True):
                axes.fill_between(one.lag, -one.band, one.band, color=palette.fill, label="99 % if white")
                axes.vlines(one.lag, 0, one.value, color=palette.model, linewidth=1.2)
                axes.axhline(0.0, color=palette.ink, linewidth=0.6)
                axes.set_ylim(-1.05, 1.05)
                axes.set_xlabel("lag [rows]")
                axes.set_ylabel(f"residual {what}")
            row[0].set_title(title, loc="left")
            row[0].legend(loc="upper right", frameon=False)
    return figure
