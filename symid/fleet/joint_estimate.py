"""Joint estimate from several logs of one axis, from their triangular factors alone.

The triangular factor R of [W | y], a few hundred numbers, holds the information of a log about the parameters. Stacking
the factors of all logs, each weighted with 1/sigma of its residual, gives the same weighted estimate as all rows
together [24]-[30]. Its covariance accounts for the correlated residual of each log: with the weighted information
A_k = W'S^2 W of log k, their sum A, and the corrected covariance C_k of log k alone,

    C = A^-1 (sum_k A_k C_k A_k) A^-1,

since logs are independent. Where the machine differs from log to log, their scores s_k = W'S^2(y - W X) show it: the
covariance of clusters A^-1 (sum_k s_k s_k') A^-1 n/(n - 1) counts where it is larger. Systematic errors, such as an
expected bias, are those of all logs alike, which no number of logs averages out. Cost and memory are linear in the
number of logs.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import polars as pl
import scipy
from threadpoolctl import threadpool_limits

from symid.arrays import FloatArray, read_only
from symid.codegen import GeneratedModel
from symid.errors import SettingError
from symid.estimation import LeastSquares, estimate
from symid.fleet.factors import LogFactors
from symid.identification import PhysicalEstimate, physical_estimates
from symid.identification.deviations import LogEstimate, disagreement_between
from symid.identification.results import EstimatedParameters, Status, identification_status


@dataclass(frozen=True, eq=False)
class JointIdentification(EstimatedParameters):
    """Joint estimate of the parameters that several logs of one axis share."""

    model: GeneratedModel
    """The identified model."""
    logs: tuple[str, ...]
    """Sources of the logs."""
    fit: LeastSquares
    """Weighted estimate and its classical covariance, with the equations of all logs, log after log."""
    covariance: FloatArray
    """Covariance of the minimal parameters, corrected for the correlation of each log's residual; shape (n_minimal,
    n_minimal)."""
    scatter: FloatArray
    """Covariance of the minimal parameters by their scatter between the logs; zeros for a single one; shape (n_minimal,
    n_minimal)."""
    systematic: FloatArray
    """Squares of the systematic errors that the logs have in common; shape (n_minimal, n_minimal)."""
    physical: tuple[PhysicalEstimate, ...]
    """One for each branch of the inverse map; may be empty."""
    status: Status
    """As that of an `Identification`."""
    message: str
    """As that of an `Identification`."""
    disagreement: float
    """Chi-square of the separate estimates of the logs; nan unless two logs or more determine all parameters."""
    degrees_of_freedom: int
    """Those of the disagreement."""

    def to_frame(self) -> pl.DataFrame:
        """Parameters as a polars data frame, as those of an `Identification`."""
        return self._as_frame(self.standard_deviations, self.physical_deviations)

    @property
    def standard_deviations(self) -> FloatArray:
        """Standard deviations of the minimal parameters, as they are printed: widened by `widened`."""
        return self.widened(np.eye(self.fit.solution.size))

    @property
    def physical_deviations(self) -> FloatArray:
        """Standard deviations of the physical parameters of the first branch, as they are printed."""
        return self.widened(self.physical[0].sensitivity) if self.physical else np.empty(0)

    def widened(self, sensitivity: FloatArray) -> FloatArray:
        """Deviations of functions of the minimal parameters that cover noise, scatter and systematic errors.

        Parameters
        ----------
        sensitivity : array of shape (n, n_minimal)
            Derivatives of the functions. The larger of noise and scatter between the logs counts.
        """
        noise, scatter, systematic = (
            np.einsum("ia,ab,ib->i", sensitivity, matrix, sensitivity)
            for matrix in (self.covariance, self.scatter, self.systematic)
        )
        return np.asarray(np.sqrt(np.maximum(noise, scatter) + systematic))

    @property
    def noise(self) -> dict[str, FloatArray]:
        """sigma_rho of each equation, by log: the inverse of its weight."""
        levels = self.fit.sigma_rho_equation.reshape(len(self.logs), -1)
        return dict(zip(self.logs, levels, strict=True))

    @property
    def disagreement_probability(self) -> float:
        """Probability of at least this disagreement if the logs share their parameters; nan if unknown."""
        if not self.degrees_of_freedom:
            return float("nan")
        return float(scipy.special.chdtrc(self.degrees_of_freedom, self.disagreement))


def identify_jointly(
    model: GeneratedModel, logs: Sequence[LogFactors], *, nominal: Mapping[str, float] | None = None
) -> JointIdentification:
    """Identify the parameters that logs of one axis share, each log weighted by its noise.

    Parameters
    ----------
    model : GeneratedModel
        Model with which the logs were identified.
    logs : sequence of LogFactors
        Factors of the logs, from `log_factors`.
    nominal : mapping of str to float, optional
        Nominal physical parameters, initial values if the inverse map has no closed form.

    Returns
    -------
    JointIdentification
        A log that determines only some parameters, such as one without reversals, contributes to these.

    Raises
    ------
    SettingError
        If there is no log, the factors are not those of the model, or it has a parameter that differs between logs.

    Examples
    --------
    Of a quiet and a noisy log, the quiet one dominates:

    >>> import numpy as np
    >>> from symid import Log, identify, load_generated
    >>> from symid.fleet import log_factors
    >>> t, draw = np.arange(8000) / 1000, np.random.default_rng(1)
    >>> model, v, a = load_generated("rigid_1m"), 9 * np.cos(9 * t), -81 * np.sin(9 * t)
    >>> def run(noise):
    ...     force = 5 * a + v + 2 * np.sign(v) + noise * draw.standard_normal(t.size)
    ...     return Log.from_arrays({"q": np.sin(9 * t), "F": force}, sampling_period=1e-3)
    >>> joined = identify_jointly(model, [log_factors(identify(model, run(noise))) for noise in (0.1, 10.0)])
    >>> round(joined.physical_parameters["M"], 2), joined.status
    (5.0, 'ok')
    """
    _check(model, logs)
    with threadpool_limits(1):  # thousands of small matrices: threads would wait for each other
        fit = estimate([factor for log in logs for factor in log.factors])
        covariance, scatter, systematic = _covariances(logs, fit)
        physical: tuple[PhysicalEstimate, ...] = ()
        if fit.status == "ok":
            physical = physical_estimates(model, fit.parameters, covariance, nominal)
        status, message = identification_status(model, fit, physical)
        alone = _single_estimates(logs) if fit.status == "ok" else []
        disagreement, freedom = _disagreement(alone)
        if status == "ok" and (apart := _differing_log(model, fit, physical[0], alone)):
            status, message = "poor_fit", apart
    return JointIdentification(
        model=model,
        logs=tuple(log.log for log in logs),
        fit=fit,
        covariance=covariance,
        scatter=scatter,
        systematic=systematic,
        physical=physical,
        status=status,
        message=message,
        disagreement=disagreement,
        degrees_of_freedom=freedom,
    )


def _check(model: GeneratedModel, logs: Sequence[LogFactors]) -> None:
    if not logs:
        raise SettingError("there is no log to join: give at least one")
    if len(logs) > 1 and model.per_log:
        raise SettingError(
            f"axis {model.axis!r} has a parameter of each log ({', '.join(model.per_log)}): identify each log alone"
        )
    wanted = (len(model.output_names), len(model.minimal_units))
    for log in logs:
        has = (len(log.factors), log.factors[0].parameters)
        if has != wanted:
            raise SettingError(
                f"{log.log}: {has[0]} factors of {has[1]} parameters; axis {model.axis!r} from "
                f"{', '.join(model.measured)} has {wanted[0]} equations of {wanted[1]} parameters"
            )


def _covariances(logs: Sequence[LogFactors], fit: LeastSquares) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Covariance of the joint estimate by noise, nan where the classical one is; by scatter; systematic errors."""
    # Sandwich estimator: A_k C_k A_k is the covariance of the scores of log k; without C_k, it is A_k times the
    # number of rows per independent sample.
    inverse = fit.rank.inverse_root @ fit.rank.inverse_root.T
    by_noise, by_logs, systematic = (np.zeros_like(inverse) for _ in range(3))
    for log, weights in zip(logs, fit.weights.reshape(len(logs), -1), strict=True):
        rows = np.concatenate([w * factor.R[:-1] for w, factor in zip(weights, log.factors, strict=True)])
        R, z = rows[:, :-1], rows[:, -1]
        A, score = R.T @ R, R.T @ (z - R @ fit.solution)
        by_noise += A @ log.covariance @ A if np.all(np.isfinite(log.covariance)) else log.dependence * A
        by_logs += np.outer(score, score)
        systematic += log.systematic * np.sum(inverse * A) / len(A)  # by its share in the information
    covariance = inverse @ by_noise @ inverse
    covariance[np.isnan(fit.covariance)] = np.nan
    scatter = inverse @ by_logs @ inverse * len(logs) / max(len(logs) - 1, 1) * (len(logs) > 1)
    return read_only(covariance), read_only(scatter), read_only(systematic)


