"""Consequences of timing and bias for a result: a status if they invalidate it, else a note."""

from dataclasses import dataclass, replace

import numpy as np

from symid.arrays import FloatArray
from symid.identification.criteria import CRITERIA
from symid.identification.delays.timing import Timing
from symid.identification.deviations.discrepancy import Discrepancy
from symid.identification.parameters.physical import open_by_structure
from symid.identification.results.identification_result import Identification
from symid.identification.results.status import Status, not_by_structure
from symid.signal_processing import central_difference_gain

_NOISE_IN_W = "noise of the sensors in the columns of W"
_EXCITE = "excite it more (other speeds, accelerations, frequencies), or record longer"


@dataclass(frozen=True)
class Faults:
    """Statements that contradict an estimate, empty without a fault: on samples, residual, clock, friction, force.

    `hint` is a possible cause of another status, not a status itself, `note` holds whatever the status is;
    `noise_alone` is whether the residual is no larger than the noise of the signals makes it.
    """

    recording: str = ""
    poor_fit: str = ""
    drift: str = ""
    missing_friction: str = ""
    constant_force: str = ""
    hint: str = ""
    note: str = ""
    noise_alone: bool = False


def with_faults(found: Identification, faults: Faults) -> Identification:
    """The identification with status, message and notes about all that was examined.

    A status that it has already stays, and learns of a fault or the timing as a possible cause. Otherwise the first of
    these is the status: a constant force, a fault of a channel, a friction law that is missing, the timing, a bias by
    noise, a poor fit, another bias, a parameter that is not determined.
    """
    timing = found.timing if found.timing is not None and _matters(found, found.timing) else None
    status, message, notes = found.status, found.message, list(found.notes)
    large_bias = ""
    if names := found.dominated_by_bias:
        statement, is_large = _bias_statement(found, names)
        large_bias = f"bias dominates; {statement}" if is_large else ""
        notes += [] if is_large else [statement]
    causes: list[tuple[Status, str]] = [
        ("undetermined", faults.constant_force),  # then all else that is tested means nothing
        ("recording", faults.recording),
        ("poor_fit", faults.missing_friction),
        ("timing", faults.drift),
        ("timing", timing.statement if timing and _is_fault(found, timing, faults.noise_alone) else ""),
        ("biased", large_bias if _NOISE_IN_W in large_bias else ""),
        ("poor_fit", faults.poor_fit),
        ("biased", large_bias),
    ]
    fault = next((cause for cause in causes if cause[1]), None)
    vague = _undetermined(found)
    stated = fault or (("undetermined", vague) if vague else None)
    if status == "ok" and stated:
        status, message = stated
    elif status != "ok":
        hints = [
            faults.constant_force,
            faults.recording,
            faults.missing_friction,
            faults.drift,
            timing.statement if timing is not None else "",
        ]
        message = "; ".join([message, *[hint for hint in hints if hint][:1]])
    if status != "ok" and faults.hint not in message:
        message = f"{message}; {faults.hint}"
    if timing is not None and timing.statement not in message:
        notes.append(timing.statement)
    notes += [faults.note] if faults.note else []
    return replace(found, status=status, message=message, notes=tuple(notes), fault=fault)


def with_discrepancies(found: Identification, discrepancies: tuple[Discrepancy, ...]) -> Identification:
    """An identification whose deviations cover lacking effects; if "ok", with a note where these are most of them."""
    wider = replace(found, discrepancies=discrepancies)
    if found.status != "ok":
        return wider
    status: Status
    status, message, notes = found.status, found.message, found.notes
    stated = found.physical[0].sensitivity if found.physical else np.eye(len(found.minimal_parameters))
    effects = ", ".join(dict.fromkeys(one.effect for one in discrepancies if one.moves(stated)))
    if found.physical:
        rows = zip(
            found.model.physical_units,
            np.abs(found.physical[0].parameters),
            found.physical_deviations,
            wider.physical_deviations,
            strict=True,
        )
        named = [
            f"{name} ({100 * wide / value:.2g} %)"
            for name, value, narrow, wide in rows
            if wide > CRITERIA.deviation_grown * narrow and wide > CRITERIA.precise * value > 0.0
        ]
        if named:
            notes += (
                f"deviations of {', '.join(named)} are mostly what the model may lack: the residual shows {effects}; "
                "run `symid diagnose`",
            )
        cause = f"the model may lack an effect that moves them ({effects}): run `symid diagnose`"
        if vague := _undetermined(wider, cause if effects else _EXCITE):
            status, message = "undetermined", vague
    return replace(wider, status=status, message=message, notes=notes)


