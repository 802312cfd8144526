"""Physical parameters and effects from a record: weighted least squares of the outputs' errors, by Gauss-Newton.

Hidden motion follows from the measured one and from the forces of the iteration before, so that a law in a joint that
no sensor sees is evaluated at the motion that the model itself implies.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from symid.arrays import BoolArray, ComplexArray, FloatArray
from symid.diagnosis.effects import JointEffect, LinearEffect, Placed
from symid.diagnosis.record import Record
from symid.diagnosis.scene import Joint, Scene, scene_of
from symid.diagnosis.weighting import Weighting, starting_pulses, weighting_of, with_restarts
from symid.errors import SettingError

_RELATIVE_STEP = 1e-4
_SHAPE_STEP = 1e-4
_LARGEST_SHAPE_STEP = 0.3
_HALVINGS = 5
_SETTLED = 1e-6
_RANK = 1e-10
_TAKES_PART = 0.2
_CREDIBLE = 16.0


@dataclass(frozen=True, eq=False)
class State:
    """A model with values, under a record.

    Parameters
    ----------
    scene : Scene
        Motion and prediction.
    placed : tuple of Placed
        Effects with values.
    errors : array of shape (n_outputs, n_bins)
        Measured less predicted outputs.
    rows : array of shape (n_outputs, n_rows)
        The same, weighted.
    beginning : array of shape (n_starts, n_outputs, n_rows)
        What an unknown state at the beginning of the log makes of them.
    """

    scene: Scene
    placed: tuple[Placed, ...]
    errors: ComplexArray
    rows: FloatArray
    beginning: FloatArray

    def weighted(self, weighting: Weighting) -> State:
        """The same with other weights."""
        beginning = weighting.rows(starting_pulses(self.scene.record, self.scene.hidden))
        return replace(self, rows=weighting.rows(self.errors), beginning=beginning)


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
        otherwise a model would gain by not following the motion where it is small.

        Parameters
        ----------
        density : array of shape (n_outputs, n_bins)
            Weights that are allowed for.
        """
        weighting, beginning = self.weighting, self.state.beginning
        own = replace(weighting, density=np.maximum(density, self.state.scene.density))
        columns, rows = (
            weighting.known(self.columns, beginning),
            own.known(own.rows(self.state.errors), beginning),
        )
        rows = rows - columns.T @ solved(columns.T, rows)
        n = rows.size * weighting.record.freedom
        return float(-0.5 * n * np.log(rows @ rows / rows.size))

    @property
    def mean_square(self) -> float:
        """Of the rows kept: 1 if noise alone is left."""
        return float(np.mean(self.left[:, self.weighting.kept] ** 2))


def solved(columns: FloatArray, error: FloatArray) -> FloatArray:
    """Least-squares solution for columns of any scale."""
    scale = np.linalg.norm(columns, axis=0)
    scale = np.where(scale > 0, scale, 1.0)
    return np.asarray(np.linalg.lstsq(columns / scale, error, rcond=_RANK)[0] / scale)


def first_state(
    record: Record, parameters: Mapping[str, float], allowed: BoolArray | None = None
) -> tuple[State, Weighting]:
    """The axis at given parameters, and the weighting that goes with them.

    Parameters
    ----------
    record : Record
        The log.
    parameters : mapping of str to float
        Physical parameters, SI.
    allowed : bool array of shape (n_fine,), optional
        Parts of the log that may be used.
    """
    scene = scene_of(record, parameters)
    scene = scene_of(record, parameters, before=scene)
    weighting = _weighting(scene, allowed)
    return _state(scene, (), record.measured - scene.predicted, weighting), weighting


def _state(scene: Scene, placed: tuple[Placed, ...], errors: ComplexArray, weighting: Weighting) -> State:
    nothing = np.zeros((0, 0, 0))
    return State(scene, placed, errors, nothing, nothing).weighted(weighting)


def _weighting(scene: Scene, allowed: BoolArray | None) -> Weighting:
    """Weights of a scene: all joints that take part in the drive's motion must move."""
    driven = scene.record.fine(scene.record.motion)[scene.record.in_log]
    least = _TAKES_PART * np.ptp(driven)
    speeds = [joint.v for joint in scene.joints.values() if joint.stroke > least]
    return weighting_of(scene.record, scene.density, speeds, allowed)


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
        weighting = _weighting(scene, weighting.allowed)
    weighting = with_restarts(weighting, scene.hidden)
    return fitted(fit.state.weighted(weighting), weighting, iterations)


def with_effects(state: State, weighting: Weighting, placed: tuple[Placed, ...]) -> State:
    """The same parameters with other effects."""
    return _evaluated(state, weighting, state.scene.parameters, placed)


