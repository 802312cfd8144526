"""A tuning as a JSON record, as a table, and as curves of the error against cutoff and sampling frequency."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from rich.console import Console
from rich.table import Table

from symid.report.colours import LIGHT, Palette
from symid.report.console import report_console
from symid.report.drawn import Drawn
from symid.report.plots import figure_path, save_figure
from symid.tuning import BoundSearch, Tuning


def tuning_record(found: Tuning) -> dict[str, Any]:
    """What `symid tune --json` writes."""
    return {
        "axis": found.axis,
        "measured": list(found.measured),
        "status": found.status,
        "message": found.message,
        "left_out": list(found.left_out),
        "filter": {"cutoff_hz": found.cutoff.frequency_hz, "order": found.order, "decimation": 1},
        "cutoff": _search(found.cutoff),
        "differences": found.differences,
        "first_sampling_hz": found.first_sampling_hz,
        "sampling_hz": found.sampling.frequency_hz,
        "sampling_period_s": found.sampling_period,
        "sampling": {"parameters": found.kind, **_search(found.sampling)},
    }


def _search(search: BoundSearch) -> dict[str, Any]:
    return {
        "status": search.status,
        "frequency_hz": search.frequency_hz,
        "bound_percent": search.bound,
        "largest_error_percent": search.largest_error,
        "errors_percent": dict(search.errors),
        "curve": {
            "frequency_hz": search.scanned_hz.tolist(),
            "largest_error_percent": search.scanned_errors.tolist(),
        },
    }


def print_tuning(found: Tuning, console: Console | None = None) -> None:
    """Print frequencies and errors as tables."""
    console = console or report_console()
    console.print(f"{found.axis} from {', '.join(found.measured)}: {found.status}")
    if found.message:
        console.print(found.message)
    if found.left_out:
        console.print(f"tuned without what jumps at standstill: {', '.join(found.left_out)}")
    table = Table("", "frequency", "largest error", "bound", box=None)
    cutoff, sampling = found.cutoff, found.sampling
    table.add_row(
        "cutoff [35]", _hz(cutoff.frequency_hz), _percent(cutoff.largest_error), f"{cutoff.bound:g} %"
    )
    table.add_row(
        f"first sampling frequency [36], {found.differences} differences",
        _hz(found.first_sampling_hz),
        "",
        "",
    )
    table.add_row(
        "sampling frequency [37]",
        _hz(sampling.frequency_hz),
        _percent(sampling.largest_error),
        f"{sampling.bound:g} %",
    )
    console.print(table)
    errors = Table("error of", "from the cutoff [35]", "from sampling [37]", box=None)
    for name in {**sampling.errors, **cutoff.errors}:
        errors.add_row(
            name, *(_percent(part.errors[name]) if name in part.errors else "" for part in (cutoff, sampling))
        )
    console.print(errors)


def _hz(value: float) -> str:
    return f"{value:.2f} Hz"


def _percent(value: float) -> str:
    return f"{value:.4g} %"


def plot_tuning(found: Tuning, file: str | Path, palette: Palette = LIGHT) -> None:
    """Draw the largest error against the cutoff and against the sampling frequency into a file.

    Parameters
    ----------
    found : Tuning
        What `tune` returned.
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
    save_figure(tuning_figure(found, palette), path)


def tuning_figure(found: Tuning, palette: Palette = LIGHT) -> Drawn:
    """The figure that `plot_tuning` writes."""
    with mpl.rc_context(palette.style):
        figure = Drawn(figsize=(10, 4), layout="constrained")
        left, right = figure.subplots(1, 2)
        _draw(left, found.cutoff, "cutoff frequency [Hz]", "low-pass filter, exact derivatives [35]", palette)
        title = f"central differences of {', '.join(found.measured)} [37]"
        _draw(right, found.sampling, "sampling frequency [Hz]", title, palette)
        right.axvline(
            found.first_sampling_hz,
            color=palette.residual,
            linestyle=":",
            linewidth=1,
            label="first guess [36]",
        )
        left.set_ylabel("largest error of a parameter [%]")
        for axes in (left, right):
            axes.legend(loc="lower left", frameon=True, edgecolor="none", framealpha=0.9)
    return figure


def _draw(axes: Axes, search: BoundSearch, label: str, title: str, palette: Palette) -> None:
    axes.loglog(
        search.scanned_hz, search.scanned_errors, ".-", color=palette.other, linewidth=1, label="error"
    )
    axes.axhline(search.bound, color=palette.model, linewidth=1, label=f"bound {search.bound:g} %")
    axes.loglog(
        search.frequency_hz,
        search.largest_error,
        "o",
        color=palette.model,
        fillstyle="none",
        markersize=9,
        label=f"tuned {search.frequency_hz:.4g} Hz",
    )
    axes.set_xlabel(label)
    axes.set_title(title, loc="left")
