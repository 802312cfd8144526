"""An axis at rest: displacements and drive forces at which all forces balance."""

from collections.abc import Mapping
from itertools import compress

import numpy as np

from symid.arrays import FloatArray
from symid.errors import SettingError
from symid.simulation.plants.plant import JointLaw, Plant

_ROUNDS, _SETTLED = 50, 1e-12
_STEP = 1e-6
"""Relative to a displacement of 1: half of the difference for the slope of a law."""
_LEFT = 1e-6
"""Part of the largest force on the axis that may stay unbalanced."""


def equilibrium(plant: Plant, readings: Mapping[str, float]) -> tuple[FloatArray, FloatArray]:
    """State at rest in which position sensors read given values, and the forces of the drives that hold it.

    K x - B F + sum_j d_j f_j(d_j x) = c is solved with the readings, one for each drive, for x and F by Newton's
    method; of a law that can hold its joint, such as Coulomb friction, the middle of its range counts. The state has
    shape (2 n,); SettingError if neither springs nor drives hold a body.

    >>> from symid import Axis, Body, Drive, Position, Weight
    >>> from symid.simulation import plant_of
    >>> slide = Body("slide", mass="M")
    >>> axis = Axis("hoist", (slide, Weight(slide)), Drive("F", slide), (Position("q", slide),))
    >>> state, forces = equilibrium(plant_of(axis, {"M": 10.0}), {"q": 0.2})
    >>> state.round(9).tolist(), forces.round(4).tolist()
    ([0.2, 0.0], [98.0665])
    """
    n, n_drives = plant.drives.shape
    sensors = [plant.sensors[signal] for signal in readings]
    rows = np.array([sensor.motion[0] for sensor in sensors])
    wanted = np.array(list(readings.values())) - [sensor.constant for sensor in sensors]
    scale = max(float(np.abs(plant.stiffness).max()), 1.0)
    x = np.zeros(n)
    for _ in range(_ROUNDS):
        force, slope = _of_laws(plant.laws, x)
        matrix = np.block(
            [[(plant.stiffness + slope) / scale, -plant.drives], [rows, np.zeros((len(rows), n_drives))]]
        )
        balance = np.concatenate([(plant.constant - force + slope @ x) / scale, wanted])
        found = np.linalg.lstsq(matrix, balance, rcond=1e-13)[0]
        moved, x, held = np.abs(found[:n] - x).max(), found[:n], scale * found[n:]
        if moved <= _SETTLED * max(np.abs(x).max(), 1e-3):
            break
    pulls = plant.stiffness @ x, plant.drives @ held, _of_laws(plant.laws, x)[0], plant.constant
    left = np.abs(pulls[0] - pulls[1] + pulls[2] - pulls[3])
    if np.any(left > _LEFT * max(np.abs(pulls).max(), 1e-300)):
        falling = ", ".join(compress(plant.bodies, left > 0.5 * left.max()))
        raise SettingError(
            f"there is no equilibrium: neither springs nor drives hold {falling} at the first reference; begin with "
            "another reference, or give a start of your own"
        )
    return np.concatenate([x, np.zeros(n)]), held


def _of_laws(laws: tuple[JointLaw, ...], x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Forces of all laws on the bodies at rest, and their slope."""
    force, slope = np.zeros(x.size), np.zeros((x.size, x.size))
    for law in laws:
        q = float(law.direction @ x)
        low, middle, high = (sum(law.limits(q + step)) / 2 for step in (-_STEP, 0.0, _STEP))
        force += middle * law.direction
        slope += (high - low) / (2 * _STEP) * np.outer(law.direction, law.direction)
    return force, slope