def _evaluated(
    state: State, weighting: Weighting, parameters: Mapping[str, float], placed: tuple[Placed, ...]
) -> State:
    before, record = state.scene, state.scene.record
    forces = np.zeros_like(before.forces)
    impedances, marching = [], []
    for item in placed:
        if not isinstance(item.effect, JointEffect):
            continue
        joint = item.effect.joint(before, item.at)
        if isinstance(item.effect, LinearEffect):
            stiffness = item.amplitudes[0] * item.effect.stiffness(record.omega, item.shape)
            impedances.append((joint.direction, stiffness))
            continue
        force = np.tensordot(item.amplitudes, item.effect.forces(before, joint, item.shape), 1)
        law = item.effect.pointwise(before, item.shape, item.amplitudes) if item.marched else None
        if law is None:
            forces -= np.multiply.outer(force, joint.direction)
        else:
            impedances.append((joint.direction, _equivalent(force, joint)))
            marching.append((joint.direction, law))
    scene = scene_of(
        record, parameters, before=before, forces=forces, impedances=impedances, marching=marching
    )
    errors = record.measured - scene.predicted
    for item in placed:
        if not isinstance(item.effect, JointEffect):
            errors = errors - item.change(scene)
    return _state(scene, placed, errors, weighting)


def is_hidden(scene: Scene, joint: Joint) -> bool:
    """Whether the motion of a joint follows from the model: two bodies, and no sensor that tells it."""
    if len(scene.response.plant.bodies) != 2:
        return False
    row = scene.response.plant.sensors[scene.record.signals[0]][0]
    driven = abs(row @ joint.direction) > (1 - 1e-9) * np.linalg.norm(row) * np.linalg.norm(joint.direction)
    return not driven and np.array_equal(joint.spectrum, joint.modelled)


def _equivalent(force: ComplexArray, joint: Joint) -> ComplexArray:
    """Dynamic stiffness k + j w c - w^2 m nearest to a force: what is left of it moves hidden joints far less."""
    s = 1j * joint.record.omega
    motion = np.stack([joint.modelled, s * joint.modelled, s**2 * joint.modelled])
    scale = np.linalg.norm(motion, axis=1)
    unit = motion / np.where(scale > 0, scale, 1.0)[:, None]
    share = np.linalg.lstsq((unit.conj() @ unit.T).real, (unit.conj() @ force).real, rcond=1e-10)[0]
    k, c, m = share / np.where(scale > 0, scale, 1.0)
    return np.asarray(k + c * s + m * s**2)


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
            found = _evaluated(state, weighting, *_moved(state, share * step))
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


def derivatives(state: State) -> ComplexArray:
    """Derivatives of the prediction by physical parameters and the effects' values, (n_columns, n_outputs, n_bins)."""
    scene = state.scene
    found = [parameter_columns(scene)]
    for item in state.placed:
        if not item.effect.fixed:
            found.append(item.effect.columns(scene, item.at, item.shape))
        found.append(_shape_columns(scene, item))
    return np.concatenate(found)


def _shape_columns(scene: Scene, item: Placed) -> ComplexArray:
    columns = np.zeros((len(item.shape), *scene.record.measured.shape), dtype=complex)
    before = item.change(scene) if item.shape else 0.0
    for i, value in enumerate(item.shape):
        step = _SHAPE_STEP * abs(value)
        shape = (*item.shape[:i], value + step, *item.shape[i + 1 :])
        columns[i] = (replace(item, shape=shape).change(scene) - before) / step
    return columns


def parameter_columns(scene: Scene) -> ComplexArray:
    """Derivatives of the predicted outputs by the physical parameters, of shape (n_parameters, n_outputs, n_bins)."""
    dynamics, plant, s = scene.record.dynamics, scene.response.plant, 1j * scene.record.omega
    columns = np.zeros((len(dynamics.parameters), *scene.record.measured.shape), dtype=complex)
    for k, name in enumerate(dynamics.parameters):
        step = _RELATIVE_STEP * (abs(scene.parameters[name]) or 1.0)
        other = dynamics.at(dict(scene.parameters) | {name: scene.parameters[name] + step})
        matrix = [
            (getattr(other, kind) - getattr(plant, kind)) / step for kind in ("mass", "damping", "stiffness")
        ]
        if any(m.any() for m in matrix):
            mass, damping, stiffness = (m @ scene.displacements for m in matrix)
            forces = -(s**2 * mass + s * damping + stiffness).T
        else:
            forces = np.zeros((s.size, len(plant.bodies)), dtype=complex)
        for (direction, spectra), law, moved in zip(scene.laws, plant.laws, other.laws, strict=True):
            for spectrum, (weight, _), (after, _) in zip(spectra, law.terms, moved.terms, strict=True):
                if after != weight:
                    forces -= np.multiply.outer((after - weight) / step * spectrum, direction)
        forces += np.multiply.outer(scene.predicted[0], (other.drive - plant.drive) / step)
        forces[0] += (other.constant - plant.constant) / step * scene.record.n_extended
        columns[k] = scene.response.of_forces(forces)
    return columns
