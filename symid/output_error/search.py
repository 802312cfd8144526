"""A search for the parameters of an axis: where it stands, and how it goes on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symid.arrays import FloatArray
from symid.errors import SymidError
from symid.output_error.levenberg_marquardt import Minimum, minimise
from symid.output_error.prediction_error import PredictionError
from symid.output_error.run import Run, motion_between
from symid.simulation import ForwardDynamics

_LOGARITHMIC_STEP, _NUISANCE_STEP = 1e-5, 1e-2
_VISIBLE = 1e-4
"""Change of the innovations, relative to their size, that the difference step of a parameter aims at."""


@dataclass(frozen=True, eq=False)
class Search:
    """Arguments x are the seen parameters (masses and springs as logarithms), then the nuisance parameters by run.

    Parameters
    ----------
    dynamics : ForwardDynamics
        The axis.
    errors : tuple of PredictionError
        One for each run.
    start : mapping of str to float
        Physical parameters at the beginning.
    seen : tuple of str
        Those that are searched.
    weights : tuple of float
        Of the runs.
    x : array of shape (n,)
        Where the search stands.
    minimum : Minimum or None
        Where its last iterations ended.
    """

    dynamics: ForwardDynamics
    errors: tuple[PredictionError, ...]
    start: Mapping[str, float]
    seen: tuple[str, ...]
    weights: tuple[float, ...]
    x: FloatArray
    minimum: Minimum | None = None

    @classmethod
    def at(
        cls,
        dynamics: ForwardDynamics,
        errors: Sequence[PredictionError],
        seen: Sequence[str],
        start: Mapping[str, float],
    ) -> Search:
        """Search at its beginning."""
        logarithmic = _logarithmic(dynamics)
        physical = [0.0 if name in logarithmic else float(start[name]) for name in seen]
        x = np.concatenate([physical, *(error.first_nuisance for error in errors)])
        return cls(dynamics, tuple(errors), dict(start), tuple(seen), (1.0,) * len(errors), x)

    @property
    def parameters(self) -> dict[str, float]:
        """Physical parameters where the search stands."""
        return self._physical(self.x)

    @property
    def nuisance(self) -> list[FloatArray]:
        """Nuisance parameters of each run where the search stands."""
        return self._nuisance(self.x)

    @property
    def cost(self) -> float:
        """Mean square of the weighted scaled innovations; infinite where they are not defined."""
        try:
            return float(np.mean(self.residual(self.x) ** 2))
        except (np.linalg.LinAlgError, SymidError):
            return float("inf")

    def residual(self, x: FloatArray) -> FloatArray:
        """Weighted scaled innovations of all runs."""
        return np.concatenate(self._parts(x))

    def improved(self, iterations: int = 60) -> Search:
        """The search after more iterations."""
        found = minimise(
            self.residual, self.x, self._steps(), longest=self._longest_moves(), iterations=iterations
        )
        return replace(self, x=found.x, minimum=found)

    def continued(self, errors: Sequence[PredictionError]) -> Search:
        """The same search with other runs, such as the whole logs after excerpts of them."""
        return replace(self, errors=tuple(errors), minimum=None)

    def weighted(self) -> Search:
        """The search with weights that bring the innovations of all runs to the same level."""
        if len(self.errors) == 1:
            return self
        levels = [
            np.sqrt(np.mean(part**2)) / w for part, w in zip(self._parts(self.x), self.weights, strict=True)
        ]
        return replace(
            self, weights=tuple(float(min(levels) / level) if level > 0 else 1.0 for level in levels)
        )

    def updated(self) -> Search:
        """The search with what follows from its parameters: motion of joints that no sensors tell, timing."""
        values = self.parameters
        errors = [self._follow(e, values, n) for e, n in zip(self.errors, self.nuisance, strict=True)]
        fresh = [
            np.append(nuisance[:-1], 0.0) if error.free_timing else nuisance
            for error, nuisance in zip(errors, self.nuisance, strict=True)
        ]
        return replace(self, errors=tuple(errors), x=np.concatenate([self.x[: len(self.seen)], *fresh]))

    def _follow(
        self, error: PredictionError, values: Mapping[str, float], nuisance: FloatArray
    ) -> PredictionError:
        motions = error.motions
        if any(motion is None for motion in error.run.motions):
            states, n = error.states(values, nuisance), len(self.dynamics.bodies)
            motions = tuple(
                known
                or motion_between(
                    states[:, :n] @ direction, states[:, n : 2 * n] @ direction, error.run.parts
                )
                for known, (direction, _) in zip(error.run.motions, self.dynamics.laws, strict=True)
            )
        run = error.run.recorded_later(float(nuisance[-1])) if error.free_timing else error.run
        return replace(error, run=run, motions=motions)

    def applied_to(self, run: Run) -> PredictionError:
        """Prediction error of another run, with the motion that the parameters give it."""
        first = self.errors[0]
        error = PredictionError(self.dynamics, run, run.known_motions, first.free_timing)
        nuisance = self.nuisance[0].copy()
        if first.free_timing:
            nuisance[-1] = 0.0
        return self._follow(error, self.parameters, nuisance)

    def linearised(self) -> tuple[FloatArray, FloatArray]:
        """Observation matrix and output of the model linearised where the search stands, in the parameters' units."""
        assert self.minimum is not None
        logarithmic, values = _logarithmic(self.dynamics), self.parameters
        at = self.x.copy()
        at[: len(self.seen)] = [values[name] for name in self.seen]
        size = np.ones(at.size)
        size[: len(self.seen)] = [values[name] if name in logarithmic else 1.0 for name in self.seen]
        W = -self.minimum.slope / size
        return W, self.minimum.residual + W @ at

    def _physical(self, x: FloatArray) -> dict[str, float]:
        logarithmic, values = _logarithmic(self.dynamics), dict(self.start)
        for name, value in zip(self.seen, x, strict=False):
            values[name] = self.start[name] * float(np.exp(value)) if name in logarithmic else float(value)
        return values

    def _nuisance(self, x: FloatArray) -> list[FloatArray]:
        return np.split(x[len(self.seen) :], len(self.errors))

    def _parts(self, x: FloatArray) -> list[FloatArray]:
        values = self._physical(x)
        rows = zip(self.errors, self._nuisance(x), self.weights, strict=True)
        return [weight * error.scaled(values, nuisance) for error, nuisance, weight in rows]

    def _longest_moves(self) -> FloatArray:
        """Masses and springs may change by a factor of e in one iteration, noise ratios by its square."""
        moves = np.full(self.x.size, 2.0)
        logarithmic = _logarithmic(self.dynamics)
        moves[: len(self.seen)] = [1.0 if name in logarithmic else np.inf for name in self.seen]
        return moves

    def _steps(self) -> FloatArray:
        """Difference steps: fixed for logarithms, for other parameters such that the innovations change visibly."""
        here, logarithmic = self.residual(self.x), _logarithmic(self.dynamics)
        steps = np.full(self.x.size, _NUISANCE_STEP)
        for i, name in enumerate(self.seen):
            steps[i] = _LOGARITHMIC_STEP
            if name in logarithmic:
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
    """Parameters of masses and springs: positive, and known to orders of magnitude at first."""
    return frozenset(dynamics.parameters_of("mass") | dynamics.parameters_of("stiffness"))
