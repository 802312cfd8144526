"""Parameters by maximum likelihood on the exactly sampled axis: no derivatives of signals, no filter to choose.

The model predicts each reading from all earlier ones (`PredictionError`); parameters and noise ratios are those whose
innovations are least. Starts are tried with the modes of the axis at several frequencies below the Nyquist frequency:
a mode above it has an alias below that fits a sampled log as well.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from symid.codegen import GeneratedModel
from symid.estimation import (
    CorrelatedCovariance,
    LeastSquares,
    corrected_covariance,
    estimate,
    triangular_factors,
)
from symid.identification.physical import jacobian
from symid.output_error.prediction_error import PredictionError
from symid.output_error.run import Motion, Run, motion_between
from symid.output_error.search import Search
from symid.simulation import ForwardDynamics

_TRIAL_ITERATIONS = 12
_TRIAL_SAMPLES = 6000
_PASSES = 3
"""Times that unmeasured motion and timing are brought up to date."""


@dataclass(frozen=True, eq=False)
class Fit:
    """Maximum-likelihood estimate.

    Parameters
    ----------
    search : Search
        Where it ended.
    linear : LeastSquares
        Of the model linearised there, in the order of `search.seen`, then the nuisance parameters.
    correlated : CorrelatedCovariance
        Its covariance, corrected for what correlation the innovations have left.
    """

    search: Search
    linear: LeastSquares
    correlated: CorrelatedCovariance

    @property
    def cost(self) -> float:
        """Mean square of the scaled innovations: the lower, the likelier."""
        return self.search.cost

    @property
    def noise(self) -> dict[str, float]:
        """Standard deviations of the noise of the force and of the readings of the first run, SI."""
        error, search = self.search.errors[0], self.search
        return error.noise(search.parameters, search.nuisance[0])


def natural_frequencies(dynamics: ForwardDynamics, parameters: Mapping[str, float]) -> list[float]:
    """Undamped natural frequencies in Hz, without the rigid motions.

    Examples
    --------
    >>> from symid.axis import load_axis
    >>> from symid.simulation import forward_dynamics
    >>> paper = {"Ms": 3899.0, "Fvs": 0.0, "Ks": 1e9, "Mm": 362.58, "Fvm": 0.0, "Fsm": 0.0}
    >>> [round(f, 1) for f in natural_frequencies(forward_dynamics(load_axis("direct_2m1s")), paper)]
    [80.6]
    """
    plant = dynamics.at(parameters)
    squares = np.linalg.eigvals(np.linalg.solve(plant.mass, plant.stiffness)).real
    floor = 1e-9 * max(squares.max(initial=0.0), 1e-12)
    return sorted(float(np.sqrt(w) / (2 * np.pi)) for w in squares if w > floor)


def fit_runs(
    model: GeneratedModel,
    dynamics: ForwardDynamics,
    runs: Sequence[Run],
    starts: Sequence[Mapping[str, float]],
    *,
    free_timing: bool = False,
) -> Fit:
    """Maximum-likelihood parameters of an axis from its runs, the best that any start leads to.

    Parameters
    ----------
    model : GeneratedModel
        Says which physical parameters the sensors see.
    dynamics : ForwardDynamics
        The axis.
    runs : sequence of Run
        Logs of one axis.
    starts : sequence of mapping of str to float
        Physical parameters to begin with, masses and stiffnesses positive.
    free_timing : bool
        Whether the time by which the force is recorded late is estimated too.

    Raises
    ------
    numpy.linalg.LinAlgError
        If a run holds no motion, or no start can be evaluated.
    """
    if any(not run.starts for run in runs):
        raise np.linalg.LinAlgError("a run holds no motion")
    nyquist = 0.5 / max(run.period for run in runs)
    excerpts = [run.excerpt(_TRIAL_SAMPLES) for run in runs]
    beginnings = [
        Search.at(dynamics, _errors(dynamics, excerpts, free_timing), _seen(model, s), s) for s in starts
    ]
    possible = [search for search in beginnings if np.isfinite(search.cost)]
    trials = [search for search in possible if _highest_mode(search) < nyquist] or possible
    if not trials:
        raise np.linalg.LinAlgError("no start can be evaluated")
    trials = [trial.improved(_TRIAL_ITERATIONS) for trial in trials]
    first = min(trials, key=lambda trial: (_highest_mode(trial) >= nyquist, trial.cost))
    best = first.continued(_errors(dynamics, runs, free_timing)).weighted().improved()
    if free_timing or any(motion is None for run in runs for motion in run.motions):
        for _ in range(_PASSES):
            best = best.updated().improved()
    if len(runs) > 1:
        best = best.weighted().improved()
    W, y = best.linearised()
    linear = estimate(triangular_factors(W[None], y[None]))
    return Fit(best, linear, corrected_covariance(W[None], y[None], linear))


def _errors(dynamics: ForwardDynamics, runs: Sequence[Run], free_timing: bool) -> list[PredictionError]:
    return [PredictionError(dynamics, run, _known_motions(run), free_timing) for run in runs]


def _highest_mode(search: Search) -> float:
    return max(natural_frequencies(search.dynamics, search.parameters), default=0.0)


def _known_motions(run: Run) -> tuple[Motion, ...]:
    """Motions of all joints; one that no sensors tell is taken to rest until the first estimate."""
    zero = np.zeros(len(run.readings))
    return tuple(motion or motion_between(zero, zero, run.parts) for motion in run.motions)


def _seen(model: GeneratedModel, values: Mapping[str, float]) -> tuple[str, ...]:
    """Physical parameters on which any minimal parameter depends."""
    names = list(model.physical_units)
    slopes = jacobian(model, np.array([values[name] for name in names]))
    return tuple(name for name, column in zip(names, slopes.T, strict=True) if np.any(column != 0))
