"""Status of an identification: reasons why it is incomplete, with cures."""

from collections.abc import Sequence
from typing import Literal

import numpy as np

from symid.arrays import FloatArray
from symid.codegen import GeneratedModel
from symid.estimation import CorrelatedCovariance, LeastSquares
from symid.identification.criteria import CRITERIA
from symid.identification.parameters.physical import PhysicalEstimate, open_by_structure

Status = Literal[
    "ok",
    "rank_deficient",
    "too_few_rows",
    "poorly_excited",
    "no_physical_parameters",
    "not_physical",
    "contradicted",
    "poor_fit",
    "timing",
    "biased",
    "undetermined",
    "recording",
    "weak_instruments",
]
OPEN: tuple[Status, ...] = ("ok", "no_physical_parameters", "not_physical", "undetermined")
"""Statuses of which only the physical parameters may be lacking: the minimal ones are as good as the log."""


_APART = 3.0
"""Deviations from which two solutions differ."""


def identification_status(
    model: GeneratedModel,
    fit: LeastSquares,
    physical: tuple[PhysicalEstimate, ...],
    correlated: CorrelatedCovariance | None = None,
    *,
    has_start: bool = False,
    deviations: FloatArray | None = None,
) -> tuple[Status, str]:
    """Status of an identification, and a sentence on its meaning and cure.

    `has_start` is whether nominal values were given as a start, `deviations` those of the physical parameters as they
    are printed, if not those of the estimate.
    """
    names = list(model.minimal_units)
    if fit.status == "too_few_rows":
        rows = f"{sum(fit.rows)} rows are left for {len(names)} parameters"
        return "too_few_rows", f"{rows}: give a longer log or `standstill=0`"
    is_open = correlated is not None and correlated.status != "ok"
    if is_open and sum(fit.rows) < CRITERIA.few_rows * len(names):
        rows = f"{sum(fit.rows)} rows are left for {len(names)} parameters, and they are not independent"
        return "too_few_rows", f"{rows}: give a longer log"
    if fit.status == "rank_deficient":
        missing = ", ".join(names[i] for i in fit.undetermined)
        return "rank_deficient", f"the log does not determine {missing}: {_missing_motion(model, fit)}"
    helped = bool(physical) and physical[0].restricted is not None
    vague = [n for n, r in zip(names, fit.relative_standard_deviations, strict=True) if not r < 50]
    if fit.condition_number_scaled > CRITERIA.highest_condition and not helped:
        return "poorly_excited", (
            f"the columns of W are nearly dependent (condition {fit.condition_number_scaled:.2g} scaled), and noise "
            f"decides on {', '.join(vague or names)}: move at several speeds, accelerations and frequencies"
        )
    if not physical:
        return "no_physical_parameters", _why_none(model, vague, has_start=has_start)
    if negative := certainly_negative(model, physical[0], deviations):
        return (
            "not_physical",
            f"{', '.join(negative)} are negative{_cause(model, physical[0], deviations)}",
        )
    if not model.known and (unexplained := poorly_fitted(model, fit)):
        cause = "a column or unit differs from its declaration, the log is damaged, or the model does not fit"
        return "poor_fit", f"the parameters leave {unexplained}: {cause}"
    if not has_start and (several := _several(model, physical)):
        return "undetermined", several
    return "ok", ""


def _several(model: GeneratedModel, physical: tuple[PhysicalEstimate, ...]) -> str:
    """Statement on possible solutions of the inverse map that differ; empty if there is one, or all agree."""
    possible = [one for one in physical if not one.negative(model)]
    if len(possible) < 2:
        return ""
    values = np.stack([one.parameters for one in possible], axis=1)
    apart = np.ptp(values, axis=1) > _APART * np.max([one.standard_deviations for one in possible], axis=0)
    units = model.physical_units.items()
    named = [
        f"{name} {' or '.join(f'{value:.4g}' for value in row)} {unit}"
        for (name, unit), row, differ in zip(units, values, apart, strict=True)
        if differ
    ]
    if not named:
        return ""
    return (
        f"{len(possible)} sets of values fit the log alike ({', '.join(named)}): give `nominal` values near the "
        "machine's, what is known with `fixed`, or add a sensor"
    )


