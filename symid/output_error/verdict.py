"""Status and notes of an identification by maximum likelihood."""

from __future__ import annotations

import numpy as np

from symid.identification import Identification
from symid.identification.criteria import CRITERIA, Criteria
from symid.identification.physical import negative_parameters
from symid.output_error.result import OutputErrorIdentification, Status

_VAGUE = 50.0
"""Standard deviation in percent from which on a parameter is hardly determined."""
_FORCES = ("N", "N*m")
_NO_FRICTION = 1e-3
"""Part of the force (rms) below which three deviations of a friction level determine that there is none."""
_CORRELATED = 1.5
"""Least ratio of the deviations of correlated innovations to those of white ones for a note."""
_MUCH_CORRELATED = 8.0
"""Such a ratio that is a fault by itself: EMPS, whose friction is not as declared, has 3 to 5."""


def verdict_of(
    found: OutputErrorIdentification, regression: Identification | None = None, criteria: Criteria = CRITERIA
) -> tuple[Status, str]:
    """Status of an estimate, and a sentence that says what it means and what to do; empty if all is well.

    Parameters
    ----------
    found : OutputErrorIdentification
        The estimate.
    regression : Identification, optional
        What least squares found in the same logs, examined: a fault of a channel that it names holds here too, and
        others where the innovations are not white either.
    criteria : Criteria
        What a result has to meet.
    """
    if found.fit is None:
        return (
            "no_start",
            "no start was possible: a log holds no lasting motion, or give nominal values with --nominal P.json",
        )
    minimum = found.fit.search.minimum
    if minimum is None or not minimum.converged:
        return (
            "not_converged",
            "the iterations did not come to rest: give nominal values with --nominal P.json",
        )
    values = np.array(list(found.physical_parameters.values()))
    absent = _absent(found)
    if below := [name for name in negative_parameters(found.model, values) if name not in absent]:
        return (
            "not_physical",
            f"{', '.join(below)} came out negative: the model, the timing or the log does not fit",
        )
    if vague := _vague(found, criteria.undetermined):
        return (
            "undetermined",
            f"the log does not determine {', '.join(vague)}: excite it more, or record longer",
        )
    if regression is not None and regression.status == "recording":
        return "recording", regression.message
    if _inflation(found) > _CORRELATED:
        if regression is not None and regression.status in ("timing", "poor_fit"):
            return ("timing" if regression.status == "timing" else "poor_fit"), regression.message
        if _inflation(found) > _MUCH_CORRELATED:
            return (
                "poor_fit",
                f"{_correlated_remark(found)}: the log is damaged, or the model lacks something",
            )
    return "ok", ""


def _vague(found: OutputErrorIdentification, most: float) -> list[str]:
    """Parameters whose deviation exceeds a share of their value, except those that may be 0 by declaration."""
    values = found.physical_parameters
    return [
        name
        for (name, value), deviation in zip(values.items(), found.physical_deviations, strict=True)
        if name not in (*found.model.signed, *_absent(found))
        and np.isfinite(value)
        and not deviation < most * abs(value)
    ]


def _absent(found: OutputErrorIdentification) -> frozenset[str]:
    """Friction levels that are found to be 0: within three deviations, which are small beside the force itself."""
    model = found.model
    force = max(float(np.sqrt(np.mean(log[model.force] ** 2))) for log in found.logs)
    units = {unit for unit in model.output_units if unit in _FORCES}
    rows = zip(
        model.physical_units.items(),
        found.physical_parameters.values(),
        found.physical_deviations,
        strict=True,
    )
    return frozenset(
        name
        for (name, unit), value, deviation in rows
        if unit in units and abs(value) <= 3 * deviation < _NO_FRICTION * force
    )


def _inflation(found: OutputErrorIdentification) -> float:
    """By how much correlation of the innovations raises deviations."""
    fit = found.fit
    return float(np.sqrt(fit.linear.rows[0] / max(fit.correlated.effective_samples, 1.0))) if fit else 1.0


def _correlated_remark(found: OutputErrorIdentification) -> str:
    assert found.fit is not None
    return (
        "the innovations are correlated, as if the model or the timing did not fit quite: "
        f"{found.fit.linear.rows[0]} of them are worth {found.fit.correlated.effective_samples:.0f}"
    )


def remarks_on(found: OutputErrorIdentification) -> tuple[str, ...]:
    """Notes on the estimate for the user."""
    if found.fit is None:
        return ()
    remarks = [_course_remark(found)]
    covariance = found.physical_covariance(corrected=True)
    values = np.array(list(found.physical_parameters.values()))
    with np.errstate(invalid="ignore", divide="ignore"):
        relative = 100 * np.sqrt(np.diag(covariance)) / np.abs(values)
    vague = [n for n, r in zip(found.model.physical_units, relative, strict=True) if r > _VAGUE]
    if vague:
        remarks.append(
            f"the log hardly determines {', '.join(vague)}: the standard deviation exceeds {_VAGUE:g} %"
        )
    fit = found.fit
    if _inflation(found) > _CORRELATED:
        remarks.append(_correlated_remark(found))
    highest = fit.search.dynamics.at(fit.search.parameters).highest_mode
    if highest:
        rate = found.logs[0].sampling_frequency
        remarks.append(
            f"the highest mode, {highest:.3g} Hz, is taken to lie below half the sampling frequency of {rate:g} Hz"
        )
    return tuple(remarks)


def _course_remark(found: OutputErrorIdentification) -> str:
    force, course = found.model.force, found.comparison.force
    if course == "simulated":
        return f"readings and {force} are compared with those of the simulated closed loop"
    if course == "held":
        return f"{force} is held from each sample to the next"
    if not found.comparison.free_timing:
        return f"{force} runs smoothly between its samples"
    samples = found.late / found.logs[0].sampling_period
    how = "later" if samples < 0 else "earlier"
    return (
        f"{force} runs smoothly between its samples and acts {abs(samples):.2f} samples {how} than recorded"
    )
