"""Moments written as text, such as 2026-11-21T10:00:00.001, as seconds."""

import re
from collections.abc import Sequence
from typing import Final

import numpy as np
import polars as pl

from symid.arrays import FloatArray

_DAY: Final = "|".join(
    (
        r"\d{4}[-/.]\d\d?[-/.]\d\d?",
        r"\d\d?[-/.]\d\d?[-/.](?:\d{4}|\d\d)",
        r"\d\d?[- ][A-Z][a-z]{2}[- ]\d{4}",
        r"\d{8}T",
        r"\d+ days?",
    )
)
_OF_DAY: Final = (
    r"(?:(?P<hours>\d\d?):)?(?P<minutes>[0-5]?\d):(?P<seconds>[0-5]\d(?:[.,]\d{1,9}|[:;]\d{3}(?:\d{3})?)?)"
    r"|(?P<compact>\d{6}(?:[.,]\d{1,9})?)"
)
_STAMP: Final = (
    rf"^(?:(?P<day>{_DAY})(?:[T ]\s*|$)?)?"
    rf"(?:(?:{_OF_DAY})(?:\s?(?P<half>[AP]M|[ap]m))?(?:\s?(?P<zone>Z|UTC|GMT|[+-]\d\d:?\d\d))?)?$"
)
"""A day with a time or without, as in ISO 8601 and in spreadsheets, or a time of day, or minutes and seconds."""
_READ: Final = re.compile(_STAMP)
_DAYS: Final = (
    *("%Y-%m-%d", "%Y/%m/%d", "%Y.%m.%d", "%Y%m%dT", "%d-%b-%Y", "%d %b %Y"),
    *(day + year for day in ("%d.%m.", "%m/%d/", "%d/%m/", "%d-%m-", "%m-%d-") for year in ("%Y", "%y")),
)
_SECONDS_OF_A_DAY: Final = 86_400.0
_UNITS: Final = {"d": 86_400.0, "h": 3600.0, "m": 60.0, "s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_DURATION: Final = (
    "^(?i:L?T|L?TIME)#" + "".join(rf"(?:(?P<{unit}>\d+(?:\.\d+)?)(?i:{unit})_?)?" for unit in _UNITS) + "$"
)
"""A duration as controllers write it, T#1m30s250ms (IEC 61131-3, literals of TIME and LTIME)."""
_READ_DURATION: Final = re.compile(_DURATION)


def is_stamp(text: str) -> bool:
    """Whether a text is a moment or a day.

    >>> [is_stamp(text) for text in ("2026-11-21T10:00:00.001Z", "10:00:00,5", "1/2/26 9:00:00 PM", "2026", "10:00")]
    [True, True, True, False, False]
    >>> is_stamp("T#1s_250ms"), is_stamp("T#")
    (True, False)
    """
    if _is_duration(text):
        return True
    match = _READ.match(text.strip())
    if match is None or not match["day"]:
        return match is not None and bool(match["hours"] or (match["seconds"] and len(match["seconds"]) > 2))
    return not match["compact"] or match["day"].endswith("T")


def has_time_of_day(text: str) -> bool:
    """Whether a text is a moment, which distinguishes samples, and not a day alone.

    >>> has_time_of_day("20261121T100000"), has_time_of_day("21.11.2026")
    (True, False)
    """
    if _is_duration(text):
        return True
    match = _READ.match(text.strip())
    return is_stamp(text) and match is not None and bool(match["minutes"] or match["compact"])


def _is_duration(text: str) -> bool:
    match = _READ_DURATION.match(text.strip())
    return match is not None and any(match.groups())


