"""`identify`: from logs of an axis to its parameters, as a table of contents.

Each log is prepared and sampled (`observe`), all of them together are solved by weighted least squares in which every
equation of every log has its own weight (`estimate`), the deviations are corrected for the correlation of the
residual (`corrected_covariance`), and the minimal parameters are mapped to physical ones (`physical_estimates`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from symid.arrays import FloatArray
from symid.codegen import GeneratedModel
from symid.data import Log
from symid.errors import SettingError
from symid.estimation.corrected_covariance import (
    CorrelatedCovariance,
    ObservationBlock,
    corrected_covariance_of_blocks,
)
from symid.estimation.least_squares import LeastSquares, Method, estimate
from symid.estimation.refinement import refine
from symid.estimation.triangular import triangular_factors
from symid.identification.observation import Observation, observe
from symid.identification.physical import PhysicalEstimate, physical_estimates
from symid.identification.settings import Preparation

Status = Literal[
    "ok", "rank_deficient", "too_few_rows", "poorly_excited", "no_physical_parameters", "not_physical"
]

_HIGHEST_CONDITION = 1e5
"""Of the scaled observation matrix; beyond it, noise of 0.001 % in a column changes the parameters by 100 %."""


@dataclass(frozen=True, eq=False)
class EquationResidual:
    """How well one equation is met.

    Parameters
    ----------
    output : str
        Left-hand side of the equation.
    rows : int
        Rows compared.
    norm, rms : float
        Norm and root mean square of y - W X, in the unit of the output.
    deviation : float
        Estimated standard deviation sigma_rho of the equation [25].
    relative : float
        ||y - W X|| / ||y||; nan for an output that is always 0.
    """

    output: str
    rows: int
    norm: float
    rms: float
    deviation: float
    relative: float


@dataclass(frozen=True, eq=False)
class Identification:
    """Identified parameters of an axis and what they were identified from.

    Parameters
    ----------
    model : GeneratedModel
        The model identified.
    logs : tuple of str
        Sources of the logs.
    observations : tuple of Observation
        One for each log.
    fit : LeastSquares
        Minimal parameters and their classical covariance.
    correlated : CorrelatedCovariance
        Covariance corrected for the correlation of the residual.
    physical : tuple of PhysicalEstimate
        One for each branch of the inverse map, the physically possible ones first; with classical deviations.
    physical_corrected : tuple of PhysicalEstimate
        The same with corrected deviations.
    status : str
        "ok", or what keeps the result from being complete.
    message : str
        What the status means here and what to do; empty if all is well.
    notes : tuple of str
        What looked odd in the logs.
    """

    model: GeneratedModel
    logs: tuple[str, ...]
    observations: tuple[Observation, ...]
    fit: LeastSquares
    correlated: CorrelatedCovariance
    physical: tuple[PhysicalEstimate, ...]
    physical_corrected: tuple[PhysicalEstimate, ...]
    status: Status
    message: str
    notes: tuple[str, ...]

    @property
    def minimal_parameters(self) -> dict[str, float]:
        """Minimal parameters by name, SI."""
        return dict(zip(self.model.minimal_units, map(float, self.fit.parameters), strict=True))

    @property
    def physical_parameters(self) -> dict[str, float]:
        """Physical parameters of the first branch by name, SI; empty if there are none."""
        if not self.physical:
            return {}
        return dict(zip(self.model.physical_units, map(float, self.physical[0].parameters), strict=True))

    @property
    def output_units(self) -> dict[str, str]:
        """Unit of each output, by its name."""
        return dict(zip(self.model.output_names, self.model.output_units, strict=True))

    @property
    def residuals(self) -> tuple[EquationResidual, ...]:
        """How well each equation is met, over all logs."""
        equations = range(len(self.model.output_names))
        return tuple(
            _residual(self, j, [k * len(equations) + j for k in range(len(self.logs))]) for j in equations
        )


def identify(
    model: GeneratedModel,
    logs: Log | Sequence[Log],
    *,
    method: Method = "wls",
    preparation: Preparation | None = None,
    ddof: int | None = None,
    nominal: Mapping[str, float] | None = None,
) -> Identification:
    """Identify the parameters of an axis from one log, or from several of the same axis jointly.

    Parameters
    ----------
    model : GeneratedModel
        Regressor and maps, from `symid.load_model` or `symid.derive`.
    logs : Log or sequence of Log
        Runs of one axis; every equation of every log gets a weight of its own.
    method : {"wls", "ols"}
        Weighted [24]-[30] or ordinary [20]-[23] least squares.
    preparation : Preparation, optional
        Filter, differences, decimation, rows; what is left open is chosen from each log.
    ddof : int, optional
        Subtracted from the number of rows in the residual's deviation; the number of parameters by default.
    nominal : mapping of str to float, optional
        Nominal physical parameters, a start where the inverse map has no closed form.

    Returns
    -------
    Identification
        What cannot be determined is said by its status; nothing is raised for it.

    Raises
    ------
    LogError, SettingError
        If a log lacks a signal, or a setting is not possible.

    Examples
    --------
    >>> import numpy as np
    >>> from symid.codegen import load_generated
    >>> t = np.arange(4000) / 1000
    >>> q, a = np.sin(9 * t), -81 * np.sin(9 * t)
    >>> F = 5 * a + 2 * np.sign(np.cos(9 * t)) + 9 * np.cos(9 * t)
    >>> log = Log.from_arrays({"q": q, "F": F}, sampling_period=1e-3)
    >>> found = identify(load_generated("rigid_1m"), log).physical_parameters
    >>> round(found["M"], 2), round(found["Fv"], 1), round(found["Fs"], 1)
    (5.0, 1.0, 2.0)
    """
    runs = (logs,) if isinstance(logs, Log) else tuple(logs)
    if not runs:
        raise SettingError("there is no log: give at least one")
    if len(runs) > 1 and model.per_log:
        raise SettingError(
            f"axis {model.axis!r} has a parameter of each log ({', '.join(model.per_log)}): identify each log alone"
        )
    observations = tuple(observe(model, log, preparation or Preparation()) for log in runs)
    blocks = _blocks(observations)
    factors = [f for o in observations for f in triangular_factors(o.W, o.y, o.valid)]
    fit = estimate(factors, method, ddof)
    if len(blocks) == 1 and fit.status == "ok":
        fit = refine(blocks[0].W, blocks[0].y, fit, blocks[0].valid)
    correlated = corrected_covariance_of_blocks(lambda: blocks, fit)
    physical, physical_corrected = _physical(model, fit, correlated, nominal)
    status, message = _verdict(model, fit, physical)
    return Identification(
        model=model,
        logs=tuple(log.source for log in runs),
        observations=observations,
        fit=fit,
        correlated=correlated,
        physical=physical,
        physical_corrected=physical_corrected,
        status=status,
        message=message,
        notes=tuple(note for log in runs for note in log.notes),
    )


def predict(found: Identification, log: Log) -> tuple[Observation, tuple[EquationResidual, ...]]:
    """Apply identified parameters to another log, prepared in the same way.

    Returns
    -------
    tuple
        The other log's observation, and how well each equation is met there.
    """
    observation = observe(found.model, log, found.observations[0].preparation)
    errors = observation.y - observation.W @ _with_own_parameters(found, observation)
    return observation, tuple(
        _of_rows(name, errors[j][observation.valid[j]], observation.y[j][observation.valid[j]])
        for j, name in enumerate(found.model.output_names)
    )


def _with_own_parameters(found: Identification, observation: Observation) -> FloatArray:
    """Identified parameters, those that differ from log to log (unknown zeros) fitted to the log at hand."""
    solution = found.fit.solution.copy()
    own = [i for i, name in enumerate(found.model.minimal_units) if name in found.model.per_log]
    if own:
        solution[own] = 0.0
        rest = observation.y - observation.W @ solution
        solution[own] = estimate(
            triangular_factors(observation.W[:, :, own], rest, observation.valid), "ols"
        ).solution
    return solution


def _blocks(observations: Sequence[Observation]) -> list[ObservationBlock]:
    """Observations as blocks in which every equation of every log is an equation of its own."""
    if len(observations) == 1:
        return [ObservationBlock(observations[0].W, observations[0].y, observations[0].valid)]
    blocks = []
    for k, observation in enumerate(observations):
        n_equations, n_rows, n_parameters = observation.W.shape
        own = slice(k * n_equations, (k + 1) * n_equations)
        W = np.zeros((len(observations) * n_equations, n_rows, n_parameters))
        y = np.zeros(W.shape[:2])
        valid = np.zeros(W.shape[:2], dtype=bool)
        W[own], y[own], valid[own] = observation.W, observation.y, observation.valid
        blocks.append(ObservationBlock(W, y, valid, continues=False))
    return blocks


def _physical(
    model: GeneratedModel,
    fit: LeastSquares,
    correlated: CorrelatedCovariance,
    nominal: Mapping[str, float] | None,
) -> tuple[tuple[PhysicalEstimate, ...], tuple[PhysicalEstimate, ...]]:
    """Physical parameters with classical and with corrected deviations."""
    if fit.status != "ok" or not np.all(np.isfinite(fit.covariance)):
        return (), ()
    classical = physical_estimates(model, fit.parameters, fit.covariance, nominal)
    if not np.all(np.isfinite(correlated.covariance)):
        return classical, ()
    return classical, physical_estimates(model, fit.parameters, correlated.covariance, nominal)


def _verdict(
    model: GeneratedModel, fit: LeastSquares, physical: tuple[PhysicalEstimate, ...]
) -> tuple[Status, str]:
    names = list(model.minimal_units)
    if fit.status == "too_few_rows":
        return (
            "too_few_rows",
            f"{sum(fit.rows)} rows are left for {len(names)} parameters: give a longer log or --standstill 0",
        )
    if fit.status == "rank_deficient":
        missing = ", ".join(names[i] for i in fit.undetermined)
        return "rank_deficient", f"the log does not determine {missing}: {_missing_motion(model, fit)}"
    if fit.condition_number_scaled > _HIGHEST_CONDITION:
        vague = [n for n, r in zip(names, fit.relative_standard_deviations, strict=True) if not r < 50]
        return "poorly_excited", (
            f"the columns of W are nearly dependent (condition {fit.condition_number_scaled:.2g} scaled), and noise decides "
            f"on {', '.join(vague or names)}: move at several speeds, accelerations and frequencies"
        )
    if not physical:
        return (
            "no_physical_parameters",
            "the inverse map has no closed form: give --nominal P.json with nominal values as a start",
        )
    if negative := physical[0].negative(model):
        return (
            "not_physical",
            f"{', '.join(negative)} came out negative: the model, the filter or the log does not fit",
        )
    return "ok", ""


def _missing_motion(model: GeneratedModel, fit: LeastSquares) -> str:
    """What a log must hold for the dependent columns to differ, judged by what the columns are."""
    units = list(model.minimal_units.values())
    combination = next(iter(fit.rank.null_space.T), None)
    if combination is None:
        return "move the axis with more frequencies"
    involved = {units[i] for i in np.flatnonzero(np.abs(combination) > 1e-6)}
    if involved <= {"N", "N*m", "A", "V"}:
        return "move in both directions"
    if {"kg", "kg*m^2"} & involved and {"N*s/m", "N*m*s/rad"} & involved:
        return "move at several speeds and accelerations"
    return "excite the axis with more frequencies (a chirp or a multisine around its resonance)"


def _residual(found: Identification, equation: int, places: list[int]) -> EquationResidual:
    fit = found.fit
    norm = float(np.linalg.norm(fit.residual_norm[places]))
    y_norm = float(np.linalg.norm(fit.y_norm[places]))
    rows = sum(fit.rows[place] for place in places)
    return EquationResidual(
        output=found.model.output_names[equation],
        rows=rows,
        norm=norm,
        rms=float(norm / np.sqrt(rows)) if rows else float("nan"),
        deviation=float(np.sqrt(np.mean(np.square(fit.sigma_rho_equation[places])))),
        relative=norm / y_norm if y_norm > 0 else float("nan"),
    )


def _of_rows(output: str, errors: FloatArray, y: FloatArray) -> EquationResidual:
    norm, y_norm, rows = float(np.linalg.norm(errors)), float(np.linalg.norm(y)), errors.size
    return EquationResidual(
        output=output,
        rows=rows,
        norm=norm,
        rms=float(norm / np.sqrt(rows)) if rows else float("nan"),
        deviation=float(np.std(errors, ddof=1)) if rows > 1 else float("nan"),
        relative=norm / y_norm if y_norm > 0 else float("nan"),
    )