def _undetermined(found: Identification, cure: str = _EXCITE) -> str:
    """Statement on physical parameters whose deviation exceeds their value, except those that may be 0."""
    if not found.physical:
        return ""
    values, deviations = found.physical[0].parameters, found.physical_deviations
    given = dict(zip(found.model.physical_units, values, strict=True))
    restricted = found.physical[0].restricted
    held = restricted.held if restricted else {}  # a bound says what the log does not
    vague = [
        f"{name} ({value:.2g} +- {deviation:.2g} {unit})"
        for i, ((name, unit), value, deviation) in enumerate(
            zip(found.model.physical_units.items(), values, deviations, strict=True)
        )
        if name not in found.model.signed
        and i not in held
        and not deviation < CRITERIA.undetermined * value
        and np.isfinite(value)
    ]
    if vague and (lost := [name for name in open_by_structure(found.model) if np.isfinite(given[name])]):
        return not_by_structure(lost)
    return f"the log does not determine {', '.join(vague)}: {cure}" if vague else ""


def _matters(found: Identification, timing: Timing) -> bool:
    """Whether there is a delay, and not a small one that explains little and leaves parameters in their intervals."""
    if not timing.is_significant or not timing.is_small or timing.remaining < CRITERIA.delay_explains:
        return timing.is_significant
    return abs(timing.samples) > CRITERIA.least_delay and is_beyond_intervals(found, timing.parameters)


def _is_fault(found: Identification, timing: Timing, noise_alone: bool) -> bool:
    """Whether a held force, the lag of a drive or noise do not explain a delay, or it moves parameters too far.

    A force that acts before it is recorded has no natural cause, unless that is a small part of a sample. In noise
    alone the force that a controller makes of the encoder's noise looks late.
    """
    natural = timing.is_force and (noise_alone or -CRITERIA.usual_lag <= timing.samples <= 0)
    return not (natural or timing.is_small) or is_beyond_intervals(found, timing.parameters)


def is_beyond_intervals(
    found: Identification, parameters: FloatArray, least: float = CRITERIA.large_bias
) -> bool:
    """Whether minimal parameters of an estimate without a fault differ by more than values and deviations allow.

    `least` is the change, as part of the value, from which it counts.
    """
    removed = found.bias.removed if found.bias is not None and found.bias.removed is not None else 0.0
    change = parameters - (found.fit.solution + removed)  # as it was before the bias was taken off
    if found.physical:
        values, deviations = found.physical[0].parameters, found.physical_deviations
        change = found.physical[0].sensitivity @ change
    else:
        values, deviations = found.fit.parameters, found.standard_deviations
    with np.errstate(invalid="ignore"):
        beyond = (np.abs(change) > CRITERIA.bias_certain * deviations) & (
            np.abs(change) > least * np.abs(values)
        )
    return bool(np.any(beyond))


def _reported(found: Identification) -> tuple[FloatArray, FloatArray]:
    """Values and deviations of the physical parameters; of the minimal ones without an inverse map."""
    if not found.physical:
        return found.fit.parameters, found.sampling_deviations
    return found.physical[0].parameters, found.physical[0].propagated_deviations(found.covariance)


def _bias_statement(found: Identification, names: tuple[str, ...]) -> tuple[str, bool]:
    """Statement on the size, source and cure of the bias, and whether it is large."""
    bias = found.physical_bias or found.bias
    assert bias is not None
    every = list(found.model.physical_units if found.physical else found.model.minimal_units)
    values, deviations = _reported(found)
    free = values - bias.total  # parameters that are 0 without their bias have no relative one
    certain = np.abs(free) > np.maximum(CRITERIA.bias_certain * deviations, 0.0)
    relative = np.divide(bias.total, np.abs(free), out=np.zeros_like(free), where=certain)
    large = (np.abs(bias.total) > CRITERIA.bias_certain * deviations) & (
        np.abs(relative) > CRITERIA.large_bias
    )
    places = [every.index(name) for name in names]
    share = np.sum(np.abs(bias.noise[places]) / deviations[places])
    rest = np.sum(np.abs(bias.preparation[places]) / deviations[places])
    cause = (
        f"{_NOISE_IN_W}: lower `cutoff_hz`, or take `method=iv`"
        if share > rest
        else _cause_of_preparation(found)
    )
    parts = []
    for name, i in zip(names, places, strict=True):
        total, value = bias.total[i], abs(values[i])
        size = f"{total:+.2g}" if abs(total) > value else f"{100 * total / value:+.2g} %"
        parts.append(f"{name} ({size}, {abs(total) / deviations[i]:.2g} standard deviations)")
    return f"deviations hold an expected bias of {', '.join(parts)}: {cause}", bool(np.any(large))


def _cause_of_preparation(found: Identification) -> str:
    observation = found.observations[0]
    chosen = observation.preparation
    assert chosen.cutoff_hz is not None
    if not chosen.filter_force:
        return "the force is not filtered as the motion is: take `filter_force=True`"
    differences = max(found.model.highest_derivatives.values())
    order = chosen.difference_order
    gain = float(central_difference_gain(chosen.cutoff_hz, found.sampling_period, order=order)) ** differences
    if gain < CRITERIA.gain_of_differences:
        return "central differences lose what is fast: lower `cutoff_hz`, or record faster"
    return "the low-pass moves the reversals of friction: raise `cutoff_hz`"
