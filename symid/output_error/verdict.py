"""What keeps an identification by maximum likelihood from being complete, and what its user should know."""

from __future__ import annotations

import numpy as np

from symid.identification.physical import negative_parameters
from symid.output_error.result import OutputErrorIdentification, Status

_VAGUE = 50.0
"""Standard deviation in percent from which on a parameter is hardly determined."""
_CORRELATED = 1.5
"""Ratio of the deviations of correlated innovations to those of white ones that is told."""


def verdict_of(found: OutputErrorIdentification) -> tuple[Status, str]:
    """Status of an estimate, and a sentence that says what it means and what to do; empty if all is well."""
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
    deviations = np.sqrt(np.diag(found.physical_covariance(corrected=True)))
    values = np.array(list(found.physical_parameters.values()))
    if below := negative_parameters(found.model, values):
        return (
            "not_physical",
            f"{', '.join(below)} came out negative: the model, the timing or the log does not fit",
        )
    return "ok", ""


def remarks_on(found: OutputErrorIdentification) -> tuple[str, ...]:
    """What the user should know about the estimate."""
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
    inflation = np.sqrt(fit.linear.rows[0] / max(fit.correlated.effective_samples, 1.0))
    if inflation > _CORRELATED:
        remarks.append(
            "the innovations are correlated, as if the model or the timing did not fit quite: "
            f"{fit.linear.rows[0]} of them are worth {fit.correlated.effective_samples:.0f}"
        )
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
