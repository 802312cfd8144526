"""Exact motion of an axis between two events: linear, with constant forces, some joints stuck.

With the joints S stuck, D x(1) = 0 for their directions D. The forces that hold them are
lambda = (D M^-1 D')^-1 D M^-1 (w - C x(1) - K x), w being all other forces, and the motion is linear again.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from scipy.linalg import expm

from symid.arrays import FloatArray
from symid.simulation.plant import Plant


class Flow:
    """Motion under a constant generalised force with given joints stuck.

    Parameters
    ----------
    plant : Plant
        The axis.
    stuck : sequence of int
        Indices of the laws whose joints do not move.
    """

    def __init__(self, plant: Plant, stuck: Sequence[int]) -> None:
        n = len(plant.bodies)
        self.stuck = tuple(stuck)
        inverse = np.linalg.inv(plant.mass)
        directions = np.array([plant.laws[j].direction for j in stuck]).reshape(len(self.stuck), n)
        holding = np.linalg.solve(directions @ inverse @ directions.T, directions @ inverse)
        free = inverse - inverse @ directions.T @ holding
        self._generator = np.zeros((3 * n, 3 * n))
        self._generator[:n, n : 2 * n] = np.eye(n)
        self._generator[n : 2 * n, :n] = -free @ plant.stiffness
        self._generator[n : 2 * n, n : 2 * n] = -free @ plant.damping
        self._generator[n : 2 * n, 2 * n :] = free
        self._acceleration = self._generator[n : 2 * n]
        self._holding = holding
        self._stiffness, self._damping = plant.stiffness, plant.damping
        self.transition = lru_cache(maxsize=64)(self._transition)

    def advance(self, state: FloatArray, force: FloatArray, duration: float) -> FloatArray:
        """State (displacements, velocities) after a duration under a constant force."""
        transition, gain = self.transition(duration)
        return np.asarray(transition @ state + gain @ force)

    def acceleration(self, state: FloatArray, force: FloatArray) -> FloatArray:
        """Accelerations of the bodies, of shape (n,)."""
        size = len(state)
        return np.asarray(self._acceleration[:, :size] @ state + self._acceleration[:, size:] @ force)

    def _transition(self, duration: float) -> tuple[FloatArray, FloatArray]:
        """Matrices of state and force, by the matrix exponential."""
        whole = expm(self._generator * duration)
        size = 2 * (len(whole) // 3)
        return whole[:size, :size], whole[:size, size:]

    def holding_forces(self, state: FloatArray, force: FloatArray) -> FloatArray:
        """Forces that keep the stuck joints at rest, in the order of `stuck`."""
        n = len(force)
        return np.asarray(self._holding @ (force - self._damping @ state[n:] - self._stiffness @ state[:n]))
