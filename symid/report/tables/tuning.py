"""A tuning as a JSON record and as tables."""

import math
from typing import Any

from rich.console import Console
from rich.table import Table

from symid.report.tables.console import report_console
from symid.report.tables.number_text import percent
from symid.tuning import BoundSearch, TotalTuning, Tuning


def tuning_record(tuning: Tuning) -> dict[str, Any]:
    """Record of `symid tune --json`."""
    return {
        "axis": tuning.axis,
        "measured": list(tuning.measured),
        "status": tuning.status,
        "message": tuning.message,
        "left_out": list(tuning.left_out),
        "filter": {"cutoff_hz": tuning.cutoff.frequency_hz, "order": tuning.order, "decimation": 1},
        "cutoff": _search(tuning.cutoff),
        "differences": tuning.differences,
        "first_sampling_hz": tuning.first_sampling_hz,
        "sampling_hz": tuning.sampling.frequency_hz,
        "sampling_period_s": tuning.sampling_period,
        "sampling": {"parameters": tuning.kind, **_search(tuning.sampling)},
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


def print_tuning(tuning: Tuning, console: Console | None = None) -> None:
    """Print frequencies and errors as tables."""
    console = console or report_console()
    console.print(f"{tuning.axis} from {', '.join(tuning.measured)}: {tuning.status}")
    if tuning.message:
        console.print(tuning.message)
    if tuning.left_out:
        console.print(f"tuned without forces that jump at standstill: {', '.join(tuning.left_out)}")
    table = Table("", "frequency", "largest error", "bound", box=None)
    cutoff, sampling = tuning.cutoff, tuning.sampling
    first = f"first sampling frequency [36], {tuning.differences} differences"
    for name, search in (("cutoff [35]", cutoff), ("sampling frequency [37]", sampling)):
        error, bound = f"{search.largest_error:.4g} %", f"{search.bound:g} %"
        table.add_row(name, f"{search.frequency_hz:.2f} Hz", error, bound)
        if search is cutoff:
            table.add_row(first, f"{tuning.first_sampling_hz:.2f} Hz", "", "")
    console.print(table)
    errors = Table("error of", "from the cutoff [35]", "from sampling [37]", box=None)
    for name in {**sampling.errors, **cutoff.errors}:
        parts = (part.errors.get(name) for part in (cutoff, sampling))
        errors.add_row(name, *("" if error is None else percent(error / 100, 4) for error in parts))
    console.print(errors)


def total_record(tuning: TotalTuning) -> dict[str, Any]:
    """Record of `symid tune --noise-from LOG --json`."""
    return {
        "axis": tuning.axis,
        "measured": list(tuning.measured),
        "status": tuning.status,
        "message": tuning.message,
        "filter": {
            "cutoff_hz": tuning.preparation.cutoff_hz,
            "order": tuning.preparation.order,
            "decimation": tuning.preparation.decimation,
        },
        "noise": dict(tuning.noise),
        "sampling_hz": tuning.sampling_hz,
        "recommended_sampling_hz": tuning.recommended_sampling_hz,
        "total_error_percent": tuning.total_percent,
        "decisive": list(tuning.decisive),
        "errors_percent": {
            name: {"systematic": tuning.systematic[name], "total": total}
            for name, total in tuning.total.items()
        },
        "curve": {"cutoff_hz": tuning.cutoffs_hz.tolist(), "total_error_percent": tuning.totals.tolist()},
    }


def print_total_tuning(tuning: TotalTuning, console: Console | None = None) -> None:
    """Print the setting and the errors that it leaves."""
    console, settings = console or report_console(), tuning.preparation
    console.print(f"{tuning.axis} from {', '.join(tuning.measured)}: {tuning.status}")
    if tuning.message:
        console.print(tuning.message)
    noise = ", ".join(f"{name} {level:.3g}" for name, level in tuning.noise.items())
    console.print(f"noise (standard deviation, SI): {noise}")
    setting = f"cutoff {settings.cutoff_hz:.4g} Hz, decimation {settings.decimation}"
    console.print(f"{setting}: total error {tuning.total_percent:.3g} %")
    least = tuning.recommended_sampling_hz
    enough = (
        f"systematic errors are below half of the total from {least:.4g} Hz on"
        if math.isfinite(least)
        else "systematic errors exceed half of the total at every sampling frequency up to eight times this one"
    )
    console.print(f"sampling frequency {tuning.sampling_hz:g} Hz; {enough}")
    table = Table("error of", "systematic", "total", box=None)
    for name, total in tuning.total.items():
        decides = "" if name in tuning.decisive else "lost"
        table.add_row(name, f"{tuning.systematic[name]:.3g} %", f"{total:.3g} %", decides)
    console.print(table)
