"""What makes an estimate by maximum likelihood doubtful, in words; empty where nothing does."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symid.identification import CRITERIA, Identification
from symid.identification.deviations import LogEstimate, disagreement_between
from symid.identification.faults import unexplained_statement
from symid.identification.parameters import negative_parameters
from symid.identification.rows import noise_deviations
from symid.output_error.likelihood_result import OutputErrorIdentification

CORRELATED = 1.5
"""Least ratio of the deviations of correlated innovations to those of white ones for a note."""
_DISAGREE = 3.0
"""Difference of two methods, in deviations, that is accepted: deviations do not cover all errors of a method."""
_NOTICEABLE = 0.05
"""Relative difference of two methods below which it is not reported."""
_SEEN = 1e-6
"""Least part of a joint's motion, scaled to 1, that counts as unread."""
_DENSE = 20.0
"""Samples of a period from which derivatives and holds cost least squares no more than an honest deviation."""


def noise_doubt(result: OutputErrorIdentification) -> str:
    """Doubt about forces and accelerations that are mostly noise, beyond the noise that their spectra show."""
    log, parts, levels = result.logs[0], [], noise_deviations(result.model, result.logs[0])
    orders = {signal: sensor.order for signal, sensor in result.comparison.dynamics.sensors.items()}
    for signal, noise in result.noise.items():
        size = float(np.sqrt(np.mean(log[signal] ** 2)))
        seen = levels.get(signal, 0.0)
        is_position = orders.get(signal) in (0, 1)
        if not is_position and noise > max(CRITERIA.worst_fit * size, CRITERIA.noise_explains * seen):
            parts.append(f"{100 * noise / size:.3g} % of {signal}")
    return unexplained_statement(parts)


def change_doubt(result: OutputErrorIdentification) -> str:
    """Doubt about parameters that change within the logs."""
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


def log_doubt(alone: Sequence[OutputErrorIdentification]) -> str:
    """Doubt about a log whose own parameters, if they are ok, differ from those of the others."""
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


def regression_doubt(result: OutputErrorIdentification, regression: Identification | None) -> str:
    """Doubt about parameters that differ from those of a least-squares fit without a fault.

    Effects that the model lacks move both results, and need not be in their deviations. Where samples are sparse, a fit
    with a negative mass or stiffness is not compared: its deviations hold for values that no machine has.
    """
    if regression is None or regression.status not in ("ok", "undetermined"):
        return ""
    values, linear = result.physical_parameters, regression.physical_parameters
    if not has_dense_samples(result) and negative_parameters(result.model, np.array(list(linear.values()))):
        return ""
    spread = np.hypot(result.physical_deviations, replace(regression, discrepancies=()).physical_deviations)
    far = [
        f"{name} ({values[name]:.4g}, {linear[name]:.4g})"
        for name, deviation in zip(values, spread, strict=True)
        if abs(values[name] - linear[name]) > max(_DISAGREE * deviation, _NOTICEABLE * abs(linear[name]))
    ]
    cure = "one of them is biased; compare the logs' noise, timing and drive with what is declared"
    return f"least squares and output error differ in {', '.join(far)}: {cure}" if far else ""


def hidden_friction_doubt(result: OutputErrorIdentification) -> str:
    """Doubt about dry friction that no sensor of motion reads, where predictions from the force do not follow it.

    A predictor does not know whether such a joint sticks; masses on both sides of a spring were exchanged beside "ok".
    """
    fit = result.fit
    if fit is None or result.comparison.force == "simulated" or inflation_of(result) <= CORRELATED:
        return ""
    plant = fit.search.dynamics.at(fit.search.parameters)
    sensors = (plant.sensors[signal] for signal in result.model.measured)
    seen = [sensor.row / np.linalg.norm(sensor.row) for sensor in sensors if sensor.order in (0, 1)]
    dry = [law.direction / np.linalg.norm(law.direction) for law in plant.laws if law.can_hold]
    if not any(np.linalg.matrix_rank([*seen, row], tol=_SEEN) > len(seen) for row in dry):
        return ""
    return (
        f"{correlation_doubt(result)}: dry friction acts where no sensor reads the motion; give `controller`, so that "
        "the closed loop is simulated, or add a sensor there"
    )


def correlation_doubt(result: OutputErrorIdentification) -> str:
    """Doubt about correlated innovations."""
    assert result.fit is not None
    return (
        "the innovations are correlated, which suggests an error of model or timing: "
        f"{result.fit.linear.rows[0]} of them count as {result.fit.correlated.effective_samples:.0f}"
    )


def inflation_of(result: OutputErrorIdentification) -> float:
    """Ratio of the deviations of correlated innovations to those of white ones."""
    return result.fit.inflation if result.fit else 1.0


def has_dense_samples(result: OutputErrorIdentification) -> bool:
    """Whether each period of the highest mode holds many samples, and the course of the force between them is known."""
    if result.fit is None or result.comparison.force == "simulated":
        return False
    highest = result.fit.search.dynamics.at(result.fit.search.parameters).highest_mode
    return all(log.sampling_frequency > _DENSE * highest for log in result.logs)
