"""Choice of the reference for an identification: the candidate with the smallest largest relative deviation.

For each candidate the axis is simulated, checked against its limits and identified with the filter and differences that
`identify` chooses. The deviations of that estimate are those to expect. Since the true parameters are known,
systematic errors are detected as well.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Literal, TypeAlias

import numpy as np

from symid.axis import Axis
from symid.codegen import GeneratedModel
from symid.errors import LogError, SettingError
from symid.excitation.references import DEFAULTS, references, references_apart, scaled
from symid.identification import Preparation, identify_with_steps
from symid.identification.physical import open_by_structure
from symid.instrumental import identify_by_instruments
from symid.simulation import (
    ClosedLoop,
    Controller,
    Limits,
    Simulation,
    Trajectory,
    feedthrough_of,
    plant_of,
    simulate,
)

Paths: TypeAlias = tuple[Trajectory, ...]
"""Reference of each drive."""
_FINALISTS, LEAST_RUNS = 6, 4
"""The best candidates and the defaults are simulated several times: one run shows little bias."""
FINAL_RUNS = 150
"""Runs of the chosen reference, whose errors then tell more than printed deviations: of an error that varies from run
to run they give the rms to 6 %."""
_SHARE_OF_DEFAULTS = 5
"""Number of runs of the chosen reference for each run of the default ones."""
_TRIES = 4
_MARGIN = 0.99
_OF_ESTIMATE = 4
"""Weight of the printed deviations, in runs, beside the errors of the runs."""


@dataclass(frozen=True)
class Expectation:
    """Expected deviations of an identification, and the extremes of the simulated motion.

    Parameters
    ----------
    references : tuple of Trajectory
        The reference of each drive, scaled so that the axis keeps its limits.
    deviations : dict of str to float
        Standard deviations of the physical parameters, SI.
    relative : dict of str to float
        Expected rms errors of parameters other than zero, relative to their values: mostly the printed deviations where
        there is one run, the errors of the runs where there are many. They include systematic errors.
    reached : dict of str to float
        Largest travel, speed, acceleration and force of a drive of the simulated axis, jerk of a reference, and, if
        limited, largest difference between drives, SI.
    """

    references: tuple[Trajectory, ...]
    deviations: dict[str, float]
    relative: dict[str, float]
    reached: dict[str, float]

    @property
    def trajectory(self) -> Trajectory:
        """Reference of the first drive."""
        return self.references[0]

    @property
    def worst(self) -> float:
        """Largest relative deviation."""
        return max(self.relative.values(), default=math.inf)


@dataclass(frozen=True)
class IdentificationTrial:
    """The axis to be identified, its controller and its limits.

    Parameters
    ----------
    axis : Axis
        The axis, with the noise of its signals.
    model : GeneratedModel
        Model for the sensors to use.
    parameters : mapping of str to float
        Assumed values of the physical parameters, SI.
    controller : Controller or sequence of Controller
        Controllers, one for each drive.
    limits : Limits
        Length of the travel, speed, acceleration and jerk.
    force : float
        Largest force of a drive, SI.
    apart : float, optional
        Largest difference between the positions of drives, SI. Without it all drives get the same reference.
    method : {"wls", "iv"}
        Least squares, or instrumental variables. The latter use the known reference and controller to avoid the bias
        that encoder noise in the regressor causes.
    """

    axis: Axis
    model: GeneratedModel
    parameters: Mapping[str, float]
    controller: Controller | Sequence[Controller]
    limits: Limits
    force: float = math.inf
    apart: float | None = None
    method: Literal["wls", "iv"] = "wls"

    def within_limits(
        self, paths: Sequence[Trajectory], seed: int = 0
    ) -> tuple[tuple[Trajectory, ...], Simulation] | None:
        """The references, reduced as far as the limits require, and their simulation; None if that does not succeed."""
        for _ in range(_TRIES):
            run = simulate(self.axis, self.parameters, paths, self.controller, seed=seed)
            reached, allowed = self.reached(paths, run), self.allowed
            excess = max(reached[name] / allowed[name] for name in allowed)
            if excess <= 1.0:
                return tuple(paths), run
            paths = [scaled(path, _MARGIN / excess) for path in paths]
        return None

    @property
    def allowed(self) -> dict[str, float]:
        """Limits by name: travel, speed, acceleration, jerk, force, and difference between drives."""
        low, high = self.limits.travel
        rates = {name: getattr(self.limits, name) for name in ("speed", "acceleration", "jerk")}
        apart = {} if self.apart is None else {"apart": self.apart}
        return {"travel": high - low, **rates, "force": self.force, **apart}

    def reached(self, paths: Sequence[Trajectory], run: Simulation) -> dict[str, float]:
        """Extremes of a simulated axis at the position sensors of the drives; the jerk is that of the references."""
        plant = plant_of(self.axis, self.parameters)
        rows = np.stack([plant.sensors[signal].row for signal in self.axis.controlled_signals])
        n = rows.shape[1]
        position, velocity = run.states[:, :n] @ rows.T, run.states[:, n:] @ rows.T
        found = {
            "travel": float(np.ptp(position, axis=0).max()),
            "speed": float(np.abs(velocity).max()),
            "acceleration": float(np.abs(np.diff(velocity, axis=0)).max() / paths[0].sampling_period),
            "jerk": max(path.extremes.jerk for path in paths),
            "force": float(np.abs(run.forces).max()),
        }
        return found if self.apart is None else {**found, "apart": float(np.ptp(position, axis=1).max())}

    def identified(self, run: Simulation) -> tuple[dict[str, float], dict[str, float]] | None:
        """Physical parameters and their deviations from a simulated log; None if the log does not determine them."""
        settings, nominal, log = Preparation(held=True), self.parameters, run.log
        try:
            if self.method == "wls":
                found = identify_with_steps(
                    self.axis,
                    self.model,
                    [log],
                    feedthrough_of,
                    preparation=settings,
                    examine="bias",
                    nominal=nominal,
                )
            else:
                loop = ClosedLoop(self.axis, self.controller, log.sampling_frequency)
                found = identify_by_instruments(self.model, log, loop, preparation=settings, nominal=nominal)
        except (SettingError, LogError):
            return None
        if found.fit.status != "ok" or found.status == "weak_instruments" or not found.physical:
            return None
        values = found.physical_parameters
        return values, dict(zip(values, map(float, found.physical_deviations), strict=True))

    def expectation(self, paths: Sequence[Trajectory], runs: int = 1) -> Expectation | None:
        """Expectation for a reference of each drive; None if limits or identification cannot be met.

        References are reduced if the axis exceeds its limits. The runs differ in their noise; more runs detect smaller
        systematic errors.
        """
        kept = self.within_limits(paths)
        if kept is None:
            return None
        motion, first = kept
        others = (
            simulate(self.axis, self.parameters, motion, self.controller, seed=seed)
            for seed in range(1, runs)
        )
        found = []
        for run in chain((first,), others):
            one = self.identified(run)
            if one is None:
                return None
            found.append(one)
        deviations = {name: math.sqrt(sum(one[1][name] ** 2 for one in found) / runs) for name in found[0][0]}
        relative = {}
        for name, deviation in deviations.items():
            truth = self.parameters[name]
            if truth and math.isfinite(deviation):
                squares = _OF_ESTIMATE * deviation**2 + sum((one[0][name] - truth) ** 2 for one in found)
                relative[name] = math.sqrt(squares / (_OF_ESTIMATE + runs)) / abs(truth)
        return Expectation(motion, deviations, relative, self.reached(*kept))


@dataclass(frozen=True)
class Design:
    """The chosen reference, compared with the defaults of `symid simulate` within the same limits and time.

    Parameters
    ----------
    best : Expectation
        Expectation for the chosen reference.
    defaults : dict of str to (Expectation or None)
        Expectations for the default trapezoids and the default chirp; None if they do not determine the parameters.
    tried : int
        Number of references that were simulated.
    """

    best: Expectation
    defaults: dict[str, Expectation | None]
    tried: int


def design(
    experiment: IdentificationTrial,
    seconds: float,
    rate: float,
    *,
    seeds: int = 2,
    runs: int = FINAL_RUNS,
    track: Callable[[Sequence[Paths]], Iterable[Paths]] = iter,
) -> Design:
    """Choose the reference whose largest relative deviation of a physical parameter is smallest.

    Parameters
    ----------
    experiment : IdentificationTrial
        Axis, noise, controller and limits.
    seconds, rate : float
        Duration, s, and sampling rate of controller and log, Hz.
    seeds : int
        Number of multisines with random phases for each band.
    runs : int
        Number of simulated identifications of the chosen reference, 4 at least: the expected errors come from them. The
        defaults get a fifth.
    track : callable, optional
        Passes on the references that are tried, and may show progress.

    Raises
    ------
    SettingError
        If no reference determines the parameters within the limits, or there are fewer than 4 runs.
    """
    if runs < LEAST_RUNS:
        raise SettingError(f"runs is {runs}: it must be at least {LEAST_RUNS}")
    mode = plant_of(experiment.axis, experiment.parameters).highest_mode
    drives, limits = len(experiment.axis.drives), experiment.limits
    tried = [(one,) * drives for one in references(limits, seconds, rate, mode, seeds)]
    if experiment.apart is not None and drives > 1:
        tried += references_apart(limits, experiment.apart, drives, seconds, rate, mode)
    found = {paths[0].name: experiment.expectation(paths) for paths in track(tried)}
    ranked = sorted((one for one in found.values() if one), key=lambda one: one.worst)
    again = {
        one.trajectory.name: experiment.expectation(one.references, LEAST_RUNS)
        for i, one in enumerate(ranked)
        if i < _FINALISTS or one.trajectory.name in DEFAULTS
    }
    best = min((one for one in again.values() if one), key=lambda one: one.worst, default=None)
    if best is None:
        if unseen := open_by_structure(experiment.model):
            raise SettingError(
                f"no motion determines {', '.join(unseen)} of axis {experiment.axis.name!r} by these sensors: declare "
                "what is known as a number, or measure more"
            )
        is_common = drives > 1 and experiment.apart is None
        apart = ", or that drives differ by apart=..." if is_common else ""
        raise SettingError(
            f"none of {len(tried)} references within the limits determines the parameters of axis "
            f"{experiment.axis.name!r}: allow more travel, speed, force or time{apart}, or lower the noise"
        )
    fewer = max(LEAST_RUNS, runs // _SHARE_OF_DEFAULTS)
    defaults = {name: _repeated(experiment, again.get(name), fewer) for name in DEFAULTS}
    return Design(_repeated(experiment, best, runs) or best, defaults, len(tried))


def _repeated(trial: IdentificationTrial, expected: Expectation | None, runs: int) -> Expectation | None:
    """Expectation of the same reference from more runs."""
    if expected is None or runs <= LEAST_RUNS:
        return expected
    return trial.expectation(expected.references, runs)