@dataclass(frozen=True, eq=False)
class _SingleEstimate:
    """Estimate of the minimal parameters from one log."""

    log: str
    parameters: FloatArray
    covariance: FloatArray


def _single_estimates(logs: Sequence[LogFactors]) -> list[_SingleEstimate]:
    """Estimates from the logs that determine all parameters alone."""
    return [
        _SingleEstimate(log.log, fit.parameters, log.covariance)
        for log, fit in ((log, estimate(log.factors)) for log in logs)
        if fit.status == "ok" and np.all(np.isfinite(log.covariance))
    ]


def _differing_log(
    model: GeneratedModel, fit: LeastSquares, physical: PhysicalEstimate, alone: Sequence[_SingleEstimate]
) -> str:
    """Statement on a log whose own physical parameters, to first order, differ from the others; else empty."""

    def estimated(single: _SingleEstimate) -> LogEstimate:
        values = physical.parameters + physical.sensitivity @ (single.parameters - fit.parameters)
        return LogEstimate(single.log, values, physical.propagated_deviations(single.covariance))

    return disagreement_between(list(model.physical_units), list(map(estimated, alone)))


def _disagreement(alone: Sequence[_SingleEstimate]) -> tuple[float, int]:
    """Chi-square of the separate estimates about their weighted mean, and its degrees of freedom."""
    if len(alone) < 2:
        return float("nan"), 0
    # In units of their typical deviations, neither large nor small parameters lose digits. The mean is weighted with
    # the inverse covariances; the sum of squared Mahalanobis distances from it is the chi-square.
    scale = np.sqrt(np.mean([np.diag(single.covariance) for single in alone], axis=0))
    scale = np.where(scale > 0, scale, 1.0)
    precisions = [
        np.linalg.pinv(single.covariance / np.outer(scale, scale), hermitian=True) for single in alone
    ]
    values = [single.parameters / scale for single in alone]
    weighted = [P @ X for P, X in zip(precisions, values, strict=True)]
    mean = np.linalg.solve(sum(precisions), np.sum(weighted, axis=0))
    total = sum(float((X - mean) @ P @ (X - mean)) for P, X in zip(precisions, values, strict=True))
    return total, (len(alone) - 1) * len(mean)
