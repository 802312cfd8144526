"""Identified parameters applied to another log."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from symid.arrays import FloatArray
from symid.axis import axis_of
from symid.data import Log, LongLog, in_memory
from symid.estimation import estimate, triangular_factors
from symid.identification.results.residuals import EquationResidual
from symid.identification.rows.observation import Observation, observe
from symid.identification.signals.axis_logs import LogLike, log_of

if TYPE_CHECKING:
    from symid.identification.results.identification_result import Identification


@dataclass(frozen=True, eq=False)
class OutputPrediction:
    """The output that identified parameters predict on a log."""

    log: str
    """Source of the log."""
    observation: Observation = field(repr=False)
    """The log, prepared as those that were identified."""
    parameters: FloatArray
    """The identified minimal parameters, those that differ from log to log (unknown zeros) fitted to this one;
    shape (n_parameters,)."""
    residuals: tuple[EquationResidual, ...]
    """How well each equation is met."""


def predict(found: Identification, log: LogLike) -> OutputPrediction:
    """Predict the output on another log.

    Parameters
    ----------
    found : Identification
        Result of `identify`.
    log : Log, path-like, data frame or mapping
        A log that took no part in it.

    Raises
    ------
    LogError, SettingError
        If the log does not have a signal, or cannot be prepared as the others were.
    """
    if not isinstance(log, (Log, LongLog)):
        log = log_of(found.axis or axis_of(found.model), log, found.model.measured)
    observation = observe(found.model, in_memory(log), found.observations[0].preparation)
    parameters = _with_own_parameters(found, observation)
    errors = observation.y - observation.W @ parameters
    residuals = (
        EquationResidual.of_rows(
            name, errors[j][observation.valid[j]], observation.y[j][observation.valid[j]]
        )
        for j, name in enumerate(found.model.output_names)
    )
    return OutputPrediction(log.source, observation, parameters, tuple(residuals))


def _with_own_parameters(found: Identification, observation: Observation) -> FloatArray:
    solution = found.fit.solution.copy()
    own = [i for i, name in enumerate(found.model.minimal_units) if name in found.model.per_log]
    if own:
        solution[own] = 0.0
        rest = observation.y - observation.W @ solution
        factors = triangular_factors(observation.W[:, :, own], rest, observation.valid)
        solution[own] = estimate(factors, "ols").solution
    return solution
