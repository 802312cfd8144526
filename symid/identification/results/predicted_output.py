"""Identified parameters applied to another log."""

from dataclasses import dataclass, field

from symid.arrays import FloatArray
from symid.axis import Axis, axis_of
from symid.codegen import GeneratedModel
from symid.data import Log, LongLog, in_memory
from symid.estimation import LeastSquares, estimate, triangular_factors
from symid.identification.results.residuals import EquationResidual
from symid.identification.rows.observation import Observation, observe
from symid.identification.rows.settings import Preparation
from symid.identification.signals.axis_logs import LogLike, log_of


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


def predicted_output(
    model: GeneratedModel, fit: LeastSquares, preparation: Preparation, log: LogLike, axis: Axis | None
) -> OutputPrediction:
    """The output that a fit predicts on a log, which is prepared as given."""
    if not isinstance(log, (Log, LongLog)):
        log = log_of(axis or axis_of(model), log, model.measured)
    observation = observe(model, in_memory(log), preparation)
    parameters = _with_own_parameters(model, fit, observation)
    errors = observation.y - observation.W @ parameters
    residuals = (
        EquationResidual.of_rows(
            name, errors[j][observation.valid[j]], observation.y[j][observation.valid[j]]
        )
        for j, name in enumerate(model.output_names)
    )
    return OutputPrediction(log.source, observation, parameters, tuple(residuals))


def _with_own_parameters(model: GeneratedModel, fit: LeastSquares, observation: Observation) -> FloatArray:
    solution = fit.solution.copy()
    own = [i for i, name in enumerate(model.minimal_units) if name in model.per_log]
    if own:
        solution[own] = 0.0
        rest = observation.y - observation.W @ solution
        factors = triangular_factors(observation.W[:, :, own], rest, observation.valid)
        solution[own] = estimate(factors, "ols").solution
    return solution
