"""Figures of a log, of a batch, of a diagnosis and of the correlations of a residual."""

from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes

from symid.data import Log
from symid.diagnosis import Diagnosis
from symid.diagnosis.findings import waterfall
from symid.errors import SettingError
from symid.fleet import Batch, parameter_names, without_repeats
from symid.report.figures.colours import LIGHT, Palette
from symid.report.figures.drawn import Drawn, label_log_scales, title_lines
from symid.report.figures.panels import draw_over_time
from symid.report.figures.residual_correlation import OutputCorrelations
from symid.text import visible

_WIDTH, _ROW, _NARROW_WIDTH = 10.0, 1.9, 4.2
"""In inches."""


def log_figure(log: Log, palette: Palette = LIGHT, *, narrow: bool = False) -> Drawn:
    """Each signal of a log over time, SI.

    >>> log = Log.from_arrays({"q": [0.0, 0.1], "F": [1.0, 2.0]}, sampling_period=0.5)
    >>> [axes.get_ylabel() for axes in log_figure(log).axes]
    ['q', 'F']
    """
    figure, rows = _rows(len(log.signals), palette, narrow)
    for axes, (name, values) in zip(rows, log.signals.items(), strict=True):
        draw_over_time(axes, log.time, {name: (values, palette.model, 0.9)}, name)
    rows[0].set_title(visible(log.source), loc="left")
    rows[-1].set_xlabel("time [s]")
    return figure


def batch_figure(batch: Batch, palette: Palette = LIGHT, *, narrow: bool = False) -> Drawn:
    """Each parameter over the logs that are ok, with 95 % intervals; minimal ones where they repeat nothing."""
    table = batch.table.filter(status="ok")
    drawn = []
    for axis, sets in batch.units.items():
        of_axis = table.filter(axis=axis)
        units = {name: unit for each in sets.values() for name, unit in each.items()}
        known = [n for n in parameter_names(of_axis) if n in units and of_axis[n].is_not_null().any()]
        drawn += [(axis, name, units[name]) for name in without_repeats(known, units)]
    if not drawn:
        raise SettingError("there is nothing to draw: no log of this batch is ok")
    figure, rows = _rows(len(drawn), palette, narrow)
    for axes, (axis, name, unit) in zip(rows, drawn, strict=True):
        of_axis = table.with_row_index("place").filter(axis=axis)
        width = 1.96 * of_axis[f"{name}_std"].to_numpy()
        places, values = of_axis["place"].to_numpy(), of_axis[name].to_numpy()
        axes.errorbar(places, values, width, fmt="o", color=palette.model)
        axes.set_ylabel(f"{name} [{unit}]")
        axes.set_title(axis, loc="left")
    rows[-1].set_xlabel("log, in the order of the batch")
    return figure


def diagnosis_figure(diagnosis: Diagnosis, palette: Palette = LIGHT) -> Drawn:
    """Force and its error over time, the error over frequency, and how far it shrinks.

    Models that a diagnosis does not have are left out.
    """
    with mpl.rc_context(palette.style):
        figure = Drawn(figsize=(_WIDTH, 4.2 * _ROW), layout="constrained")
        force, error, below = figure.subplots(3, 1, height_ratios=(1.2, 1, 1.3))
        signals, unit = diagnosis.signals, diagnosis.gap.unit
        models = {
            "nominal": (signals.nominal, palette.residual),
            "re-identified": (signals.reidentified, palette.model),
            "explained": (signals.explained, palette.other),
        }
        known = {name: both for name, both in models.items() if np.isfinite(both[0]).any()}
        measured = {"measured": (signals.measured, palette.measured, 2.6)}
        curves = {name: (values, colour, 0.9) for name, (values, colour) in known.items()}
        errors = {name: (signals.measured - values, colour, 0.8) for name, (values, colour) in known.items()}
        draw_over_time(force, signals.time, measured | curves, f"{diagnosis.gap.signal} [{unit}]")
        draw_over_time(error, signals.time, errors, f"error [{unit}]")
        force.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, frameon=False)
        force.set_title(diagnosis.axis.name, loc="left")
        error.sharex(force)
        error.set_xlabel("time [s]")
        below.axis("off")
        place: Any = below.get_subplotspec()
        left, right = place.subgridspec(1, 2)
        _spectrum(figure.add_subplot(left), diagnosis, palette)
        _stages(figure.add_subplot(right), diagnosis, palette)
        for axes in figure.axes:
            label_log_scales(axes)
    return figure


def _rows(count: int, palette: Palette, narrow: bool) -> tuple[Drawn, list[Axes]]:
    """Axes below each other that share their horizontal one."""
    with mpl.rc_context(palette.style):
        width = _NARROW_WIDTH if narrow else _WIDTH
        figure = Drawn(figsize=(width, _ROW * count + 0.4), layout="constrained")
        return figure, list(figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0])


def _spectrum(axes: Axes, diagnosis: Diagnosis, palette: Palette) -> None:
    spectrum = diagnosis.spectrum
    curves = (
        (spectrum.reidentified, palette.model, "re-identified"),
        (spectrum.explained, palette.other, "explained"),
        (spectrum.noise, palette.residual, "noise"),
    )
    for values, colour, name in curves:
        if np.isfinite(values).any():
            axes.loglog(spectrum.frequency, values, color=colour, linewidth=1.0, label=name)
    axes.set_xlabel("frequency [Hz]")
    axes.set_ylabel(f"error [{diagnosis.gap.unit}/√Hz]")
    axes.legend(loc="best", frameon=False)


def _stages(axes: Axes, diagnosis: Diagnosis, palette: Palette) -> None:
    """The error of each model, the noise floor last."""
    sizes = {stage.model: stage.level.rms for stage in waterfall(diagnosis) if stage.level is not None}
    axes.barh(list(sizes), list(sizes.values()), color=palette.measured)
    axes.invert_yaxis()
    axes.set_xlabel(f"rms of the error [{diagnosis.gap.unit}]")


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
            row[0].set_title(title_lines(title, narrow=narrow), loc="left")
            row[0].legend(loc="upper right", frameon=False)
    return figure
