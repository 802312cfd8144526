"""Checks of the values of a log: missing and constant channels, and positions that jump."""

from collections.abc import Mapping
from typing import Final

import numpy as np

from symid.arrays import FloatArray
from symid.data.quality.clock import time_and_row
from symid.text import counted

_LARGEST: Final = 1e15  # in SI: beyond it a number is damaged
_SMALLEST: Final = 1e-30  # SI: a channel below it throughout holds nothing
_NEIGHBOURS: Final = 20  # samples on either side with which a step is compared
_JUMP_RATIO: Final = 30.0  # of a step to those nearby, from which on it is a jump
_JUMP_STEPS: Final = 20.0  # of the finest step: quantisation steps are not jumps
_JUMP_RANGE: Final = 1e-3  # of the travel


def inspect_values(time: FloatArray, signals: Mapping[str, FloatArray]) -> tuple[str, ...]:
    """Faults of the needed channels: values empty or not finite, and channels that never change.

    >>> inspect_values(np.arange(3.0), {"q": np.full(3, 2.0)})
    ("'q' is constant (2) over the whole log: check its sensor or leave it out of the measured signals",)
    """
    faults: list[str] = []
    for name, x in signals.items():
        if wrong := inspect_finite(time, {name: x}):
            faults += wrong
        elif x.size and (fault := constant_fault(name, float(x.min()), float(x.max()))):
            faults.append(fault)
    return tuple(faults)


def inspect_finite(time: FloatArray, signals: Mapping[str, FloatArray], before: int = 0) -> tuple[str, ...]:
    """Faults of channels with values that are empty or not finite.

    `before` counts the rows before the first of these samples, in messages.

    >>> inspect_finite(np.arange(2.0), {"q": np.array([1.0, np.nan])}, before=10)[0][:49]
    "'q' has 1 value empty or not finite, the first at"
    """
    faults = []
    for name, x in signals.items():
        bad = np.flatnonzero(~np.isfinite(x))
        if bad.size:
            faults.append(
                f"{name!r} has {counted(bad.size, 'value')} empty or not finite, the first at "
                f"{time_and_row(time, bad[0], before)}: repair or cut out those rows, or give `resample=own`"
            )
            continue
        largest = int(np.argmax(np.abs(x)))
        if abs(x[largest]) > _LARGEST:
            faults.append(
                f"{name!r} has a value of {x[largest]:.3g} at {time_and_row(time, largest, before)}, "
                "which no sensor measures: repair or cut out such rows"
            )
    return tuple(faults)


def constant_fault(name: str, lowest: float, highest: float) -> str | None:
    """Fault of a channel that is constant, or constant up to rounding; None if it varies."""
    if lowest == highest:
        return (
            f"{name!r} is constant ({lowest:g}) over the whole log: "
            "check its sensor or leave it out of the measured signals"
        )
    if max(abs(lowest), abs(highest)) < _SMALLEST:
        return f"{name!r} has no value above {_SMALLEST:g}: check its unit and its sensor"
    return None


@np.errstate(over="ignore", invalid="ignore")  # damaged numbers may be near the end of the range
def inspect_steps(time: FloatArray, signals: Mapping[str, FloatArray], before: int = 0) -> tuple[str, ...]:
    """Faults of positions that jump: rows are missing, the unit changes, a value is wrong, or a counter overflows.

    A jump is a step that differs from both the step before it and the one after it by far more than the steps
    nearby do. A change of speed, such as an impact, does not count. The positions or angles have no missing values.

    >>> t = np.arange(100) / 10.0
    >>> inspect_steps(t, {"q": np.sin(t) + (t > 5.0)})[0]
    "'q' jumps by 1.03 at t = 5.1 s (row 52): split the log there, or repair the channel"
    """
    faults = []
    for name, x in signals.items():
        jumps = jumps_of(x)
        if jumps:
            first = jumps[0]
            more = f", and {counted(len(jumps) - 1, 'time')} more" if len(jumps) > 1 else ""
            faults.append(
                f"{name!r} jumps by {x[first] - x[first - 1]:.3g} at {time_and_row(time, first, before)}{more}: "
                "split the log there, or repair the channel"
            )
    return tuple(faults)


def jumps_of(x: FloatArray) -> list[int]:
    """Samples before which a position jumps: the step is far larger than those nearby, its neighbours left out."""
    if x.size < 2 * _NEIGHBOURS:
        return []
    step = x[1:] - x[:-1]
    curvature = np.abs(step[1:] - step[:-1])
    odd = np.minimum(curvature[:-1], curvature[1:])  # of the step from sample i + 1 to i + 2
    jumps = np.flatnonzero(odd > _JUMP_RANGE * float(np.ptp(x)))
    if not jumps.size:
        return []
    coarse = np.abs(step)
    finest = float(np.min(coarse, where=coarse > 0, initial=np.inf))
    around, jumps = np.pad(odd, _NEIGHBOURS + 2), jumps[odd[jumps] > _JUMP_STEPS * finest]
    for apart in (*range(-_NEIGHBOURS, -2), *range(3, _NEIGHBOURS + 3)):
        jumps = jumps[odd[jumps] > _JUMP_RATIO * around[jumps + _NEIGHBOURS + 2 + apart]]
    return (jumps + 2).tolist()