def _why_none(model: GeneratedModel, vague: list[str], *, has_start: bool) -> str:
    """Reason why there are no physical parameters, and the cure."""
    if model.physical_parameters is not None:
        cause = "the model, the filter, the timing or the log does not fit"
        if vague:
            cause = (
                f"noise decides on {', '.join(vague)}: move at other speeds, accelerations and frequencies"
            )
        return f"the inverse map gives no finite values: {cause}"
    if lost := open_by_structure(model):
        return not_by_structure(lost)
    if has_start:
        return (
            "no single solution was found from the nominal values: give what is known with `fixed`, add a sensor, or "
            "correct the nominal values"
        )
    return (
        "the inverse map has no closed form, and a search finds no single solution: give `nominal`, values to start "
        "from"
    )


def not_by_structure(names: Sequence[str]) -> str:
    """Statement on parameters that no motion determines, and what to give."""
    return (
        f"these signals do not determine {', '.join(names)}, however the axis moves: give one with `fixed` or `prior`, "
        "a payload that is `known` in each of several logs, or add a sensor"
    )


def certainly_negative(
    model: GeneratedModel, estimate: PhysicalEstimate, deviations: FloatArray | None
) -> tuple[str, ...]:
    """Negative parameters whose deviation is smaller than the value; the others are not determined."""
    certain = _certain(model, estimate, deviations)
    return tuple(name for name in estimate.negative(model) if name in certain)


def _certain(model: GeneratedModel, estimate: PhysicalEstimate, deviations: FloatArray | None) -> set[str]:
    """Parameters whose value exceeds its deviation."""
    own = estimate.standard_deviations if deviations is None else deviations
    return {
        name
        for name, value, std in zip(model.physical_units, estimate.parameters, own, strict=True)
        if abs(value) > std
    }


def _cause(model: GeneratedModel, estimate: PhysicalEstimate, deviations: FloatArray | None) -> str:
    """Cause of negative parameters: a sign if all that the log determines are negative."""
    certain = _certain(model, estimate, deviations) - set(model.signed)
    if certain <= set(estimate.negative(model)):
        forces = " or ".join(dict.fromkeys(model.output_names))
        return f", as all that the log determines: the sign of {forces} or of a position is wrong"
    return ": the model, a sign, the filter, the timing or the log does not fit"


def poorly_fitted(model: GeneratedModel, fit: LeastSquares) -> str:
    """Outputs with a large residual, and its share; equations are ordered log by log."""
    names = model.output_names
    norms = np.reshape((fit.residual_norm, fit.y_norm), (2, -1, len(names)))
    residual, y = np.sqrt(np.sum(norms**2, axis=1))
    shares = np.divide(residual, y, out=np.zeros_like(y), where=y > 0)
    return ", ".join(
        f"{100 * share:.3g} % of {name}"
        for name, share in zip(names, shares, strict=True)
        if share > CRITERIA.worthless_fit
    )


def _missing_motion(model: GeneratedModel, fit: LeastSquares) -> str:
    """Motion that a log needs for the dependent columns to differ, by the signals that they multiply."""
    units = list(model.minimal_units.values())
    directions = fit.rank.null_space
    involved = {units[i] for i in np.flatnonzero(np.abs(directions[:, 0]) > 1e-6)}
    if involved <= {"N", "N*m", "A", "V"}:
        return "move in both directions"
    if {"kg", "kg*m^2"} & involved and {"N*s/m", "N*m*s/rad"} & involved:
        return "move at several speeds and accelerations"
    return "excite the axis with more frequencies (a chirp or a multisine around its resonance)"
