"""A row of the results: its columns, times and error messages."""

import math
from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Any

from symid.arrays import FloatArray
from symid.errors import GeneratedModuleError, LogError, SymidError
from symid.text import one_line

Value = str | int | float | None
ResultRow = Mapping[str, Value]

TIMES = ("recorded", "finished")
DIAGNOSIS: Mapping[str, type] = {
    "verdict": str,
    "effect": str,
    "at": str,
    "probability": float,
    "closed_fraction": float,
    "gap_reidentified": float,
    "gap_explained": float,
    "gap_floor": float,
    "sentence": str,
}
BEFORE: Mapping[str, type] = {
    **dict.fromkeys(
        ("log", "content", "key", "axis", "measured", "method", "known", "status", "message"), str
    ),
    "samples": int,
    "cutoff_hz": float,
    "order": int,
    "decimation": int,
    "condition_number": float,
}
AFTER: Mapping[str, type] = {
    **dict.fromkeys(("residual_rms", "residual_relative", "seconds"), float),
    "late_signal": str,
    **dict.fromkeys(("late_s", "late_std_s", "largest_bias", "largest_discrepancy"), float),
    **dict.fromkeys(("notes", *TIMES), str),
}
"""Columns before and after those of the parameters.

`late_*` is the signal that seems to be recorded late and its delay, `largest_bias` the largest expected bias relative
to the parameter, `largest_discrepancy` the most that effects which the model lacks may have changed one,
`notes` the notes from reading and identifying the log.
"""
FACTORS = "factors"
"""Column of the triangular factors of a log."""
TEXT_COLUMNS = tuple(n for n, kind in {**BEFORE, **AFTER, **DIAGNOSIS, FACTORS: str}.items() if kind is str)


def finite(value: Any) -> Value:
    """A number for a row: None for nan, infinity and a missing value.

    >>> finite(float("nan")), finite(2)
    (None, 2.0)
    """
    if value is None:
        return None
    number = float(value)
    return number if math.isfinite(number) else None


def values_and_deviations(values: Mapping[str, float], deviations: FloatArray) -> dict[str, Value]:
    """Columns of parameters and of their standard deviations.

    >>> values_and_deviations({"M": 5.0}, [0.1])
    {'M': 5.0, 'M_std': 0.1}
    """
    row: dict[str, Value] = {}
    for (name, value), deviation in zip(values.items(), deviations, strict=True):
        row[name], row[f"{name}_std"] = finite(value), finite(deviation)
    return row


def time_text(seconds: float) -> str:
    """A time since the epoch as ISO 8601 in UTC."""
    return datetime.fromtimestamp(seconds, UTC).isoformat(timespec="microseconds")


def failure_row(log: str, error: BaseException) -> dict[str, Value]:
    """Status and message of a log whose identification failed with an error."""
    match error:
        case LogError():
            status, message = "bad_log", str(error)
        case GeneratedModuleError():
            status, message = "no_model", str(error)
        case SymidError():
            status, message = "bad_setting", str(error)
        case OSError():
            status, message = "unreadable", f"{error.strerror or error}: check the file"
        case MemoryError():
            status, message = "failed", "there is not enough memory: use fewer `jobs`, or a shorter log"
        case _:
            status, message = "failed", f"{type(error).__name__}: {error}"
    return {"status": status, "message": one_line(message.removeprefix(f"{log}: "))}
