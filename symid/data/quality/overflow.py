"""Unwrapping of positions and times whose counter or angle wraps around at the end of its range."""

import math
from typing import Final

import numpy as np

from symid.arrays import FloatArray
from symid.data.quality.checks import jumps_of
from symid.data.quality.lost_samples import step_of
from symid.text import counted

_BITS: Final = range(8, 33)
"""Sizes of counters."""
_CLOCK_BITS: Final = (16, 24, 32)
_CLOCK_UNITS: Final = (1.0, 1e-3, 1e-6, 1e-9)
"""Bits of counters of the time, and units of one of their counts."""
_RANGE_ERROR: Final = 0.02
"""Error of a jump, less the step of the samples beside it, as a share of the range that is begun again."""
_TURN: Final = 2.0 * math.pi


@np.errstate(over="ignore", invalid="ignore")  # damaged numbers may be near the end of the range
def unwrapped(name: str, x: FloatArray, *, is_angle: bool) -> tuple[FloatArray, str]:
    """An unwrapped position, and a note; unchanged and without a note if it jumps otherwise.

    All jumps must be of 2^8 to 2^32 of the smallest steps of the values, or of a turn of an angle in rad, and go
    against the motion beside them.

    >>> counts = np.round(3000 * np.sin(np.arange(600) / 50))
    >>> x, note = unwrapped("q", 1e-3 * (counts % 1024), is_angle=False)
    >>> bool(np.allclose(np.diff(x), 1e-3 * np.diff(counts))), note
    (True, "'q' wraps 18 times after 1024 steps: it is unwrapped")
    >>> unwrapped("q", np.where(np.arange(600) > 300, 1e-3 * counts, 0.5), is_angle=False)[1]
    ''
    """
    jumps = np.array(jumps_of(x) if np.isfinite(x).all() else [], dtype=np.intp)
    jumps = jumps[(jumps > 1) & (jumps < x.size - 1)]
    if not jumps.size:
        return x, ""
    # Between two samples the counter wraps and the axis moves on by about the step beside: the jump less that step is
    # the range, and has the opposite sign.
    beside = (x[jumps - 1] - x[jumps - 2] + x[jumps + 1] - x[jumps]) / 2
    sizes = np.abs(x[jumps] - x[jumps - 1] - beside)
    along = beside * np.sign(x[jumps] - x[jumps - 1])
    step = step_of(x)
    ranges = {f"{2**bits} steps": 2.0**bits * step for bits in _BITS if step}
    if is_angle:
        ranges["a turn"] = _TURN
    for what, whole in ranges.items():
        near = _RANGE_ERROR * whole
        if np.all(np.abs(sizes - whole) < near) and np.all(along < near) and np.ptp(x) < whole + near:
            again = int(np.count_nonzero(np.abs(np.diff(x)) > whole / 2))
            through = np.unwrap(x, period=whole)
            if not jumps_of(through):
                return through, f"{name!r} wraps {counted(again, 'time')} after {what}: it is unwrapped"
    return x, ""


def unwrapped_times(x: FloatArray) -> tuple[FloatArray, str]:
    """Times from a counter of 16, 24 or 32 bits, unwrapped, and a note; other times unchanged, without a note.

    Each fall must leave a usual step, once the range is added. Microseconds may be written in seconds, for instance.

    >>> t = 1000.0 * np.arange(300)
    >>> found, note = unwrapped_times(t % 65536)
    >>> bool((found == t).all()), note, unwrapped_times(t % 60000)[1]
    (True, 't wraps 4 times after 65536: it is unwrapped', '')
    """
    if not np.isfinite(x).all() or x.min(initial=0.0) < 0:
        return x, ""
    steps = np.diff(x)
    falls = steps < 0
    if not falls.any() or falls.all():
        return x, ""
    usual = float(np.median(steps[~falls]))
    for whole in (2.0**bits * scale for bits in _CLOCK_BITS for scale in _CLOCK_UNITS):
        if np.all(np.abs(steps[falls] + whole - usual) < usual / 2) and x.max() < whole:
            again = counted(int(np.count_nonzero(falls)), "time")
            note = f"t wraps {again} after {whole:.10g}: it is unwrapped"
            return x + whole * np.append(0, np.cumsum(falls)), note
    return x, ""
