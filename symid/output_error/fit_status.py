"""Status and notes of an identification by maximum likelihood."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symid.identification import CRITERIA, Identification
from symid.identification.deviations import LogEstimate, disagreement_between
from symid.identification.faults import unexplained_statement
from symid.identification.parameters import negative_parameters, open_by_structure
from symid.identification.results import not_by_structure
from symid.identification.rows import noise_deviations
from symid.output_error.controller_check import controller_mismatch
from symid.output_error.likelihood_result import OutputErrorIdentification, Status

_EXCITE = "excite it more, or record longer"
_VAGUE = 50.0
"""Standard deviation in percent above which a parameter is hardly determined."""
_FORCES = ("N", "N*m")
_NO_FRICTION = 1e-3
"""Three deviations of a friction level, as a share of the rms force, below which the friction counts as absent."""
_CORRELATED = 1.5
"""Least ratio of the deviations of correlated innovations to those of white ones for a note."""
_DISAGREE = 3.0
"""Difference of two methods, in deviations, that is accepted: deviations do not cover all errors of a method."""
_NOTICEABLE = 0.05
"""Relative difference of two methods below which it is not reported."""
_SEEN = 1e-6
"""Least part of a joint's motion, scaled to 1, that counts as unread."""
_DENSE = 20.0
"""Samples of a period from which derivatives and holds cost least squares no more than an honest deviation."""
_MUCH_CORRELATED = 8.0
"""Such a ratio that is a fault by itself. EMPS, whose friction deviates from the declared one, has 3 to 5."""


def verdict_of(
    result: OutputErrorIdentification,
    regression: Identification | None = None,
    alone: Sequence[OutputErrorIdentification] = (),
) -> tuple[Status, str]:
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
    if doubt := _hidden_friction_remark(result):
        return "poor_fit", doubt
    if unknown := undetermined(result):
        return unknown
    if regression is not None and (fault := fault_of(result, regression)):
        return fault, regression.message
    if doubt := (
        _noise_remark(result)
        or _change_remark(result)
        or _log_remark(alone)
        or _regression_remark(result, regression)
    ):
        return "poor_fit", doubt
    # Innovations at the rate of the samples show little of slow forces that the model lacks: least squares do.
    is_correlated = _inflation(result) > _CORRELATED
    if regression is not None and regression.status == "poor_fit" and (is_correlated or _is_dense(result)):
        return "poor_fit", regression.message
    if is_correlated:
        if regression is not None and regression.status == "timing":
            return "timing", regression.message
        if _inflation(result) > _MUCH_CORRELATED:
            return (
                "poor_fit",
                f"{_correlated_remark(result)}: the log is damaged, or the model lacks an effect",
            )
    return "ok", ""


def undetermined(result: OutputErrorIdentification, cure: str = _EXCITE) -> tuple[Status, str] | None:
    """The status of an estimate of which the logs do not determine a parameter; None if they determine all."""
    vague = _uncertain_parameters(result, CRITERIA.undetermined)
    if not vague:
        return None
    if lost := open_by_structure(result.model):
        return "undetermined", not_by_structure(lost)
    return "undetermined", f"the log does not determine {', '.join(vague)}: {cure}"


def fault_of(result: OutputErrorIdentification, regression: Identification) -> Status | None:
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
        return "not_physical" if _is_dense(result) else None
    return "recording" if regression.status == "recording" else None


def _is_dense(result: OutputErrorIdentification) -> bool:
    """Whether each period of the highest mode holds many samples, and the course of the force between them is known."""
    if result.fit is None or result.comparison.force == "simulated":
        return False
    highest = result.fit.search.dynamics.at(result.fit.search.parameters).highest_mode
    return all(log.sampling_frequency > _DENSE * highest for log in result.logs)


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


def _noise_remark(result: OutputErrorIdentification) -> str:
    """Remark on forces and accelerations that are mostly noise, beyond the noise that their spectra show."""
    log, parts, levels = result.logs[0], [], noise_deviations(result.model, result.logs[0])
    orders = {signal: sensor.order for signal, sensor in result.comparison.dynamics.sensors.items()}
    for signal, noise in result.noise.items():
        size = float(np.sqrt(np.mean(log[signal] ** 2)))
        seen = levels.get(signal, 0.0)
        is_position = orders.get(signal) in (0, 1)
        if not is_position and noise > max(CRITERIA.worst_fit * size, CRITERIA.noise_explains * seen):
            parts.append(f"{100 * noise / size:.3g} % of {signal}")
    return unexplained_statement(parts)


