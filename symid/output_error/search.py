"""State and steps of the iterative search for the parameters of an axis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol, Self

import numpy as np

from symid.arrays import FloatArray
from symid.data import Log
from symid.errors import SymidError
from symid.estimation import Minimum, central_slope, levenberg_marquardt
from symid.output_error.predicted_log import OutputErrorPrediction
from symid.simulation import ForwardDynamics

_LOGARITHMIC_STEP = 1e-5
_VISIBLE = 1e-4
"""Relative change of the innovations that determines the difference step of a parameter."""


class RunError(Protocol):
    """Deviation of a run from the prediction of parameters."""

    @property
    def first_nuisance(self) -> FloatArray:
        """Nuisance parameters to begin with."""

    @property
    def nuisance_steps(self) -> FloatArray:
        """Their difference steps."""

    @property
    def is_settled(self) -> bool:
        """Whether nothing in it follows from the parameters, so that `updated` changes nothing."""

    @property
    def trials(self) -> tuple[tuple[int, int], ...]:
        """Iterations of each round of trials of starts, and how many go on after it."""

    @property
    def has_motion(self) -> bool:
        """Whether the axis moves in it."""

    def excerpt(self) -> Self:
        """A shorter run of the same kind, for trials."""

    def scaled(self, parameters: Mapping[str, float], nuisance: FloatArray) -> FloatArray:
        """Errors scaled so that their sum of squares is the likelihood."""

    def updated(self, parameters: Mapping[str, float], nuisance: FloatArray) -> tuple[Self, FloatArray]:
        """The run with its functions of the parameters evaluated again, and the nuisance parameters for it."""

    def noise(self, parameters: Mapping[str, float], nuisance: FloatArray) -> dict[str, float]:
        """Standard deviations of the noise by signal, SI."""

    def prediction(
        self, log: Log, parameters: Mapping[str, float], nuisance: FloatArray
    ) -> OutputErrorPrediction:
        """Readings of a run's log and their prediction errors."""


