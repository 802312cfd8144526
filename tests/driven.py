"""Axes in simulations: under a given force, by the equation of motion, under a controller that is asked each time."""

from collections.abc import Mapping

import numpy as np

from symid import Axis
from symid.simulation import Controller, OpenLoop, Plant, Trajectory, simulate


def driven(
    axis: Axis,
    values: Mapping[str, float],
    forces: np.ndarray,
    period: float,
    start: np.ndarray | None = None,
) -> np.ndarray:
    """States at the begin and after each force, held for a period, of shape (n_forces + 1, 2 n)."""
    still = np.zeros(len(forces) + 1)
    rest, given = Trajectory(still, still, still, period, "rest"), OpenLoop(np.append(forces, 0.0))
    return simulate(axis, values, rest, given, start=start).states


def acceleration(plant: Plant, state: np.ndarray, force: float) -> np.ndarray:
    """M^-1 (B F + c - C v - K x - laws) of a state in which all joints slide."""
    x, v = np.split(state, 2)
    acting = plant.drive * force + plant.constant - plant.damping @ v - plant.stiffness @ x
    for law in plant.laws:
        acting = acting - law.direction * law.force(float(law.direction @ x), float(law.direction @ v))
    return np.linalg.solve(plant.mass, acting)


def called(controller: Controller) -> Controller:
    """The controller, of which the simulation does not know that its law is linear: it asks for each force."""
    kind = type(controller)
    unknown = type(f"Called{kind.__name__}", (kind,), {"force": kind.force})
    return unknown(**vars(controller))
