"""Status and notes of an identification by maximum likelihood."""

from collections.abc import Sequence

import numpy as np

from symid.identification import CRITERIA, Identification
from symid.identification.parameters import negative_parameters, open_by_structure
from symid.identification.results import not_by_structure
from symid.output_error.controller_check import controller_mismatch
from symid.output_error.fit_doubts import (
    CORRELATED,
    change_doubt,
    correlation_doubt,
    has_dense_samples,
    hidden_friction_doubt,
    inflation_of,
    log_doubt,
    noise_doubt,
    regression_doubt,
)
from symid.output_error.likelihood_result import LikelihoodStatus, OutputErrorIdentification

_EXCITE = "excite it more, or record longer"
_VAGUE = 50.0
"""Standard deviation in percent above which a parameter is hardly determined."""
_FORCES = ("N", "N*m")
_NO_FRICTION = 1e-3
"""Three deviations of a friction level, as a share of the rms force, below which the friction counts as absent."""
_MUCH_CORRELATED = 8.0
"""`inflation_of` that is a fault by itself. EMPS, whose friction deviates from the declared one, has 3 to 5."""


def likelihood_status(
    result: OutputErrorIdentification,
    regression: Identification | None = None,
    alone: Sequence[OutputErrorIdentification] = (),
) -> tuple[LikelihoodStatus, str]:
    """Status of an estimate, and a sentence on its meaning and cure; empty for "ok".

    A fault of a channel that least squares found in the same logs holds here too, and others where the innovations are
    not white either. `alone` are the results of each of several logs.
    """
    if result.fit is None:
        return (
            "no_start",
            "no start can be evaluated: a log holds no lasting motion, or no sensor sees where a free body is; give "
            "`nominal`, values to start from, measure its position, or take `method=wls`",
        )
    minimum = result.fit.search.minimum
    if minimum is None or not minimum.converged:
        return ("not_converged", "the iterations did not converge: give `nominal`, values to start from")
    mismatch = controller_mismatch(result.fit)
    if mismatch and (contradiction := mismatch.statement(result.fit.search.seen)):
        return "poor_fit", contradiction
    values = np.array(list(result.physical_parameters.values()))
    absent = _absent_friction(result)
    if below := [name for name in negative_parameters(result.model, values) if name not in absent]:
        return (
            "not_physical",
            f"{', '.join(below)} are negative: the model, the timing or the log does not fit",
        )
    if doubt := hidden_friction_doubt(result):
        return "poor_fit", doubt
    if unknown := undetermined(result):
        return unknown
    if regression is not None and (fault := fault_by_regression(result, regression)):
        return fault, regression.message
    if doubt := (
        noise_doubt(result)
        or change_doubt(result)
        or log_doubt(alone)
        or regression_doubt(result, regression)
    ):
        return "poor_fit", doubt
    return _status_by_innovations(result, regression)


def _status_by_innovations(
    result: OutputErrorIdentification, regression: Identification | None
) -> tuple[LikelihoodStatus, str]:
    """Status by the correlation of the innovations.

    At the rate of the samples they show little of slow forces that the model lacks: least squares do.
    """
    is_correlated = inflation_of(result) > CORRELATED
    if (
        regression is not None
        and regression.status == "poor_fit"
        and (is_correlated or has_dense_samples(result))
    ):
        return "poor_fit", regression.message
    if is_correlated:
        if regression is not None and regression.status == "timing":
            return "timing", regression.message
        if inflation_of(result) > _MUCH_CORRELATED:
            return (
                "poor_fit",
                f"{correlation_doubt(result)}: the log is damaged, or the model lacks an effect",
            )
    return "ok", ""


def undetermined(
    result: OutputErrorIdentification, cure: str = _EXCITE
) -> tuple[LikelihoodStatus, str] | None:
    """The status of an estimate of which the logs do not determine a parameter; None if they determine all."""
    vague = _uncertain_parameters(result, CRITERIA.undetermined)
    if not vague:
        return None
    if lost := open_by_structure(result.model):
        return "undetermined", not_by_structure(lost)
    return "undetermined", f"the log does not determine {', '.join(vague)}: {cure}"


