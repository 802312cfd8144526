"""Checks of the values of a log: missing and constant channels, and positions that jump."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np
import numpy.typing as npt

from symid.arrays import FloatArray
from symid.data.clock import describe

_LARGEST: Final = 1e15  # in SI: beyond it a number is damaged
_SMALLEST: Final = 1e-30
_NEAR: Final = 20  # samples on either side with which a step is compared
_JUMP_RATIO: Final = 30.0
_JUMP_STEPS: Final = 20.0  # of the finest step: quantisation steps are not jumps
_JUMP_RANGE: Final = 1e-3  # of the travel


def inspect_values(time: FloatArray, signals: Mapping[str, FloatArray]) -> tuple[str, ...]:
    """Faults of needed channels: values empty or not finite, and channels that never change.

    Parameters
    ----------
    time : array of shape (n_samples,)
        Times, s.
    signals : Mapping of str to array of shape (n_samples,)
        The needed channels.

    Returns
    -------
    tuple of str
        One sentence a fault, naming the channel, the count and the first time.

    Examples
    --------
    >>> inspect_values(np.arange(3.0), {"q": np.full(3, 2.0)})
    ("'q' is constant (2) over the whole log: check its sensor or leave it out of the measured signals",)
    """
    faults: list[str] = []
    for name, x in signals.items():
        if wrong := inspect_finite(time, {name: x}):
            faults += wrong
        elif x.size and (fault := said_range(name, float(x.min()), float(x.max()))):
            faults.append(fault)
    return tuple(faults)


def inspect_finite(time: FloatArray, signals: Mapping[str, FloatArray], before: int = 0) -> tuple[str, ...]:
    """Faults of channels with values that are empty or not finite.

    `before` counts the rows before the first of these samples, in messages.

    Examples
    --------
    >>> inspect_finite(np.arange(2.0), {"q": np.array([1.0, np.nan])}, before=10)[0][:49]
    "'q' has 1 value empty or not finite, the first at"
    """
    faults = []
    for name, x in signals.items():
        bad = np.flatnonzero(~np.isfinite(x))
        if bad.size:
            faults.append(
                f"{name!r} has {describe(bad.size, 'value')} empty or not finite, the first at "
                f"t = {time[bad[0]]:.7g} s (row {before + bad[0] + 1}): repair or cut out those rows"
            )
            continue
        largest = int(np.argmax(np.abs(x)))
        if abs(x[largest]) > _LARGEST:
            faults.append(
                f"{name!r} has a value of {x[largest]:.3g} at t = {time[largest]:.7g} s (row {before + largest + 1}), "
                "which no sensor measures: repair or cut out such rows"
            )
    return tuple(faults)


def said_range(name: str, lowest: float, highest: float) -> str | None:
    """Fault of a channel that is constant, or constant up to rounding; None if there is none.

    Examples
    --------
    >>> said_range("q", 0.0, 1.0) is None
    True
    """
    if lowest == highest:
        return said_constant(name, lowest)
    if max(abs(lowest), abs(highest)) < _SMALLEST:
        return f"{name!r} has no value above {_SMALLEST:g}: check its unit and its sensor"
    return None


def inspect_steps(time: FloatArray, signals: Mapping[str, FloatArray], before: int = 0) -> tuple[str, ...]:
    """Faults of positions that jump: rows are missing, the unit changes, a value is wrong, or a counter overflows.

    A jump is a step that differs from both the step before it and the one after it by far more than the steps
    nearby do. A change of speed, such as an impact, does not count. The positions or angles lack no values.

    Examples
    --------
    >>> t = np.arange(100) / 10.0
    >>> inspect_steps(t, {"q": np.sin(t) + (t > 5.0)})[0]
    "'q' jumps by 1.03 at t = 5.1 s (row 52): split the log there, or repair the channel"
    """
    faults = []
    for name, x in signals.items():
        jumps = _jumps(x)
        if jumps.size:
            first = int(jumps[0])
            more = f", and {describe(jumps.size - 1, 'time')} more" if jumps.size > 1 else ""
            faults.append(
                f"{name!r} jumps by {x[first] - x[first - 1]:.3g} at t = {time[first]:.7g} s "
                f"(row {before + first + 1}){more}: split the log there, or repair the channel"
            )
    return tuple(faults)


def _jumps(x: FloatArray) -> npt.NDArray[np.intp]:
    """Samples before which a position jumps."""
    if x.size < 2 * _NEAR:
        return np.zeros(0, dtype=np.intp)
    bend = np.abs(np.diff(x, 2))
    odd = np.minimum(bend[:-1], bend[1:])  # of the step from sample i + 1 to i + 2
    coarse = np.abs(np.diff(x))
    finest = float(np.min(coarse, where=coarse > 0, initial=np.inf))
    least = max(_JUMP_STEPS * finest, _JUMP_RANGE * float(np.ptp(x)))
    candidates = np.flatnonzero(odd > least)
    return np.array([i + 2 for i in candidates if _stands_out(odd, int(i))], dtype=np.intp)


def _stands_out(odd: FloatArray, place: int) -> bool:
    """Whether a step is far larger than those nearby, without its direct neighbours."""
    before, after = odd[max(place - _NEAR, 0) : max(place - 2, 0)], odd[place + 3 : place + 3 + _NEAR]
    return bool(odd[place] > _JUMP_RATIO * max(np.max(before, initial=0.0), np.max(after, initial=0.0)))


def said_constant(name: str, value: float) -> str:
    """Fault of a channel that never changes."""
    return (
        f"{name!r} is constant ({value:g}) over the whole log: "
        "check its sensor or leave it out of the measured signals"
    )
