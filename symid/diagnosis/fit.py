"""Physical parameters and effects from a record: weighted least squares of the outputs' errors, by Gauss-Newton."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from symid.arrays import ComplexArray, FloatArray
from symid.diagnosis.effects import DriveEffect, Placed
from symid.diagnosis.sensitivity import derivatives
from symid.diagnosis.state import State, evaluated, weighting_in
from symid.diagnosis.weighting import Weighting, with_restarts
from symid.errors import SettingError

_LARGEST_SHAPE_STEP = 0.3
_HALVINGS = 5
_SETTLED = 1e-6
_RANK = 1e-10
ITERATIONS = 10
"""Of a fit that may begin far off, at most."""
_CREDIBLE = 16.0


@dataclass(frozen=True, eq=False)
class Fit:
    """A model fitted to a record.

    Parameters
    ----------
    state : State
        The model with its values.
    weighting : Weighting
        Of the errors.
    spectra : array of shape (n_columns, n_outputs, n_bins)
        Derivatives of the prediction by the physical parameters and the effects' values.
    columns : array of shape (n_columns, n_outputs, n_rows)
        The same, weighted.
    """

    state: State
    weighting: Weighting
    spectra: ComplexArray
    columns: FloatArray

    @property
    def parameters(self) -> Mapping[str, float]:
        """Physical parameters, SI."""
        return self.state.scene.parameters

    @cached_property
    def left(self) -> FloatArray:
        """Weighted rows that columns and starts do not explain, zero where none are kept; shape (n_outputs, n_rows)."""
        beginning = self.state.beginning
        columns, error = (self.weighting.known(x, beginning) for x in (self.columns, self.state.rows))
        rows = np.zeros_like(self.state.rows)
        rows[:, self.weighting.kept] = (error - columns.T @ solved(columns.T, error)).reshape(len(rows), -1)
        return rows

    @property
    def base(self) -> FloatArray:
        """All columns, with those of unknown starts, of shape (n, n_outputs, n_rows)."""
        return np.concatenate([self.columns, self.state.beginning, self.weighting.restarts])

    def log_likelihood(self, density: FloatArray) -> float:
        """Logarithm of the likelihood of the kept rows, but for a constant: white errors of unknown level.

        Where the model lets less of the position's noise through than the weights allow for, its own noise counts:
        otherwise a model would gain by not following the motion where it is small. Errors of the force are relative to
        the force that acts: otherwise a drive that is taken to give next to none would leave next to no error.

        Parameters
        ----------
        density : array of shape (n_outputs, n_bins)
            Weights that are allowed for.
        """
        weighting, beginning = self.weighting, self.state.beginning
        own = replace(weighting, density=np.maximum(density, self.state.scene.density))
        relative = np.ones((len(self.state.errors), 1))
        relative[0] /= self._acting
        columns, rows = (
            weighting.known(self.columns * relative, beginning * relative),
            own.known(own.rows(self.state.errors * relative), beginning * relative),
        )
        rows = rows - columns.T @ solved(columns.T, rows)
        n = rows.size * weighting.record.freedom
        return float(-0.5 * n * np.log(rows @ rows / rows.size))

    @property
    def _acting(self) -> float:
        """Share of the logged force that acts on the axis if an effect of the drive keeps some of it back, in rms."""
        scene = self.state.scene
        changes = [
            item.change(scene)[0] for item in self.state.placed if isinstance(item.effect, DriveEffect)
        ]
        if not changes:
            return 1.0
        logged = np.stack([scene.record.measured[0], scene.record.measured[0] - np.sum(changes, axis=0)])
        rows = self.weighting.rows(logged[:, None])[:, 0, self.weighting.kept]
        whole, acting = np.linalg.norm(rows, axis=1)
        return float(min(acting / whole, 1.0))

    @property
    def mean_square(self) -> float:
        """Of the rows kept: 1 if noise alone is left."""
        return float(np.mean(self.left[:, self.weighting.kept] ** 2))


def solved(columns: FloatArray, error: FloatArray) -> FloatArray:
    """Least-squares solution for columns of any scale."""
    scale = np.linalg.norm(columns, axis=0)
    scale = np.where(scale > 0, scale, 1.0)
    return np.asarray(np.linalg.lstsq(columns / scale, error, rcond=_RANK)[0] / scale)


def fitted(state: State, weighting: Weighting, iterations: int = 6) -> Fit:
    """Gauss-Newton from a state.

    Parameters
    ----------
    state : State
        Where to begin; its effects are fitted too.
    weighting : Weighting
        Of the errors.
    iterations : int
        At most.
    """
    cost = _cost(state, weighting)
    spectra = derivatives(state)
    columns = weighting.rows(spectra)
    for _ in range(iterations):
        step = _step(state, weighting, columns)
        found, after = _searched(state, weighting, step, cost)
        if found is None:
            break
        state, settled = found, after > cost * (1 - _SETTLED)
        cost, spectra = after, derivatives(state)
        columns = weighting.rows(spectra)
        if settled:
            break
    return Fit(state, weighting, spectra, columns)


def unfitted(state: State, weighting: Weighting) -> Fit:
    """A model with the values that it has."""
    spectra = derivatives(state)
    return Fit(state, weighting, spectra, weighting.rows(spectra))


def refitted(fit: Fit, iterations: int = 3) -> Fit:
    """The same with unknown states after each standstill, and weights that belong to the parameters found.

    Where noise is not most of what is left, the parameters may be far off, and weights that follow them would hide the
    error: they stay as they are.
    """
    scene, weighting = fit.state.scene, fit.weighting
    if fit.mean_square < _CREDIBLE:
        weighting = weighting_in(scene, weighting.allowed)
    weighting = with_restarts(weighting, scene.hidden)
    return fitted(fit.state.weighted(weighting), weighting, iterations)


def converged(state: State, weighting: Weighting) -> Fit:
    """Fitted from a state, and then with the weights that belong to what was found, see `refitted`."""
    return refitted(fitted(state, weighting, ITERATIONS))


def _cost(state: State, weighting: Weighting) -> float:
    """Sum of squares that unknown starts do not explain."""
    error = weighting.known(state.rows, state.beginning)
    return float(error @ error)


def _step(state: State, weighting: Weighting, columns: FloatArray) -> FloatArray:
    columns, error = (weighting.known(x, state.beginning) for x in (columns, state.rows))
    return solved(columns.T, error)


def _searched(
    state: State, weighting: Weighting, step: FloatArray, cost: float
) -> tuple[State | None, float]:
    """The longest of the step and its fractions that lowers the cost; None if none does."""
    share = 1.0
    for _ in range(_HALVINGS):
        try:
            found = evaluated(state, weighting, *_moved(state, share * step))
            after = _cost(found, weighting)
        except (SettingError, np.linalg.LinAlgError, OverflowError):  # masses not positive, motion unbounded
            after = np.inf
        if after < cost:
            return found, after
        share /= 3
    return None, cost


def _moved(state: State, step: FloatArray) -> tuple[dict[str, float], tuple[Placed, ...]]:
    parameters = dict(state.scene.parameters)
    names = state.scene.record.dynamics.parameters
    for name, change in zip(names, step, strict=False):
        parameters[name] += float(change)
    place, placed = len(names), []
    for item in state.placed:
        amplitudes = item.amplitudes
        if not item.effect.fixed:
            changes = step[place : place + len(amplitudes)]
            amplitudes = tuple(float(a + c) for a, c in zip(amplitudes, changes, strict=True))
            place += len(amplitudes)
        limits = [_LARGEST_SHAPE_STEP * abs(x) for x in item.shape]
        changes = np.clip(step[place : place + len(item.shape)], np.negative(limits), limits)
        moved = tuple(float(x + c) for x, c in zip(item.shape, changes, strict=True))
        shape = item.effect.bounded(state.scene, item.at, moved)
        place += len(shape)
        placed.append(replace(item, amplitudes=amplitudes, shape=shape))
    return parameters, tuple(placed)
