"""Tuning on the total error as a JSON record, as tables, and as the curve of the error against the cutoff."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import matplotlib as mpl
from rich.console import Console
from rich.table import Table

from symid.report.colours import LIGHT, Palette
from symid.report.console import report_console
from symid.report.drawn import Drawn
from symid.report.plots import figure_path, save_figure
from symid.tuning import TotalTuning


def total_record(found: TotalTuning) -> dict[str, Any]:
    """Record of `symid tune --noise-from LOG --json`."""
    return {
        "axis": found.axis,
        "measured": list(found.measured),
        "status": found.status,
        "message": found.message,
        "filter": {
            "cutoff_hz": found.preparation.cutoff_hz,
            "order": found.preparation.order,
            "decimation": found.preparation.decimation,
        },
        "noise": dict(found.noise),
        "sampling_hz": found.sampling_hz,
        "recommended_sampling_hz": found.recommended_sampling_hz,
        "total_error_percent": found.total_percent,
        "decisive": list(found.decisive),
        "errors_percent": {
            name: {"systematic": found.systematic[name], "total": total}
            for name, total in found.total.items()
        },
        "curve": {"cutoff_hz": found.cutoffs_hz.tolist(), "total_error_percent": found.totals.tolist()},
    }


def print_total_tuning(found: TotalTuning, console: Console | None = None) -> None:
    """Print the setting and the errors that it leaves."""
    console, settings = console or report_console(), found.preparation
    console.print(f"{found.axis} from {', '.join(found.measured)}: {found.status}")
    if found.message:
        console.print(found.message)
    noise = ", ".join(f"{name} {level:.3g}" for name, level in found.noise.items())
    console.print(f"noise (standard deviation, SI): {noise}")
    console.print(
        f"cutoff {settings.cutoff_hz:.4g} Hz, decimation {settings.decimation}: total error {found.total_percent:.3g} %"
    )
    console.print(f"sampling frequency {found.sampling_hz:g} Hz; {_recommended(found)}")
    table = Table("error of", "systematic", "total", box=None)
    for name, total in found.total.items():
        decides = "" if name in found.decisive else "lost"
        table.add_row(name, f"{found.systematic[name]:.3g} %", f"{total:.3g} %", decides)
    console.print(table)


def _recommended(found: TotalTuning) -> str:
    least = found.recommended_sampling_hz
    if math.isfinite(least):
        return f"systematic errors are below half of the total from {least:.4g} Hz on"
    return "systematic errors exceed half of the total at every sampling frequency up to eight times this one"


def plot_total_tuning(found: TotalTuning, file: str | Path, palette: Palette = LIGHT) -> None:
    """Draw the total error against the cutoff into a file.

    Parameters
    ----------
    found : TotalTuning
        What `tune_total` returned.
    file : path-like
        png, svg or pdf, by its suffix.
    palette : Palette
        `LIGHT` or `DARK`.

    Raises
    ------
    SettingError
        If the suffix is not known.
    """
    path = figure_path(file)
    save_figure(total_tuning_figure(found, palette), path)


def total_tuning_figure(found: TotalTuning, palette: Palette = LIGHT) -> Drawn:
    """The figure that `plot_total_tuning` writes."""
    with mpl.rc_context(palette.style):
        figure = Drawn(figsize=(6, 4), layout="constrained")
        axes = figure.subplots()
        label = "scan, best decimation"
        axes.loglog(found.cutoffs_hz, found.totals, ".-", color=palette.other, linewidth=1, label=label)
        axes.loglog(
            found.preparation.cutoff_hz,
            found.total_percent,
            "o",
            color=palette.model,
            fillstyle="none",
            markersize=9,
            label=f"tuned {found.preparation.cutoff_hz:.4g} Hz, decimation {found.preparation.decimation}",
        )
        axes.set_xlabel("cutoff frequency [Hz]")
        axes.set_ylabel("total error, rms over parameters [%]")
        axes.legend(loc="best", frameon=True, edgecolor="none", framealpha=0.9)
    return figure
