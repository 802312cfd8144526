"""Text that the trace of CODESYS exports: properties and, below those of each variable, its samples.

A line is ``key; value``. The keys of a variable begin with its number, as in ``0.Variable; PLC_PRG.fPosition``. Below
``0.Data;``, each line holds a time stamp and a value. ``Flags`` states the unit of the stamps.
"""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np

from symid.arrays import FloatArray
from symid.data.formats.channels import Channel, table_of_channels
from symid.data.table import Table
from symid.data.text_files.layout import encoding_of
from symid.errors import LogError

_BEGIN: Final = b"[key]"
_SECONDS: Final = {0x10: 1e-3, 0x20: 1e-6}
"""Seconds in a unit of the time stamps, by the flag of a trace that states it (header of the trace manager)."""
_TRUTH: Final = {"TRUE": "1", "FALSE": "0"}


def codesys_trace_in(path: Path, begin: bytes) -> Callable[[], Table] | None:
    """Reader of a text file that begins as the exported trace of a CODESYS controller; None of others."""
    is_trace = _BEGIN in begin[:64].replace(b"\x00", b"")  # of UTF-16
    return partial(_open_trace, path) if is_trace else None


def _open_trace(path: Path) -> Table:
    """Table in an exported trace; LogError if it holds no samples or does not state the unit of its time stamps."""
    content = path.read_bytes()
    lines = content.decode(encoding_of(content), errors="replace").splitlines()
    rows = [[text.strip() for text in line.split(";")] for line in lines]
    properties = {row[0]: row[1] for row in rows if len(row) > 1 and row[0]}
    factor = _seconds(path, properties.get("Flags", ""))
    channels = []
    for name, samples in _samples(rows, properties):
        if len(samples) > 1:
            time, values = samples.T
            channels.append(Channel(name, "", factor * time, values))
    if not channels:
        raise LogError(f"{path}: no variable of the trace has samples: export it after it has recorded")
    return table_of_channels(channels)


def _seconds(path: Path, flags: str) -> float:
    """Seconds in a unit of the time stamps, by the flags of the trace."""
    stated = int(flags) if flags.isdecimal() else 0
    factor = next((factor for flag, factor in _SECONDS.items() if stated & flag), None)
    if factor is None:
        raise LogError(
            f"{path}: its Flags ({flags or 'none'}) state no resolution of the time stamps: set ms or us in the "
            f"configuration of the trace, and record again"
        )
    return factor


def _samples(rows: list[list[str]], properties: dict[str, str]) -> list[tuple[str, FloatArray]]:
    """Name, and times and values of shape (n, 2), of each variable."""
    samples: list[tuple[str, list[list[str]]]] = []
    for row in rows:
        number, _, key = row[0].partition(".")
        if key == "Data":
            samples.append((properties.get(f"{number}.Variable") or f"variable {number}", []))
        elif samples and len(row) > 2 and not row[0]:
            samples[-1][1].append(row[1:3])
    return [(name, np.array([_numbers(*pair) for pair in pairs]).reshape(-1, 2)) for name, pairs in samples]


def _numbers(stamp: str, value: str) -> tuple[float, float]:
    """A time stamp and a value, which may be a truth value; not a number where it is neither.

    >>> _numbers("20", "1,5"), _numbers("40", "TRUE")
    ((20.0, 1.5), (40.0, 1.0))
    """
    try:
        return float(stamp), float(_TRUTH.get(value.upper(), value).replace(",", "."))
    except ValueError:
        return float("nan"), float("nan")
