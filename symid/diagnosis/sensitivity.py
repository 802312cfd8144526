"""Derivatives of the prediction by the free values of a model: physical parameters, amplitudes, shapes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symid.arrays import ComplexArray
from symid.diagnosis.effects import Placed
from symid.diagnosis.scene import Scene
from symid.diagnosis.state import State

_RELATIVE_STEP = 1e-4
_SHAPE_STEP = 1e-4


def derivatives(state: State) -> ComplexArray:
    """Derivatives of the prediction by physical parameters and the effects' values, (n_columns, n_outputs, n_bins)."""
    scene = state.scene
    found = [_by_parameters(scene, state.placed)]
    for item in state.placed:
        if not item.effect.fixed:
            found.append(item.effect.columns(scene, item.at, item.shape))
        found.append(_shape_columns(scene, item))
    return np.concatenate(found)


def _by_parameters(scene: Scene, placed: Sequence[Placed]) -> ComplexArray:
    """Derivatives by the physical parameters; what effects make of the outputs depends on these parameters too."""
    misread = [e for item in placed if (e := item.effect.misreading(scene, item)) is not None]
    columns = parameter_columns(scene, np.sum(misread, axis=0) if misread else None)
    changes = (item.effect.passed_on(scene, item, columns) for item in placed)
    return sum((change for change in changes if change is not None), start=columns)


def _shape_columns(scene: Scene, item: Placed) -> ComplexArray:
    columns = np.zeros((len(item.shape), *scene.record.measured.shape), dtype=complex)
    before = item.change(scene) if item.shape else 0.0
    for i, value in enumerate(item.shape):
        step = _SHAPE_STEP * abs(value)
        shape = (*item.shape[:i], value + step, *item.shape[i + 1 :])
        columns[i] = (replace(item, shape=shape).change(scene) - before) / step
    return columns


def parameter_columns(scene: Scene, misread: ComplexArray | None = None) -> ComplexArray:
    """Derivatives of the predicted outputs by the physical parameters, of shape (n_parameters, n_outputs, n_bins).

    Parameters
    ----------
    scene : Scene
        The axis at its parameters.
    misread : array of shape (n_bins,), optional
        What the driven position is read wrong by: its motion is no motion of the bodies.
    """
    displacements, driven = scene.displacements, scene.predicted[0]
    if misread is not None:
        no_forces = np.zeros((misread.size, 0), dtype=complex)
        displacements = np.asarray(displacements - scene.response.displacements(misread, no_forces))
        driven = driven - scene.response.of_position[0] * misread
    dynamics, plant, s = scene.record.dynamics, scene.response.plant, 1j * scene.record.omega
    columns = np.zeros((len(dynamics.parameters), *scene.record.measured.shape), dtype=complex)
    for k, name in enumerate(dynamics.parameters):
        step = _RELATIVE_STEP * (abs(scene.parameters[name]) or 1.0)
        other = dynamics.at(dict(scene.parameters) | {name: scene.parameters[name] + step})
        matrix = [
            (getattr(other, kind) - getattr(plant, kind)) / step for kind in ("mass", "damping", "stiffness")
        ]
        if any(m.any() for m in matrix):
            mass, damping, stiffness = (m @ displacements for m in matrix)
            forces = -(s**2 * mass + s * damping + stiffness).T
        else:
            forces = np.zeros((s.size, len(plant.bodies)), dtype=complex)
        for (direction, spectra), law, moved in zip(scene.laws, plant.laws, other.laws, strict=True):
            for spectrum, (weight, _), (after, _) in zip(spectra, law.terms, moved.terms, strict=True):
                if after != weight:
                    forces -= np.multiply.outer((after - weight) / step * spectrum, direction)
        forces += np.multiply.outer(driven, (other.drive - plant.drive) / step)
        forces[0] += (other.constant - plant.constant) / step * scene.record.n_extended
        columns[k] = scene.response.of_forces(forces)
    return columns
