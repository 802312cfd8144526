"""The gap in the simulated motion as rows of a table and in a line."""

import math
from typing import Any

from symid.report.tables.number_text import MISSING, share, significant

_DRIVERS = {
    "given": "simulated under the controller that was given",
    "identified": "simulated under a cascade read from the log",
    "observer": "driven by the measured force, with a slow observer that keeps the axis to the measured position",
}
_MILLI, _MICRO = 1e3, 1e6


def motions(record: dict[str, Any]) -> list[dict[str, Any]]:
    """The simulated motion next to each drive, that of the gap alone with one; empty where it was not simulated."""
    return [gap["motion"] for gap in record.get("drives") or [record["gap"]] if gap["motion"]]


def motion_rows(motion: dict[str, Any], record: dict[str, Any]) -> list[tuple[str, ...]]:
    """Rows of the table of a simulated motion: the model, its fits, and its errors in `unit_of_errors`."""
    names = [stage["model"] for stage in record["waterfall"]]
    scale, _ = unit_of_errors(motion)
    return [
        (name, *_cells(error, scale))
        for name, error in zip(names, _errors(motion), strict=False)
        if error is not None
    ]


def unit_of_errors(motion: dict[str, Any]) -> tuple[float, str]:
    """Scale and unit of the errors of a simulated motion: thousandths where one is that large, else millionths."""
    sizes = [error[f"{name}_rms"] for error in _errors(motion) if error for name in ("position", "reversal")]
    large = any(size >= 1 / _MILLI for size in sizes if size is not None)
    return (_MILLI, f"m{motion['unit']}") if large else (_MICRO, f"u{motion['unit']}")


def _errors(motion: dict[str, Any]) -> list[dict[str, Any] | None]:
    return [motion["nominal"], motion["reidentified"], *motion["steps"]]


def _cells(error: dict[str, Any], scale: float) -> tuple[str, ...]:
    if error["status"] != "ok":
        return ("failed", *[MISSING] * 4)
    fits = (fit(error[f"{name}_fit"]) for name in ("position", "velocity", "tracking"))
    sizes = (significant(scale * error[f"{name}_rms"], 3) for name in ("position", "reversal"))
    return (*fits, *sizes)


def fit(per_cent: float) -> str:
    """A fit in per cent, near 100 with the digits that distinguish it from 100.

    >>> fit(99.99312), fit(96.64), fit(-31.2), fit(100.0), fit(float("nan"))
    ('99.9931 %', '96.6 %', '-31.2 %', '100 %', '–')
    """
    if not math.isfinite(per_cent):
        return MISSING
    left = abs(100.0 - per_cent)
    places = 1 if left >= 1 else min(1 - math.floor(math.log10(left)), 6) if left else 0
    return f"{per_cent:.{max(places, 1) if left else 0}f} %"


def motion_line(motion: dict[str, Any]) -> str:
    """Remark on the simulation of the axis: its driver, effects left out, the reason of a failure."""
    gains = ", ".join(f"{name} {value:.4g}" for name, value in motion["gains"].items())
    explains = ""
    if motion["share"] < 0:  # gains so high that errors of the readings alone make more force than there is
        explains = ", from which the force does not follow by the readings alone"
    elif motion["share"] == motion["share"]:
        explains = f", which explains {share(motion['share'])} of the force"
    line = f"motion: {_DRIVERS[motion['driver']]} ({gains}){explains}"
    if motion["tracking_rms"] == motion["tracking_rms"]:
        scale, unit = unit_of_errors(motion)
        line += f"; measured tracking error {significant(scale * motion['tracking_rms'], 3)} {unit} rms"
    errors = (motion["reidentified"], motion["explained"])
    messages = [error["message"] for error in errors if error["message"]]
    return "; ".join([line, *dict.fromkeys(messages)])
