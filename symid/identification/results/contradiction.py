"""Contradictions between prior knowledge and the log, and the effect of bounds and priors."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from symid.arrays import FloatArray
from symid.identification.parameters.physical import PhysicalEstimate, Restricted
from symid.identification.results.identification_result import Identification

_INTERVAL = 1.96
"""Half width of the 95 % interval, in standard deviations."""
_FAR = 3.0
"""Deviations between a prior and the log beyond which they contradict each other."""


def with_constraint_check(found: Identification) -> Identification:
    """The identification with notes of its bounds and priors; "contradicted" where the log is against them.

    The log is against them where a value lies outside the 95 % interval of the estimate without them.
    """
    if not found.physical or found.physical[0].restricted is None:
        return found
    estimate, restricted = found.physical[0], found.physical[0].restricted
    notes = (*found.notes, *constraint_notes(found.model.physical_units, estimate))
    outside = against(found.model.physical_units, estimate, found.widened_deviations(restricted.free))
    if found.status not in ("ok", "undetermined") or not outside:
        return replace(found, notes=notes)
    message = f"bounds or priors contradict the log: {outside}: correct them, the model or the log"
    return replace(found, status="contradicted", message=message, notes=notes)


def with_fixed(found: Identification, alone: Identification) -> Identification:
    """An identification with known values, compared with the estimate of all parameters.

    Parameters
    ----------
    found : Identification
        With known values.
    alone : Identification
        Estimate from the same logs without known values.
    """
    if not alone.physical:
        return replace(
            found,
            notes=(*found.notes, "the log alone does not determine the parameters whose values are given"),
        )
    names = list(alone.model.physical_units)
    given = {name: value for name, (value, _) in found.model.known.items()} | found.physical_parameters
    values = np.array([given[name] for name in names])
    own, deviations = alone.physical[0].parameters, alone.physical_deviations
    known = [i for i, name in enumerate(names) if name not in found.model.physical_units]
    notes = tuple(
        f"{names[i]} is given as {values[i]:.6g} {unit}; the log alone says {own[i]:.6g} +- {deviations[i]:.2g}"
        for i, unit in enumerate(alone.model.physical_units.values())
        if i in known
    )
    outside = _outside(alone.model.physical_units, own, deviations, values)
    if not outside or (found.status != "ok" and alone.status != "ok"):
        return replace(found, notes=(*found.notes, *notes))
    message = f"given values contradict the log: {outside}: correct them, the model or the log"
    return replace(found, status="contradicted", message=message, notes=(*found.notes, *notes))


def against(units: Mapping[str, str], estimate: PhysicalEstimate, deviations: FloatArray) -> str:
    """Statement on values that the log, or the priors it needs, do not support; empty if there are none.

    `deviations` are those of the estimate by the log alone.
    """
    assert estimate.restricted is not None
    outside = _outside(units, estimate.restricted.free.parameters, deviations, estimate.parameters)
    return outside or _beyond_priors(units, estimate.parameters, estimate.restricted.instead)


def _outside(units: Mapping[str, str], own: FloatArray, deviations: FloatArray, values: FloatArray) -> str:
    """Statement on values outside the intervals of the unconstrained estimate; empty if all lie inside."""
    far = np.abs(values - own) > _INTERVAL * deviations
    return ", ".join(
        f"{name} is {values[i]:.4g} where the log alone says {own[i]:.4g} +- {deviations[i]:.2g} {unit}"
        for i, (name, unit) in enumerate(units.items())
        if far[i] and not np.isclose(values[i], own[i], rtol=1e-9, atol=0.0)
    )


def _beyond_priors(
    units: Mapping[str, str], values: FloatArray, instead: Mapping[int, tuple[float, float]]
) -> str:
    """Statement on values outside the 95 % intervals of the priors that determine them with the log; empty if none."""
    named = list(units.items())
    return ", ".join(
        f"{named[i][0]} is {values[i]:.4g} where its prior says {mean:.4g} +- {deviation:.2g} {named[i][1]}"
        for i, (mean, deviation) in instead.items()
        if abs(values[i] - mean) > _INTERVAL * deviation
    )


def constraint_notes(units: Mapping[str, str], estimate: PhysicalEstimate) -> tuple[str, ...]:
    """Bounds that hold an estimate, with their cost, and priors that narrow, contradict or replace the log."""
    assert estimate.restricted is not None
    restricted, named = estimate.restricted, list(units.items())
    held = [
        f"{named[i][0]} is held at its bound {estimate.parameters[i]:g} {named[i][1]}: "
        f"that costs {cost:.3g} in chi-square ({np.sqrt(cost):.2g} deviations)"
        for i, cost in restricted.held.items()
    ]
    return (*held, *_of_priors(named, estimate, restricted))


def _of_priors(
    named: Sequence[tuple[str, str]], estimate: PhysicalEstimate, restricted: Restricted
) -> list[str]:
    own, free, now = (
        restricted.free.parameters,
        restricted.free.standard_deviations,
        estimate.standard_deviations,
    )
    halved = [
        f"{name} ({before:.2g} to {after:.2g} {unit})"
        for (name, unit), before, after in zip(named, free, now, strict=True)
        if 0 < after < before / 2
    ]
    notes = [f"priors and bounds narrow {', '.join(halved)}: these say more than the log"] if halved else []
    for i, (mean, deviation) in restricted.priors.items():
        away = abs(mean - own[i]) / np.hypot(deviation, free[i])
        if away > _FAR:
            name, unit = named[i]
            notes.append(
                f"the prior of {name}, {mean:.4g} +- {deviation:.2g} {unit}, is {away:.2g} deviations from the "
                f"{own[i]:.4g} {unit} of the log alone"
            )
    if restricted.instead:
        rest = [named[i][0] for i in map(int, np.flatnonzero(np.isnan(free))) if np.isfinite(now[i])]
        notes.append(
            f"{', '.join(rest)} rest on the prior of {', '.join(named[i][0] for i in restricted.instead)}"
        )
    return notes
