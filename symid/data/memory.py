"""How much memory a file would take, against what it may take: a small file may hold a great many rows."""

from __future__ import annotations

import math
import os
from pathlib import Path

from symid.errors import LogError

_VALUE = 8


def require_memory(n_values: int, memory: int | None = None) -> None:
    """Raise LogError if numbers of 64 bit take more bytes than they may; by default, than this machine has free."""
    needed, allowed = _VALUE * n_values, free_memory() if memory is None else memory
    if needed > allowed:
        which = "are free" if memory is None else "are allowed (`memory`)"
        raise LogError(
            f"takes {_size(needed)} of memory where {_size(allowed)} {which}: cut the log, or save it as a CSV or "
            "Parquet file and identify it by wls, which reads blocks"
        )


def free_memory() -> float:
    """Bytes of memory that are free or can be freed; infinite where the system does not report it."""
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        return next(1024.0 * int(line.split()[1]) for line in lines if line.startswith("MemAvailable"))
    except (OSError, ValueError, StopIteration):
        pass
    try:
        return float(os.sysconf("SC_PHYS_PAGES")) * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError):
        return math.inf


def _size(n_bytes: float) -> str:
    return f"{n_bytes / 1e9:.3g} GB" if n_bytes >= 1e8 else f"{n_bytes / 1e6:.3g} MB"
