"""Bodies without mass in the equation of motion: balances of springs and dampers."""

from dataclasses import replace
from itertools import compress

import numpy as np

from symid.arrays import BoolArray, FloatArray
from symid.errors import SettingError
from symid.simulation.plants.plant import Plant, condensed

_FASTER, _FASTER_BESIDE_FRICTION = 1e5, 1e3
"""Rate at which a node with a light mass comes to its balance, over the rate at which that relaxes. Events of friction
are located in steps that resolve it: they would take a hundred times as long with the first."""


def without_massless_bodies(plant: Plant, heavy: BoolArray) -> Plant:
    """The plant without bodies that have no mass, marked by false in `heavy`.

    A node that carries a damper gets a mass too small to change the motion; one between springs alone is condensed.
    """
    light = _light_masses(plant, ~heavy)
    nodes = tuple(compress(plant.bodies, light > 0.0))
    plant = replace(plant, mass=plant.mass + np.diag(light), nodes=nodes)
    return _condensed(plant, heavy | (light > 0.0))


def _light_masses(plant: Plant, nodes: BoolArray) -> FloatArray:
    """Masses of nodes that carry dampers as well as springs, too small to change the motion; 0 of other bodies.

    The forces of springs and dampers balance at a node: it relaxes at the rate K/D. With the mass D^2/(r K) it comes to
    this balance r times faster than that, and the rate is K/D (1 + 1/r).
    """
    springs, dampers = plant.stiffness.diagonal(), plant.damping.diagonal()
    damped = nodes & (springs > 0.0) & (dampers > 0.0)
    faster = _FASTER_BESIDE_FRICTION if plant.laws else _FASTER
    return np.where(damped, dampers**2 / (faster * np.where(damped, springs, 1.0)), 0.0)


def _condensed(plant: Plant, heavy: BoolArray) -> Plant:
    """Static condensation of the massless bodies: x = T x_heavy.

    Springs alone must act on a massless body, so that their balance determines its displacement.
    """
    nodes = ~heavy
    if not nodes.any():
        return plant
    springs = plant.stiffness[np.ix_(nodes, nodes)]
    other = [plant.damping[nodes], plant.drives[nodes], plant.constant[nodes]]
    named = f"bodies {', '.join(compress(plant.bodies, nodes))} without mass"
    if any(forces.any() for forces in other) or any(law.direction[nodes].any() for law in plant.laws):
        raise SettingError(
            f"{named} carry more than springs, and dampers beside springs: give each a mass to simulate"
        )
    if np.linalg.matrix_rank(springs) < len(springs):
        raise SettingError(f"{named} are held by no spring: give each a mass, or a spring")
    T = np.zeros((heavy.size, int(heavy.sum())))
    T[heavy] = np.eye(T.shape[1])
    T[nodes] = -np.linalg.solve(springs, plant.stiffness[np.ix_(nodes, heavy)])
    reduced: Plant = condensed(plant, T, tuple(compress(plant.bodies, heavy)))
    return reduced