def seconds_of_stamps(texts: Sequence[str] | pl.Series) -> FloatArray | None:
    """Seconds from the first of these moments; None if one is not a moment, or their zones differ.

    Times of day that pass midnight go on into the next day, minutes and seconds into the next hour.

    >>> seconds_of_stamps(["2026-11-21 10:00:00.250", "2026-11-21 10:00:01"]).tolist()
    [0.0, 0.75]
    >>> seconds_of_stamps(["23:59:59", "00:00:01"]).tolist(), seconds_of_stamps(["59:59.5", "00:00.5"]).tolist()
    ([0.0, 2.0], [0.0, 1.0])
    >>> seconds_of_stamps(["11/21/26 11:59:59;500 AM", "11/21/26 12:00:01;500 PM"]).tolist()
    [0.0, 2.0]
    >>> seconds_of_stamps(["T#59s750ms", "TIME#1m0.25s"]).tolist()
    [0.0, 0.5]
    """
    written = pl.Series(texts, dtype=pl.String).str.strip_chars()
    if not len(written) or written.has_nulls() or not is_stamp(str(written[0])):
        return None
    if _is_duration(str(written[0])):
        return _seconds_of_durations(written)
    parts = written.str.extract_groups(_STAMP).struct.unnest()
    if any(parts[name].is_null().any() != parts[name].is_null().all() for name in parts.columns):
        return None
    if parts["zone"].n_unique() > 1:
        return None
    days = _days(parts["day"])
    within, turn = _seconds_within(parts)
    if days is None or np.isnan(within).any():
        return None
    if parts["day"].is_null().all():  # each restart is one more turn
        turns = np.cumsum(np.diff(within, prepend=within[0]) < -turn / 2, dtype=np.float64)
        days = turns * (turn / _SECONDS_OF_A_DAY)
    seconds: FloatArray = np.round(_SECONDS_OF_A_DAY * (days - days[0]) + (within - within[0]), 9)
    return seconds


def _seconds_of_durations(written: pl.Series) -> FloatArray | None:
    """Seconds from the first of these durations; None if a text is not a duration."""
    parts = written.str.extract_groups(_DURATION).struct.unnest()
    numbers = parts.select(pl.all().cast(pl.Float64))
    if numbers.select(pl.all_horizontal(pl.all().is_null()).any()).item():
        return None
    total = np.zeros(len(written))
    for unit, size in _UNITS.items():
        total += size * numbers[unit].fill_null(0.0).to_numpy()
    seconds: FloatArray = np.round(total - total[0], 9)
    return seconds


def _days(written: pl.Series) -> FloatArray | None:
    """Days as numbers; zeros without days, None if their order is not known."""
    if written.is_null().all():
        return np.zeros(len(written))
    if str(written[0]).endswith(("day", "days")):
        return written.str.extract(r"(\d+)").cast(pl.Float64).to_numpy()
    several = written.unique()
    for form in _DAYS:
        if not several.str.to_date(form, strict=False).has_nulls():
            return written.str.to_date(form, strict=False).to_physical().cast(pl.Float64).to_numpy()
    return None


def _seconds_within(parts: pl.DataFrame) -> tuple[FloatArray, float]:
    """Seconds since midnight, or since the full hour, and the time after which they start again; nan for no time."""
    compact, half = parts["compact"], parts["half"]
    if not compact.is_null().all():
        hours, minutes = _number(compact.str.slice(0, 2)), _number(compact.str.slice(2, 2))
        return 3600.0 * hours + 60.0 * minutes + _number(compact.str.slice(4)), _SECONDS_OF_A_DAY
    minutes, seconds = _number(parts["minutes"]), _number(parts["seconds"])
    if parts["minutes"].is_null().all():
        return np.zeros(len(parts)), _SECONDS_OF_A_DAY
    if parts["hours"].is_null().all():  # 10:00 beside a day is hours and minutes
        return (
            (60.0 * minutes + seconds, 3600.0)
            if parts["day"].is_null().all()
            else (3600.0 * minutes + 60.0 * seconds, _SECONDS_OF_A_DAY)
        )
    hours = _number(parts["hours"])
    if not half.is_null().all():
        hours = hours % 12.0 + 12.0 * (half.str.to_lowercase() == "pm").to_numpy()
    return 3600.0 * hours + 60.0 * minutes + seconds, _SECONDS_OF_A_DAY


def _number(texts: pl.Series) -> FloatArray:
    """Numbers of seconds and the like, with a point, comma, colon or semicolon before the decimals; nan for none."""
    return texts.str.replace("[,:;]", ".").cast(pl.Float64, strict=False).fill_null(float("nan")).to_numpy()