@dataclass(frozen=True, eq=False)
class Search:
    """Arguments x are the seen parameters (masses and springs as logarithms), then the nuisance parameters by run.

    `start` holds the physical parameters at the beginning, `seen` those that are searched; no mode of the axis may
    reach the frequency `highest`, Hz.
    """

    dynamics: ForwardDynamics
    errors: tuple[RunError, ...]
    start: Mapping[str, float]
    seen: tuple[str, ...]
    weights: tuple[float, ...]
    highest: float
    x: FloatArray
    minimum: Minimum | None = None

    @classmethod
    def at(
        cls,
        dynamics: ForwardDynamics,
        errors: Sequence[RunError],
        seen: Sequence[str],
        start: Mapping[str, float],
        highest: float,
    ) -> Search:
        """Search at its start point."""
        logarithmic = _logarithmic(dynamics)
        physical = [0.0 if name in logarithmic else float(start[name]) for name in seen]
        x = np.concatenate([physical, *(error.first_nuisance for error in errors)])
        return cls(dynamics, tuple(errors), dict(start), tuple(seen), (1.0,) * len(errors), highest, x)

    @property
    def parameters(self) -> dict[str, float]:
        """Physical parameters at the current point."""
        return self._physical(self.x)

    @property
    def nuisance(self) -> list[FloatArray]:
        """Nuisance parameters of each run at the current point."""
        return self._nuisance(self.x)

    @property
    def has_converged(self) -> bool:
        """Whether the last iterations converged."""
        return self.minimum is not None and self.minimum.converged

    @cached_property
    def cost(self) -> float:
        """Mean square of the weighted scaled innovations; infinite where they are not defined."""
        try:
            return float(np.mean(self.residual(self.x) ** 2))
        except (np.linalg.LinAlgError, SymidError):
            return float("inf")

    @property
    def levels(self) -> tuple[float, ...]:
        """Size (rms) of the scaled errors of each run, without its weight."""
        parts = zip(self._parts(self.x), self.weights, strict=True)
        return tuple(float(np.sqrt(np.mean(part**2))) / weight for part, weight in parts)

    @property
    def rows(self) -> tuple[int, ...]:
        """Scaled errors of each run."""
        return tuple(part.size for part in self._parts(self.x))

    def residual(self, x: FloatArray) -> FloatArray:
        """Weighted scaled errors of all runs; LinAlgError if a mode is too high, or an error is not defined."""
        if self.dynamics.at(self._physical(x)).highest_mode >= self.highest:
            raise np.linalg.LinAlgError(f"a mode lies above {self.highest:g} Hz")
        return np.concatenate(self._parts(x))

    def improved(self, iterations: int = 60) -> Search:
        """The search after more iterations."""
        minimum = levenberg_marquardt(
            self.residual, self.x, self._steps(), longest=self._longest_moves(), iterations=iterations
        )
        return replace(self, x=minimum.x, minimum=minimum)

    def continued(self, errors: Sequence[RunError]) -> Search:
        """The search with other runs, such as the whole logs after excerpts of them."""
        return replace(self, errors=tuple(errors), minimum=None)

    def weighted(self) -> Search:
        """The search with weights that bring the innovations of all runs to the same level."""
        if len(self.errors) == 1:
            return self
        levels = self.levels
        return replace(self, weights=tuple(min(levels) / level if level > 0 else 1.0 for level in levels))

    def updated(self) -> Search:
        """The search with what follows from its parameters brought up to date in the errors of each run."""
        pairs = zip(self.errors, self.nuisance, strict=True)
        followed = [error.updated(self.parameters, nuisance) for error, nuisance in pairs]
        x = np.concatenate([self.x[: len(self.seen)], *(nuisance for _, nuisance in followed)])
        return replace(self, errors=tuple(error for error, _ in followed), x=x)

    def linearised(self) -> tuple[FloatArray, FloatArray]:
        """Observation matrix and output of the model linearised at the current point, in units of the parameters."""
        logarithmic, values = self._logarithmic, self.parameters
        at = self.x.copy()
        at[: len(self.seen)] = [values[name] for name in self.seen]
        size = np.ones(at.size)
        size[: len(self.seen)] = [values[name] if name in logarithmic else 1.0 for name in self.seen]
        W = -central_slope(self.residual, self.x, self._steps()) / size
        return W, self.residual(self.x) + W @ at

    @cached_property
    def _logarithmic(self) -> frozenset[str]:
        return _logarithmic(self.dynamics)

    def _physical(self, x: FloatArray) -> dict[str, float]:
        logarithmic, values = self._logarithmic, dict(self.start)
        for name, value in zip(self.seen, x, strict=False):
            values[name] = self.start[name] * float(np.exp(value)) if name in logarithmic else float(value)
        return values

    def _nuisance(self, x: FloatArray) -> list[FloatArray]:
        sizes = [error.first_nuisance.size for error in self.errors]
        return np.split(x[len(self.seen) :], np.cumsum(sizes)[:-1])

    def _parts(self, x: FloatArray) -> list[FloatArray]:
        values = self._physical(x)
        rows = zip(self.errors, self._nuisance(x), self.weights, strict=True)
        return [weight * error.scaled(values, nuisance) for error, nuisance, weight in rows]

    def _longest_moves(self) -> FloatArray:
        """Masses and springs may change by a factor of e in one iteration, noise ratios by its square."""
        moves = np.full(self.x.size, 2.0)
        moves[: len(self.seen)] = [1.0 if name in self._logarithmic else np.inf for name in self.seen]
        return moves

    def _steps(self) -> FloatArray:
        """Difference steps: fixed for logarithms, for other parameters such that the innovations change visibly."""
        here = self.residual(self.x)
        steps = np.concatenate([np.ones(len(self.seen)), *(error.nuisance_steps for error in self.errors)])
        for i, name in enumerate(self.seen):
            steps[i] = _LOGARITHMIC_STEP
            if name in self._logarithmic:
                continue
            trial = max(abs(self.x[i]), 1e-6)
            moved = self.x.copy()
            moved[i] += trial
            change = float(
                np.linalg.norm(self.residual(moved) - here) / max(float(np.linalg.norm(here)), 1e-300)
            )
            steps[i] = trial * min(max(_VISIBLE / max(change, 1e-300), 1e-9), 1e9)
        return steps


def _logarithmic(dynamics: ForwardDynamics) -> frozenset[str]:
    """Names of masses and springs: they are positive, and at first only their orders of magnitude are known."""
    return frozenset(dynamics.parameters_of("mass") | dynamics.parameters_of("stiffness"))
