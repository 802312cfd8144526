"""Derivatives of the prediction by the free values of a model: physical parameters, amplitudes, shapes."""

from __future__ import annotations

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
