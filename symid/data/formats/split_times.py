"""Times in two columns, whole seconds and fractions, as robots, system calls and controllers write them."""

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from symid.arrays import FloatArray
from symid.data.columns import TIME
from symid.data.table import Table

_REST: Final = re.compile(r"(?P<stem>.*?)(?P<prefix>nano|micro|n|u)(?:s|secs?|seconds?)", re.IGNORECASE)
_PARTS: Final = {"nano": 1e-9, "n": 1e-9, "micro": 1e-6, "u": 1e-6}
_MILLISECONDS: Final = re.compile(r"milli(?:tm)?|m(?:illi)?s(?:ec(?:ond)?s?)?")
"""Names of a column of milliseconds beside a time of day in whole seconds."""
_WHOLE_WITHIN: Final = 1e-6  # s
_WHOLE: Final = ("sec", "secs", "second", "seconds", "s")


def with_joined_times(table: Table) -> Table:
    """The table with a column ``t [s]`` in place of whole seconds, if another column holds the fractions.

    >>> parts = [np.array([17.0, 18.0]), np.array([5e8, 0.0])]
    >>> headers = ("stamp.sec", "stamp.nanosec")
    >>> found = with_joined_times(Table(headers, lambda places: [parts[place] for place in places]))
    >>> found.headers, found.read([0])[0].tolist()
    (('t [s]', 'stamp.nanosec'), [0.5, 1.0])
    """
    pair = _pair(table.headers) or _time_of_day(table)
    if pair is None:
        return table
    whole, rest, factor = pair

    def read(positions: Sequence[int]) -> list[FloatArray | str]:
        wanted = sorted({*positions, whole, rest})
        columns = dict(zip(wanted, table.read(wanted), strict=True))
        seconds, parts = columns[whole], columns[rest]
        if not isinstance(seconds, str) and not isinstance(parts, str):
            first = seconds[np.isfinite(seconds)][:1].sum()  # a fraction of 1.7e9 s would lose digits
            if _are_parts(seconds - first, factor * parts):
                columns[whole] = (seconds - first) + factor * parts
        return [columns[position] for position in positions]

    headers = tuple(f"{TIME} [s]" if place == whole else name for place, name in enumerate(table.headers))
    return replace(table, headers=headers, read=read, slices=None)


def _pair(headers: Sequence[str]) -> tuple[int, int, float] | None:
    """Positions of whole seconds and of fractions, and the unit of these in seconds; None without such a pair."""
    lower = [header.strip().lower() for header in headers]
    if TIME in lower or any(name.startswith(f"{TIME} [") for name in lower):
        return None
    for rest, name in enumerate(lower):
        if match := _REST.fullmatch(name):
            names = [match["stem"] + ending for ending in _WHOLE]
            whole = [place for place, other in enumerate(lower) if other in names]
            if len(whole) == 1:
                return whole[0], rest, _PARTS[match["prefix"]]
    return None


def _time_of_day(table: Table) -> tuple[int, int, float] | None:
    """As `_pair`, for times of day beside a column of milliseconds."""
    rest = [
        place for place, name in enumerate(table.headers) if _MILLISECONDS.fullmatch(name.strip().lower())
    ]
    return (next(iter(table.stamps)), rest[0], 1e-3) if len(table.stamps) == len(rest) == 1 else None


def _are_parts(seconds: FloatArray, rest: FloatArray) -> bool:
    """Whether these are whole seconds and parts of a second, and neither repeats the other."""
    known = np.isfinite(seconds) & np.isfinite(rest)
    off = np.abs(seconds - np.rint(seconds))[known]
    return bool(np.all(off < _WHOLE_WITHIN) and np.all((rest[known] >= 0.0) & (rest[known] < 1.0)))
