"""Expected result of an identification along a reference: simulated, identified, limits verified.

The inverse of the covariance of weighted least squares is the information that the log holds for it, at the filter and
differences that `identify` chooses. The truth is known here, so that a systematic error is seen as well.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from symid.axis import Axis
from symid.codegen import GeneratedModel
from symid.errors import LogError, SettingError
from symid.excitation.references import scaled
from symid.identification import Preparation, identify
from symid.simulation import Controller, Limits, Simulation, Trajectory, plant_of, simulate

_TRIES = 4
_MARGIN = 0.99
_CHANCE = 2.0
"""Deviations of a mean up to which its difference from the truth is chance."""


@dataclass(frozen=True)
class Expectation:
    """Deviations that are expected of an identification, and what the axis reached on the way.

    Parameters
    ----------
    trajectory : Trajectory
        The reference, at the size at which the axis keeps its limits.
    deviations : dict of str to float
        Standard deviations of the physical parameters, SI.
    relative : dict of str to float
        The same relative to the values, with the systematic error beyond two deviations of its mean added in
        squares; of parameters that are not zero.
    reached : dict of str to float
        Travel, speed, acceleration and force of the simulated axis, jerk of the reference, SI.
    """

    trajectory: Trajectory
    deviations: dict[str, float]
    relative: dict[str, float]
    reached: dict[str, float]

    @property
    def worst(self) -> float:
        """Largest relative deviation."""
        return max(self.relative.values(), default=math.inf)


@dataclass(frozen=True)
class IdentificationTrial:
    """An axis as it will be identified.

    Parameters
    ----------
    axis : Axis
        With the noise of its signals.
    model : GeneratedModel
        For the sensors to use.
    parameters : mapping of str to float
        Values assumed of the physical parameters, SI.
    controller : Controller
        What makes the axis follow.
    limits : Limits
        Length of the travel, speed, acceleration and jerk.
    force : float
        Largest force, SI.
    """

    axis: Axis
    model: GeneratedModel
    parameters: Mapping[str, float]
    controller: Controller
    limits: Limits
    force: float = math.inf

    def within_limits(self, trajectory: Trajectory, seed: int = 0) -> tuple[Trajectory, Simulation] | None:
        """The trajectory, smaller if it must be, and its simulation; None if it stays beyond the limits."""
        for _ in range(_TRIES):
            run = simulate(self.axis, self.parameters, trajectory, self.controller, seed=seed)
            reached, allowed = self.reached(trajectory, run), self.allowed
            excess = max(reached[name] / allowed[name] for name in allowed)
            if excess <= 1.0:
                return trajectory, run
            trajectory = scaled(trajectory, _MARGIN / excess)
        return None

    @property
    def allowed(self) -> dict[str, float]:
        """Limits of travel, speed, acceleration, jerk and force by name."""
        low, high = self.limits.travel
        rates = {name: getattr(self.limits, name) for name in ("speed", "acceleration", "jerk")}
        return {"travel": high - low, **rates, "force": self.force}

    def reached(self, trajectory: Trajectory, run: Simulation) -> dict[str, float]:
        """Extremes of a simulated axis at its first sensor; the jerk is that of the reference."""
        plant = plant_of(self.axis, self.parameters)
        row = plant.sensors[self.axis.controlled].row
        n = row.size
        position, velocity = run.states[:, :n] @ row, run.states[:, n:] @ row
        return {
            "travel": float(np.ptp(position)),
            "speed": float(np.abs(velocity).max()),
            "acceleration": float(np.abs(np.diff(velocity)).max() / trajectory.sampling_period),
            "jerk": trajectory.extremes.jerk,
            "force": float(np.abs(run.forces).max()),
        }

    def identified(self, run: Simulation) -> tuple[dict[str, float], dict[str, float]] | None:
        """Physical parameters and their deviations from a simulated log; None if they are not determined."""
        settings = Preparation(held=True)
        try:
            found = identify(
                self.model, run.log, preparation=settings, nominal=self.parameters, examine=False
            )
        except (SettingError, LogError):
            return None
        if found.fit.status != "ok" or not found.physical:
            return None
        values = found.physical_parameters
        return values, dict(zip(values, map(float, found.physical_deviations), strict=True))

    def expectation(self, trajectory: Trajectory, runs: int = 1) -> Expectation | None:
        """Expectation along a trajectory; None if it exceeds limits or does not determine the parameters.

        Parameters
        ----------
        trajectory : Trajectory
            The reference; it is made smaller if the axis goes beyond its limits.
        runs : int
            Simulations with other noise each: the more, the smaller a systematic error that is seen.
        """
        kept = self.within_limits(trajectory)
        if kept is None:
            return None
        motion = kept[0]
        every = [kept[1]]
        every += [
            simulate(self.axis, self.parameters, motion, self.controller, seed=seed)
            for seed in range(1, runs)
        ]
        found = [one for run in every if (one := self.identified(run))]
        if len(found) < runs:
            return None
        deviations = {name: math.sqrt(sum(one[1][name] ** 2 for one in found) / runs) for name in found[0][0]}
        relative = {}
        for name, deviation in deviations.items():
            truth = self.parameters[name]
            # The mean of several runs differs from the truth by chance up to two of its deviations; the rest is bias.
            if truth and math.isfinite(deviation):
                error = abs(sum(one[0][name] for one in found) / runs - truth)
                beyond = max(error - _CHANCE * deviation / math.sqrt(runs), 0.0)
                relative[name] = math.hypot(deviation, beyond) / abs(truth)
        return Expectation(motion, deviations, relative, self.reached(*kept))
