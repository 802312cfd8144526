"""`identify`: from logs of an axis to its parameters, as a table of contents.

Each log is prepared and sampled (`observe`), all of them together are solved by weighted least squares in which every
equation of every log has its own weight (`estimate`), the deviations are corrected for the correlation of the
residual (`corrected_covariance`), and the minimal parameters are mapped to physical ones (`physical_estimates`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from symid.codegen import GeneratedModel, as_generated
from symid.data import Log
from symid.errors import SettingError
from symid.estimation import (
    CorrelatedCovariance,
    LeastSquares,
    Method,
    ObservationBlock,
    corrected_covariance_of_blocks,
    estimate,
    refine,
    triangular_factors,
)
from symid.identification.observation import Observation, observe
from symid.identification.physical import PhysicalEstimate, physical_estimates
from symid.identification.residuals import EquationResidual
from symid.identification.settings import Preparation
from symid.identification.verdict import Status, verdict

if TYPE_CHECKING:
    from symid.symbolic import DerivedModel

_CONDITION_THAT_COSTS_DIGITS = 1e4
_MANY_ROWS = 1_000_000
"""Parameters are refined in extended precision where that costs no time, or where rounding has cost digits."""


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
        One for each branch of the inverse map, the physically possible ones first; empty where there are none.
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
    model: GeneratedModel | DerivedModel,
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
    model : GeneratedModel or DerivedModel
        Regressor and maps, from `symid.load_generated` or `symid.derive`.
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
    model = as_generated(model)
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
    worth_refining = sum(fit.rows) < _MANY_ROWS or fit.condition_number_scaled > _CONDITION_THAT_COSTS_DIGITS
    if len(blocks) == 1 and fit.status == "ok" and worth_refining:
        fit = refine(blocks[0].W, blocks[0].y, fit, blocks[0].valid)
    correlated = corrected_covariance_of_blocks(lambda: blocks, fit)
    physical: tuple[PhysicalEstimate, ...] = ()
    if fit.status == "ok":
        covariance = correlated.covariance if correlated.status != "too_few_samples" else fit.covariance
        physical = physical_estimates(model, fit.parameters, covariance, nominal)
    status, message = verdict(model, fit, physical)
    return Identification(
        model=model,
        logs=tuple(log.source for log in runs),
        observations=observations,
        fit=fit,
        correlated=correlated,
        physical=physical,
        status=status,
        message=message,
        notes=tuple(note for log in runs for note in log.notes),
    )


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


def _residual(found: Identification, equation: int, places: list[int]) -> EquationResidual:
    fit = found.fit
    return EquationResidual.of(
        found.model.output_names[equation],
        rows=sum(fit.rows[place] for place in places),
        norm=float(np.linalg.norm(fit.residual_norm[places])),
        y_norm=float(np.linalg.norm(fit.y_norm[places])),
        deviation=float(np.sqrt(np.mean(np.square(fit.sigma_rho_equation[places])))),
    )
