"""What timing and bias mean for a result: a status where they spoil it, a note where one should know of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from symid.arrays import FloatArray
from symid.data import central_difference_gain
from symid.identification.result import Identification
from symid.identification.timing import Timing

_USUAL_LAG = 0.85
"""Samples by which a force may act after it is recorded, as a hold and the lag of a drive explain, for a mere note."""
_LARGE_BIAS = 0.05
"""Relative bias that makes a status of it."""
_CERTAIN = 2.0
"""Standard deviations that a change or a bias must have for a status."""
_FAITHFUL = 0.997
"""Gain of the differences at the cutoff above which they are not the cause of a bias."""


def distrust(found: Identification, misfit: str = "") -> Identification:
    """The identification with status, message and notes about its timing, its bias, and what contradicts it.

    A status that it has already stays, and learns of the timing as a possible cause.
    """
    timing = found.timing if found.timing is not None and found.timing.is_significant else None
    status, message, notes = found.status, found.message, list(found.notes)
    if timing is not None and status in ("ok", "poor_fit") and _is_fault(timing):
        status, message = "timing", timing.statement
    elif timing is not None and status != "ok":
        message = f"{message}; {timing.statement}"
    elif timing is not None:
        notes.append(timing.statement)
    if misfit and status == "ok":
        status, message = "poor_fit", misfit
    if names := found.dominated_by_bias:
        statement, is_large = _bias_statement(found, names)
        if status == "ok" and is_large:
            status, message = "biased", f"bias dominates; {statement}"
        else:
            notes.append(statement)
    return replace(found, status=status, message=message, notes=tuple(notes))


def _is_fault(timing: Timing) -> bool:
    """Whether a delay is more than what a held force and the lag of a drive explain.

    A force that acts before it is recorded has no natural cause.
    """
    return timing.late > 0 or timing.samples < -_USUAL_LAG


def _reported(found: Identification) -> tuple[FloatArray, FloatArray]:
    """Values and deviations of the physical parameters, of the minimal ones if there are none."""
    if not found.physical:
        return found.fit.parameters, found.standard_deviations
    return found.physical[0].parameters, found.physical[0].propagated_deviations(found.covariance)


def _bias_statement(found: Identification, names: tuple[str, ...]) -> tuple[str, bool]:
    """What the bias is, where it comes from and what to do; and whether it is large."""
    bias = found.physical_bias or found.bias
    assert bias is not None
    every = list(found.model.physical_units if found.physical else found.model.minimal_units)
    values, deviations = _reported(found)
    free = values - bias.total  # parameters that are 0 without their bias have no relative one
    relative = np.where(np.abs(free) > _CERTAIN * deviations, bias.total / np.abs(free), 0.0)
    large = (np.abs(bias.total) > _CERTAIN * deviations) & (np.abs(relative) > _LARGE_BIAS)
    places = [every.index(name) for name in names]
    share = np.sum(np.abs(bias.noise[places]) / deviations[places])
    rest = np.sum(np.abs(bias.preparation[places]) / deviations[places])
    cause = (
        "noise of the sensors in the columns of W: lower --cutoff, or take --method iv"
        if share > rest
        else _cause_of_preparation(found)
    )
    parts = (
        f"{name} ({_size(values[i], bias.total[i])}, {abs(bias.total[i]) / deviations[i]:.2g} standard deviations)"
        for name, i in zip(names, places, strict=True)
    )
    return f"intervals leave out the bias of {', '.join(parts)}: {cause}", bool(np.any(large))


def _size(value: float, bias: float) -> str:
    return f"{bias:+.2g}" if abs(bias) > abs(value) else f"{100 * bias / abs(value):+.2g} %"


def _cause_of_preparation(found: Identification) -> str:
    observation = found.observations[0]
    chosen = observation.preparation
    assert chosen.cutoff_hz is not None
    if not chosen.filter_force:
        return "the force is not filtered as the motion is: take --filter all"
    differences = max(found.model.highest_derivatives.values())
    order = chosen.difference_order
    gain = float(central_difference_gain(chosen.cutoff_hz, found.sampling_period, order=order)) ** differences
    if gain < _FAITHFUL:
        return "central differences lose what is fast: lower --cutoff, or record faster"
    return "the low-pass moves the reversals of friction: raise --cutoff"
