"""Correlation of a residual with itself and with the prediction, by lag."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib as mpl

from symid.identification.residual_correlation import OutputCorrelations
from symid.report.figures.colours import LIGHT
from symid.report.figures.drawn import Drawn


def correlation_figure(parts: Sequence[OutputCorrelations], *, narrow: bool) -> Drawn | None:
    """Auto- and cross-correlation of each part, by its title, with their bands; None where there are no parts.

    Both stand side by side, or below each other if `narrow`.
    """
    if not parts:
        return None
    with mpl.rc_context(LIGHT.style):
        width, across = (4.2, 1) if narrow else (11.0, 2)
        figure = Drawn(figsize=(width, 2.6 * len(parts) * 2 / across), layout="constrained")
        rows = figure.subplots(len(parts) * 2 // across, across, squeeze=False).reshape(len(parts), 2)
        for (title, *both), row in zip(parts, rows, strict=True):
            for axes, one, what in zip(row, both, ("with itself", "with the prediction"), strict=True):
                low, high = one.of_noise - one.band, one.of_noise + one.band
                axes.fill_between(one.lag, low, high, color=LIGHT.fill, label="99 % of noise alone")
                axes.vlines(one.lag, 0, one.value, color=LIGHT.model, linewidth=1.2)
                axes.axhline(0.0, color=LIGHT.ink, linewidth=0.6)
                axes.set_ylim(-1.05, 1.05)
                axes.set_xlabel("lag [rows]")
                axes.set_ylabel(f"residual {what}")
            row[0].set_title(title, loc="left")
            row[0].legend(loc="upper right", frameon=False)
    return figure
