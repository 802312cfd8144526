"""Statements on all faults that contradict an estimate: of channels, of parts of the logs, of the structure."""

from collections.abc import Sequence

import numpy as np

from symid.estimation import LeastSquares
from symid.identification.criteria import CRITERIA
from symid.identification.delays.lag_scan import shown_late
from symid.identification.deviations.stability import Change
from symid.identification.deviations.whitened import whitened
from symid.identification.faults.constant_force import constant_force, friction_unseen
from symid.identification.faults.lagging import ac_coupling_of, smoothing_by_residual
from symid.identification.faults.missing_friction import friction_shape, missing_friction
from symid.identification.faults.modes import aliasing_of, lost_mode, mode_above
from symid.identification.faults.nonlinearity import ColumnTests
from symid.identification.faults.one_direction import one_direction
from symid.identification.faults.poor_fit import contradicting_part, unexplained, unexplained_outputs
from symid.identification.faults.recording import recording_fault
from symid.identification.faults.redundancy import disagreement_of
from symid.identification.faults.smoothing import slow_update, smoothing_of
from symid.identification.parameters.physical import jacobian
from symid.identification.results.identification_result import Identification
from symid.identification.results.reliability import Faults, is_beyond_intervals
from symid.identification.rows.excerpts import Excerpt


def faults_of(
    result: Identification,
    fit: LeastSquares,
    parts: Sequence[Excerpt],
    change: Change | None,
    drift: str,
    *,
    noise_alone: bool,
) -> Faults:
    """Statements on faults that contradict the estimate: a channel, a part of the logs, the force or its clock.

    `noise_alone` is whether the residual is no larger than the noise of the signals makes it.
    """
    model = result.model
    shown = shown_late(model, noise_alone=noise_alone)
    inflation = rows_per_independent(result)
    more = ColumnTests(model, parts, fit, list(whitened(parts, fit)), inflation)
    alike, friction_holds = one_direction(model, parts)
    return Faults(
        recording=recording_fault(model, parts, fit)
        or smoothing_of(model, parts)
        or aliasing_of(model, parts)
        or disagreement_of(model, parts)
        or ac_coupling_of(result, parts, fit, shown)
        or ("" if drift else smoothing_by_residual(result, parts, fit, shown))
        or ("" if drift else more.sensor_gain() or more.uneven_gain()),  # a lag changes gains too
        poor_fit=contradicting_part(model, parts, fit)
        or more.force_nonlinearity()
        or _change_statement(result, change)
        or more.gain_drift()
        or friction_shape(more, result)
        or more.force_limit()
        or _structure_fault(result)
        or _mode_beyond_band(result, parts, fit)
        or ("" if model.known else unexplained_outputs(model, parts, fit)),  # known parts are off the output
        drift=drift,
        missing_friction=missing_friction(more, result, result.timing),
        noise_alone=noise_alone,
        constant_force=constant_force(model, parts) or alike,
        note=friction_holds or friction_unseen(model, parts),
        hint=next(filter(None, (slow_update(part.log[f], f) for part in parts for f in model.forces)), ""),
    )


def rows_per_independent(result: Identification) -> float:
    """Rows for each one that is independent of the others, as their residual is correlated."""
    return sum(result.fit.rows) / max(result.correlated.effective_samples, 1.0)


def _change_statement(result: Identification, change: Change | None) -> str:
    """Statement on a span of the logs whose parameters differ; empty unless they distort the others or explain much."""
    if change is None:
        return ""
    signed = np.zeros(change.inside.size, dtype=bool)
    # minimal parameters of which all parts may be negative, such as an offset of the force
    if result.physical:
        slopes = jacobian(result.model, result.physical[0].parameters)
        positive = [name not in result.model.signed for name in result.model.physical_units]
        signed = ~np.any(slopes[:, positive], axis=1)
    return change.statement(result.model, signed, distorts=is_beyond_intervals(result, change.outside))


def _structure_fault(result: Identification) -> str:
    """Statement on an axis whose minimal parameters contradict each other, or that lost its mode; else empty."""
    if not result.physical:
        return ""
    if result.physical[0].disagreement_probability < CRITERIA.disagreement:
        return (
            "relations between the minimal parameters do not hold (probability "
            f"{result.physical[0].disagreement_probability:.1g}): the model lacks an effect, or a signal was filtered "
            "before it was recorded"
        )
    minimal = np.asarray(result.model.minimal_parameters(*result.physical[0].parameters))
    return lost_mode(result.model, minimal, result.observations[0].preparation.cutoff_hz or 1.0)


def _mode_beyond_band(result: Identification, parts: Sequence[Excerpt], fit: LeastSquares) -> str:
    """Statement on a mode above the cutoff of a model that does not describe even what lies below; else empty."""
    cutoff = result.observations[0].preparation.cutoff_hz
    if result.model.known or cutoff is None:
        return ""
    if np.max(unexplained(result.model, parts, fit)) <= CRITERIA.cutoff_fit:
        return ""
    return mode_above(result.model, fit.solution, cutoff)