def fault_by_regression(
    result: OutputErrorIdentification, regression: Identification
) -> LikelihoodStatus | None:
    """The fault of a log that least squares found, if it holds for output error too.

    A delay is estimated with the parameters; a lag or a drifting clock is not, and biases the parameters beside white
    innovations too. Parameters that are not physical are a fault where samples are dense enough for accurate
    derivatives.
    """
    if regression.status == "timing":
        delay = regression.timing.statement if regression.timing is not None else ""
        return None if delay and regression.message.startswith(delay) else "timing"
    has_inverse = regression.model.physical_parameters is not None
    if regression.status == "not_physical" or (regression.status == "no_physical_parameters" and has_inverse):
        return "not_physical" if has_dense_samples(result) else None
    return "recording" if regression.status == "recording" else None


def _uncertain_parameters(result: OutputErrorIdentification, most: float) -> list[str]:
    """Parameters whose deviation exceeds a share of their value, except those that may be 0 by declaration."""
    values = result.physical_parameters
    return [
        name
        for (name, value), deviation in zip(values.items(), result.physical_deviations, strict=True)
        if name not in (*result.model.signed, *_absent_friction(result))
        and np.isfinite(value)
        and not deviation < most * abs(value)
    ]


def _absent_friction(result: OutputErrorIdentification) -> frozenset[str]:
    """Friction levels that are 0 within three deviations, where these are small compared with the force."""
    model = result.model
    force = max(float(np.sqrt(np.mean(log[name] ** 2))) for log in result.logs for name in model.forces)
    units = {unit for unit in model.output_units if unit in _FORCES}
    rows = zip(
        model.physical_units.items(),
        result.physical_parameters.values(),
        result.physical_deviations,
        strict=True,
    )
    return frozenset(
        name
        for (name, unit), value, deviation in rows
        if unit in units and abs(value) <= 3 * deviation < _NO_FRICTION * force
    )


def remarks_on(result: OutputErrorIdentification) -> tuple[str, ...]:
    """Notes on the estimate for the user."""
    if result.fit is None:
        return ()
    remarks = [_course_remark(result)]
    covariance = result.physical_covariance(corrected=True)
    values = np.array(list(result.physical_parameters.values()))
    with np.errstate(invalid="ignore", divide="ignore"):
        relative = 100 * np.sqrt(np.diag(covariance)) / np.abs(values)
    vague = [n for n, r in zip(result.model.physical_units, relative, strict=True) if r > _VAGUE]
    if vague:
        remarks.append(
            f"the log hardly determines {', '.join(vague)}: the standard deviation exceeds {_VAGUE:g} %"
        )
    fit = result.fit
    if inflation_of(result) > CORRELATED:
        remarks.append(correlation_doubt(result))
    highest = fit.search.dynamics.at(fit.search.parameters).highest_mode
    if highest:
        remarks.append(
            f"the highest mode, {highest:.3g} Hz, is taken to lie below half the sampling frequency of "
            f"{result.logs[0].sampling_frequency:g} Hz"
        )
    return tuple(remarks)


def _course_remark(result: OutputErrorIdentification) -> str:
    force, course = " and ".join(result.model.forces), result.comparison.force
    several = len(result.model.forces) > 1
    if course == "simulated":
        return (
            f"readings and {force} are compared with those of the simulated closed loop; the deviations take the gains "
            "of its controller as exact"
        )
    if course == "held":
        return f"{force} {'are' if several else 'is'} held from each sample to the next"
    if not result.comparison.free_timing:
        return f"{force} run{'' if several else 's'} smoothly between samples"
    samples = result.late / result.logs[0].sampling_period
    how = "later" if samples < 0 else "earlier"
    return (
        f"{force} run{'' if several else 's'} smoothly between samples and act{'' if several else 's'} "
        f"{abs(samples):.2f} samples {how} than recorded"
    )