def _change_remark(result: OutputErrorIdentification) -> str:
    fit = result.fit
    if fit is None or fit.change is None:
        return ""
    inside, outside, names = fit.change.inside, fit.change.outside, fit.search.seen
    moved = np.abs(inside - outside)
    certain = (moved > CRITERIA.change_certain * fit.change.deviations) & (
        moved > CRITERIA.change * np.maximum(np.abs(inside), np.abs(outside))
    )
    certain[len(names) :] = False  # noise ratios
    if not certain.any():
        return ""
    i = fit.change.most_certain(certain)
    return (
        f"parameters change within the logs: in a part {names[i]} is {inside[i]:.4g}, elsewhere {outside[i]:.4g}: "
        "gain, payload or machine change, or a part is damaged; identify the parts apart (`trim`)"
    )


def _log_remark(alone: Sequence[OutputErrorIdentification]) -> str:
    """Remark on a log whose own parameters, if they are ok, differ from those of the others."""
    each = [
        LogEstimate(
            ", ".join(log.source for log in single.logs),
            np.array(list(single.physical_parameters.values())),
            single.physical_deviations,
        )
        for single in alone
        if single.status == "ok"
    ]
    return disagreement_between(list(alone[0].model.physical_units), each) if each else ""


def _regression_remark(result: OutputErrorIdentification, regression: Identification | None) -> str:
    """Remark on parameters that differ from those of a least-squares fit without a fault.

    Effects that the model lacks move both results, and need not be in their deviations. Where samples are sparse, a fit
    with a negative mass or stiffness is not compared: its deviations hold for values that no machine has.
    """
    if regression is None or regression.status not in ("ok", "undetermined"):
        return ""
    values, linear = result.physical_parameters, regression.physical_parameters
    if not _is_dense(result) and negative_parameters(result.model, np.array(list(linear.values()))):
        return ""
    spread = np.hypot(result.physical_deviations, replace(regression, discrepancies=()).physical_deviations)
    far = [
        f"{name} ({values[name]:.4g}, {linear[name]:.4g})"
        for name, deviation in zip(values, spread, strict=True)
        if abs(values[name] - linear[name]) > max(_DISAGREE * deviation, _NOTICEABLE * abs(linear[name]))
    ]
    cure = "one of them is biased; compare the logs' noise, timing and drive with what is declared"
    return f"least squares and output error differ in {', '.join(far)}: {cure}" if far else ""


def _hidden_friction_remark(result: OutputErrorIdentification) -> str:
    """Remark on dry friction that no sensor of motion reads, where predictions from the force do not follow it.

    A predictor does not know whether such a joint sticks; masses on both sides of a spring were exchanged beside "ok".
    """
    fit = result.fit
    if fit is None or result.comparison.force == "simulated" or _inflation(result) <= _CORRELATED:
        return ""
    plant = fit.search.dynamics.at(fit.search.parameters)
    sensors = (plant.sensors[signal] for signal in result.model.measured)
    seen = [sensor.row / np.linalg.norm(sensor.row) for sensor in sensors if sensor.order in (0, 1)]
    dry = [law.direction / np.linalg.norm(law.direction) for law in plant.laws if law.can_hold]
    if not any(np.linalg.matrix_rank([*seen, row], tol=_SEEN) > len(seen) for row in dry):
        return ""
    return (
        f"{_correlated_remark(result)}: dry friction acts where no sensor reads the motion; give `controller`, so that "
        "the closed loop is simulated, or add a sensor there"
    )


def _inflation(result: OutputErrorIdentification) -> float:
    return result.fit.inflation if result.fit else 1.0


def _correlated_remark(result: OutputErrorIdentification) -> str:
    assert result.fit is not None
    return (
        "the innovations are correlated, which suggests an error of model or timing: "
        f"{result.fit.linear.rows[0]} of them count as {result.fit.correlated.effective_samples:.0f}"
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
    if _inflation(result) > _CORRELATED:
        remarks.append(_correlated_remark(result))
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
