"""The trial of a reference: the axis is simulated, kept within its limits, and identified."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from typing import Literal

import numpy as np

from symid.axis import Axis
from symid.codegen import GeneratedModel
from symid.errors import LogError, SettingError
from symid.excitation.references import DEFAULTS, scaled
from symid.identification import Preparation, identify_with_steps
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
from symid.simulation.plants import equilibrium

_TRIES = 4
_MARGIN = 0.99
_FULL = 0.95
"""Share of a limit from which a reference is not enlarged."""
_LARGEST_STEP = 10.0
"""Factor by which the size of a reference changes at most from one simulation to the next."""
_OF_ESTIMATE = 4
"""Weight of the printed deviations, in runs, beside the errors of the runs."""


@dataclass(frozen=True)
class Expectation:
    """Expected deviations of an identification, and the extremes of the simulated motion."""

    references: tuple[Trajectory, ...]
    """The reference of each drive, scaled so that the axis keeps its limits."""
    deviations: dict[str, float]
    """Standard deviations of the physical parameters, SI."""
    relative: dict[str, float]
    """Expected rms errors of parameters other than zero, relative to their values: mostly the printed deviations
    where there is one run, the errors of the runs where there are many. They include systematic errors."""
    reached: dict[str, float]
    """Largest travel, speed, acceleration and force of a drive of the simulated axis, jerk of a reference, and, if
    limited, largest difference between drives, SI."""

    @property
    def trajectory(self) -> Trajectory:
        """Reference of the first drive."""
        return self.references[0]

    @property
    def worst(self) -> float:
        """Largest relative deviation."""
        return max(self.relative.values(), default=math.inf)

    @property
    def undetermined(self) -> tuple[str, ...]:
        """Parameters whose expected error exceeds their value."""
        return tuple(name for name, error in self.relative.items() if error > 1.0)


@dataclass(frozen=True)
class IdentificationTrial:
    """The axis to be identified, its controller and its limits."""

    axis: Axis
    """The axis, with the noise of its signals."""
    model: GeneratedModel
    """Model for the sensors to use."""
    parameters: Mapping[str, float]
    """Assumed values of the physical parameters, SI."""
    controller: Controller | Sequence[Controller]
    """Controllers, one for each drive."""
    limits: Limits
    """Length of the travel, speed, acceleration and jerk."""
    force: float = math.inf
    """Largest force of a drive, SI."""
    apart: float | None = None
    """Largest difference between the positions of drives, SI. Without it all drives get the same reference."""
    method: Literal["wls", "iv"] = "wls"
    """Least squares, or instrumental variables. The latter use the known reference and controller to avoid the bias
    that encoder noise in the regressor causes."""

    def within_limits(
        self, paths: Sequence[Trajectory], seed: int = 0, *, enlarge: bool = True
    ) -> tuple[tuple[Trajectory, ...], Simulation] | None:
        """The references with the size at which the axis reaches a limit, and their simulation; None if none is found.

        A loop follows fast references in part only: what it leaves of a limit is used, unless `enlarge` is false.
        """
        allowed, tried = self.allowed, [(0.0, 0.0)]
        size, kept = 1.0, None
        for _ in range(_TRIES):
            moved = tuple(scaled(path, size) for path in paths)
            run = self.simulated(moved, seed)
            reached = self.reached(moved, run)
            excess = max(reached[name] / allowed[name] for name in allowed)
            if excess <= 1.0:
                kept = moved, run
                if excess >= _FULL or not enlarge:
                    break
            tried.append((size, excess))
            size = _next_size(*tried[-2:])
        return kept

    def simulated(self, paths: Sequence[Trajectory], seed: int) -> Simulation:
        """The axis along the references, from rest in equilibrium if it has one."""
        return simulate(self.axis, self.parameters, paths, self.controller, seed=seed, start=self._start)

    @cached_property
    def _start(self) -> Literal["equilibrium"] | None:
        readings = dict.fromkeys(self.axis.controlled_signals, 0.0)
        try:
            equilibrium(plant_of(self.axis, self.parameters), readings)
        except SettingError:  # a body that nothing holds
            return None
        return "equilibrium"

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

    def beyond_at_rest(self, paths: Sequence[Trajectory]) -> str:
        """Limits that the axis exceeds without a motion of its references, with what it reaches; empty if none."""
        still = tuple(scaled(path, 0.0) for path in paths)
        reached = self.reached(still, self.simulated(still, 0))
        return ", ".join(
            f"{name} {reached[name]:.3g} of {limit:g}"
            for name, limit in self.allowed.items()
            if reached[name] > limit
        )

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

        References are scaled to the limits of the axis; the defaults are only reduced. The runs differ in their noise;
        more runs detect smaller systematic errors.
        """
        kept = self.within_limits(paths, enlarge=paths[0].name not in DEFAULTS)
        if kept is None:
            return None
        motion, first = kept
        others = (self.simulated(motion, seed) for seed in range(1, runs))
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


def _next_size(one: tuple[float, float], last: tuple[float, float]) -> float:
    """Size of a reference that just keeps its limits, by the line through two sizes with what they reached.

    Noise in the loop, weights and friction load the axis however small the reference is.

    >>> round(_next_size((1.0, 1.5), (0.6, 1.1)), 9), round(_next_size((0.0, 0.0), (1.0, 0.5)), 9)
    (0.49, 1.98)
    """
    (first, before), (size, excess) = one, last
    proportional, is_line = size * _MARGIN / excess, (excess - before) * (size - first) > 0.0
    by_line = size + (_MARGIN - excess) * (size - first) / (excess - before) if is_line else proportional
    if excess > 1.0:
        return max(min(by_line, proportional), size / _LARGEST_STEP)
    return min(max(by_line, proportional), size * _LARGEST_STEP)
