"""Results of an identification, with the data that they come from."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
import polars as pl

from symid.arrays import FloatArray
from symid.axis import Axis
from symid.codegen import GeneratedModel
from symid.data import Log
from symid.estimation import CorrelatedCovariance, LeastSquares
from symid.identification.delays.timing import Timing
from symid.identification.deviations.bias import Bias
from symid.identification.deviations.discrepancy import Discrepancy
from symid.identification.deviations.whitened import Segment
from symid.identification.parameters.physical import PhysicalEstimate
from symid.identification.results.predicted_output import OutputPrediction, predicted_output
from symid.identification.results.residuals import EquationResidual
from symid.identification.results.status import Status
from symid.identification.rows.observation import Observation
from symid.identification.signals.axis_logs import LogLike
from symid.shown import Shown

_MOST_WRITTEN = 6


class EstimatedParameters:
    """Minimal and physical parameters by name, of a least squares fit and the branches of the inverse map."""

    model: GeneratedModel
    fit: LeastSquares
    physical: tuple[PhysicalEstimate, ...]

    @property
    def minimal_parameters(self) -> dict[str, float]:
        """Minimal parameters by name, SI."""
        return dict(zip(self.model.minimal_units, map(float, self.fit.parameters), strict=True))

    @property
    def physical_parameters(self) -> dict[str, float]:
        """Physical parameters of the first branch by name, SI; empty without a branch."""
        if not self.physical:
            return {}
        return dict(zip(self.model.physical_units, map(float, self.physical[0].parameters), strict=True))

    def _as_frame(self, deviations: FloatArray, of_physical: FloatArray) -> pl.DataFrame:
        """Rows of `to_frame`, with the deviations of the minimal and of the physical parameters."""
        every = (
            ("minimal", self.minimal_parameters, deviations, self.model.minimal_units),
            ("physical", self.physical_parameters, of_physical, self.model.physical_units),
        )
        return frame_of(every)


def frame_of(every: Iterable[tuple[str, Mapping[str, float], FloatArray, Mapping[str, str]]]) -> pl.DataFrame:
    """Rows of a kind, name, value, deviation and unit, by the values, deviations and units of each kind."""
    rows = [
        (kind, name, value, float(std), str(units[name]))
        for kind, values, deviations, units in every
        for (name, value), std in zip(values.items(), deviations, strict=True)
    ]
    schema = {"kind": pl.String, "name": pl.String, "value": pl.Float64, "std": pl.Float64, "unit": pl.String}
    return pl.DataFrame(rows, schema=schema, orient="row")


@dataclass(frozen=True, eq=False, repr=False)
class Identification(EstimatedParameters, Shown):
    """Identified parameters of an axis and what they were identified from."""

    model: GeneratedModel
    """The model identified."""
    logs: tuple[str, ...]
    """Sources of the logs."""
    sampling_period: float
    """Sampling period of the first log, s."""
    observations: tuple[Observation, ...]
    """One for each log."""
    fit: LeastSquares
    """Minimal parameters and their classical covariance."""
    correlated: CorrelatedCovariance
    """Covariance corrected for the correlation of the residual."""
    physical: tuple[PhysicalEstimate, ...]
    """One for each branch of the inverse map, the physically possible ones first; empty without a branch."""
    status: Status
    """Either "ok", or what keeps the result from being complete."""
    message: str
    """Meaning of the status here and the cure; empty if all is well."""
    notes: tuple[str, ...]
    """Oddities of the logs."""
    timing: Timing | None = None
    """Estimated delay of the force; None if it was not examined or cannot be estimated."""
    bias: Bias | None = None
    """Expected error of the minimal parameters; None if that was not examined."""
    segments: tuple[Segment, ...] = ()
    """Sums over segments of the logs, with the residual before the bias is taken off; empty if not examined."""
    scatter: FloatArray | None = None
    """Covariance of the minimal parameters by their scatter between segments of the logs; None if not examined;
    shape (n_minimal, n_minimal), optional."""
    discrepancies: tuple[Discrepancy, ...] = ()
    """Effects that the model lacks and the residual shows; empty if that was not examined."""
    fault: tuple[Status, str] | None = None
    """What contradicts the minimal parameters, whatever the status says; None if nothing does or was examined."""
    axis: Axis | None = None
    """The declared axis, where `symid.identify` was given it; with it figures and pages show the motion."""
    runs: tuple[Log, ...] = ()
    """Then its logs; of one that does not fit into memory, the first block."""

    @property
    def headline(self) -> str:
        """Status and parameters."""
        physical = self.physical_parameters
        values = physical or self.minimal_parameters
        units = self.model.physical_units if physical else self.model.minimal_units
        deviations = self.physical_deviations if physical else self.standard_deviations
        return headline_of(self.model, self.status, values, deviations, units)

    @property
    def parameters(self) -> dict[str, float]:
        """Physical parameters by name, SI; minimal ones without an inverse map."""
        return self.physical_parameters or self.minimal_parameters

    def predict(self, log: LogLike) -> OutputPrediction:
        """The output that the parameters predict on another log, as `symid.identification.predict`."""
        preparation = self.observations[0].preparation
        return predicted_output(self.model, self.fit, preparation, log, self.axis)

    @property
    def covariance(self) -> FloatArray:
        """Covariance of the minimal parameters, corrected for the residual's correlation where that is known."""
        return best_covariance(self.fit, self.correlated)

    def to_frame(self) -> pl.DataFrame:
        """A polars data frame with a row for each minimal and physical parameter: kind, name, value, std, unit (SI).

        Deviations are those that are printed. Its ``to_pandas`` and ``to_arrow`` give frames of other libraries.
        """
        return self._as_frame(self.standard_deviations, self.physical_deviations)

    @property
    def standard_deviations(self) -> FloatArray:
        """Standard deviations of the minimal parameters, as they are printed: widened by `widened`."""
        return self.widened(np.eye(self.fit.solution.size))

    @property
    def physical_deviations(self) -> FloatArray:
        """Standard deviations of the physical parameters of the first branch, as they are printed."""
        return self.widened_deviations(self.physical[0]) if self.physical else np.empty(0)

    def widened_deviations(self, estimate: PhysicalEstimate) -> FloatArray:
        """Standard deviations of physical parameters, widened, with what priors add."""
        by_log = self.widened(estimate.sensitivity)
        by_prior = np.diag(estimate.restricted.by_prior) if estimate.restricted else 0.0
        return np.asarray(np.sqrt(np.square(by_log) + by_prior))

    @property
    def sampling_deviations(self) -> FloatArray:
        """Standard deviations of the minimal parameters from the correlation of the residual alone."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def widened_covariance(self) -> FloatArray:
        """Covariance of the minimal parameters with `standard_deviations` and the correlations of `covariance`."""
        return with_deviations(self.covariance, self.standard_deviations)

    def widened(self, sensitivity: FloatArray) -> FloatArray:
        """Deviations of functions of the minimal parameters that cover noise, scatter, bias and lacking effects.

        Parameters
        ----------
        sensitivity : array of shape (n, n_minimal)
            Derivatives of the functions. The larger of the covariance of a correlated residual and that of the scatter
            between segments counts; the squares of the expected bias and of what lacking effects may change are added.
        """
        return np.asarray(np.sqrt(self.by_noise(sensitivity) + self.systematic(sensitivity)))

    def by_noise(self, sensitivity: FloatArray) -> FloatArray:
        """Part of the square of `widened` by noise, which is another one in each log."""
        variance = np.einsum("ia,ab,ib->i", sensitivity, self.covariance, sensitivity)
        if self.scatter is None:
            return np.asarray(variance)
        by_segments = np.einsum("ia,ab,ib->i", sensitivity, self.scatter, sensitivity)
        return np.asarray(np.maximum(variance, by_segments))

    def systematic(self, sensitivity: FloatArray) -> FloatArray:
        """Part of the square of `widened` by bias and lacking effects, which logs of a machine have in common."""
        bias = self.bias.mapped(sensitivity).total if self.bias is not None else 0.0
        return np.asarray(np.square(bias) + self.by_lacking(sensitivity))

    def by_lacking(self, sensitivity: FloatArray, *, delays: bool = True) -> FloatArray:
        """Part of the square of `widened` that effects make which the model lacks, with or without delays."""
        counted = (one for one in self.discrepancies if delays or not one.is_delay)
        return sum((one.variance(sensitivity) for one in counted), start=np.zeros(len(sensitivity)))

    @property
    def physical_bias(self) -> Bias | None:
        """Expected error of the physical parameters of the first branch; None if it is not known."""
        return self.bias.mapped(self.physical[0].sensitivity) if self.bias and self.physical else None

    @property
    def dominated_by_bias(self) -> tuple[str, ...]:
        """Physical parameters, or else minimal ones, whose bias exceeds a tenth of their deviation.

        Their intervals do not hold the true value as often as they say.
        """
        if self.bias is None:
            return ()
        if self.physical_bias is None:
            names, places = list(self.model.minimal_units), self.bias.dominates(self.sampling_deviations)
        else:
            deviations = self.physical[0].propagated_deviations(self.covariance)
            names, places = list(self.model.physical_units), self.physical_bias.dominates(deviations)
        return tuple(names[i] for i in places)

    @property
    def output_units(self) -> dict[str, str]:
        """Unit of each output, by its name."""
        return dict(zip(self.model.output_names, self.model.output_units, strict=True))

    @property
    def residuals(self) -> tuple[EquationResidual, ...]:
        """Residual of each equation over all logs."""
        equations = range(len(self.model.output_names))
        return tuple(
            _residual(self, j, [k * len(equations) + j for k in range(len(self.logs))]) for j in equations
        )


def headline_of(
    model: GeneratedModel,
    status: str,
    values: Mapping[str, float],
    deviations: FloatArray,
    units: Mapping[str, str],
) -> str:
    """An identification in a line: axis, sensors, status, and its first parameters."""
    written = [
        f"{name} = {value:.6g} ± {std:.2g} {units[name]}"
        for (name, value), std in zip(values.items(), deviations, strict=True)
    ]
    more = ["..."] * (len(written) > _MOST_WRITTEN)
    listed = ", ".join([*written[:_MOST_WRITTEN], *more])
    return f"{model.axis} from {', '.join(model.measured)}, {status}: {listed or 'no parameters'}"


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
    return found.predict(log)


def best_covariance(fit: LeastSquares, correlated: CorrelatedCovariance) -> FloatArray:
    """The corrected covariance, or the classical one where too few samples are left for the correlation."""
    return correlated.covariance if correlated.status != "too_few_samples" else fit.covariance


def with_deviations(covariance: FloatArray, deviations: FloatArray) -> FloatArray:
    """A covariance with other deviations and the same correlations.

    >>> with_deviations(np.array([[1.0, 0.5], [0.5, 1.0]]), np.array([2.0, 1.0])).tolist()
    [[4.0, 1.0], [1.0, 1.0]]
    """
    own = np.sqrt(np.diag(covariance))
    growth = np.divide(deviations, own, out=np.ones_like(own), where=own != 0)
    return np.asarray(covariance * np.outer(growth, growth))


def _residual(found: Identification, equation: int, places: list[int]) -> EquationResidual:
    fit = found.fit
    return EquationResidual.of(
        found.model.output_names[equation],
        rows=sum(fit.rows[place] for place in places),
        norm=float(np.linalg.norm(fit.residual_norm[places])),
        y_norm=float(np.linalg.norm(fit.y_norm[places])),
        deviation=float(np.sqrt(np.mean(np.square(fit.sigma_rho_equation[places])))),
    )
