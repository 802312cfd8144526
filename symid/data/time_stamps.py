"""Moments written as text, such as 2026-11-21T10:00:00.001, as seconds."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final

import polars as pl

from symid.arrays import FloatArray
from symid.data.table import values_of

_DATE: Final = r"(\d{4}[-/.]\d\d[-/.]\d\d|\d\d?[./]\d\d?[./]\d{4})"
_OF_DAY: Final = r"\d\d?:\d\d(:\d\d([.,]\d{1,9})?)?"
STAMP: Final = re.compile(rf"{_DATE}([T ]{_OF_DAY}\s?(Z|[+-]\d\d:?\d\d)?)?|\d\d:\d\d:\d\d([.,]\d{{1,9}})?")
"""A day with a time or without, as in ISO 8601 or with points or slashes, or a time of day."""
_DAYS: Final = ("%Y-%m-%d", "%d.%m.%Y", "%Y/%m/%d", "%Y.%m.%d", "%m/%d/%Y", "%d/%m/%Y")
_FORMATS: Final = tuple(f"{day}T%H:%M{second}" for day in _DAYS for second in (":%S%.f", ""))
_DAY: Final = 86_400.0
_ZONE: Final = r"\s?(Z|[+-]\d\d:?\d\d)$"


def is_stamp(text: str) -> bool:
    """Whether a text is a moment.

    >>> [is_stamp(text) for text in ("2026-11-21T10:00:00.001Z", "10:00:00,5", "2026", "q")]
    [True, True, False, False]
    """
    return STAMP.fullmatch(text.strip()) is not None


def seconds_of_stamps(texts: Sequence[str] | pl.Series) -> FloatArray | None:
    """Seconds from the first of these moments; None if one is not a moment, or their zones differ.

    Times of day that pass midnight go on into the next day.

    >>> seconds_of_stamps(["2026-11-21 10:00:00.250", "2026-11-21 10:00:01"]).tolist()
    [0.0, 0.75]
    >>> seconds_of_stamps(["23:59:59", "00:00:01"]).tolist()
    [0.0, 2.0]
    """
    written = pl.Series(texts, dtype=pl.String).str.strip_chars()
    if not len(written) or not written.head(1).map_elements(is_stamp, return_dtype=pl.Boolean).all():
        return None
    zones = written.str.extract(_ZONE, 1)
    if zones.n_unique() > 1:
        return None
    plain = written.str.replace(_ZONE, "").str.replace(",", ".", literal=True)
    plain = plain.str.replace(" ", "T", literal=True)
    first = str(plain[0])
    of_day = ":" in first and "T" not in first
    if of_day:
        plain = "1970-01-01T" + plain
    elif ":" not in first:
        plain = plain + "T00:00"
    for form in _FORMATS:
        moments = plain.str.to_datetime(form, time_unit="ns", strict=False)
        if not moments.has_nulls():
            seconds = values_of((moments - moments[0]).dt.total_nanoseconds().cast(pl.Float64) * 1e-9)
            nights = (pl.Series(seconds).diff().fill_null(0.0) < -_DAY / 2).cum_sum().to_numpy()
            return seconds + _DAY * nights if of_day else seconds
    return None
