"""Exact motion of an axis between two events: linear, under constant forces, with some joints stuck.

With the joints S stuck, D x(1) = 0 for their directions D. The forces that hold them are
lambda = (D M^-1 D')^-1 D M^-1 (w - C x(1) - K x), w being all other forces, and the motion is linear again.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property, lru_cache

import numpy as np

from symid.arrays import FloatArray
from symid.simulation.plant import Plant

ORDER = 20
"""Terms of the Taylor series; within `Flow.reach` the next one is below 1/20! = 4e-19 of the first."""
_DEPENDENT = 1e-10
"""Relative eigenvalue of the mobility of stuck joints, each scaled to 1, below which they depend on each other."""


class Flow:
    """Motion under a constant generalised force with given joints stuck.

    Parameters
    ----------
    plant : Plant
        The axis.
    stuck : sequence of int
        Indices of the laws whose joints do not move.

    Examples
    --------
    >>> from symid.axis import load_axis
    >>> from symid.simulation.forward_dynamics import plant_of
    >>> flow = Flow(plant_of(load_axis("rigid_1m"), {"M": 2.0, "Fv": 0.0, "Fs": 0.0}), ())
    >>> of_state, of_force = flow.transition(0.5)
    >>> (of_state @ [1.0, 3.0] + of_force @ [4.0]).tolist()
    [2.75, 4.0]
    """

    def __init__(self, plant: Plant, stuck: Sequence[int]) -> None:
        n = len(plant.bodies)
        self.stuck = tuple(stuck)
        inverse = np.linalg.inv(plant.mass)
        directions = np.array([plant.laws[j].direction for j in stuck]).reshape(len(self.stuck), n)
        # Joints that depend on each other, such as two carriages and the turn of their beam, share what holds them.
        felt = directions @ inverse @ directions.T
        size = 1.0 / np.sqrt(np.diag(felt))
        shared = np.linalg.pinv(felt * np.outer(size, size), rcond=_DEPENDENT, hermitian=True)
        holding = np.outer(size, size) * shared @ directions @ inverse
        free = inverse - inverse @ directions.T @ holding
        motion = np.hstack([plant.stiffness, plant.damping])
        self.acceleration_rows = np.hstack([-free @ motion, free])
        self.holding_rows = np.hstack([-holding @ motion, holding])
        frequency = math.sqrt(np.linalg.norm(free @ plant.stiffness, 2))
        self.reach = 1.0 / max(frequency + float(np.linalg.norm(free @ plant.damping, 2)), 1.0)
        self.transition = lru_cache(maxsize=64)(self._transition)

    def _transition(self, duration: float) -> tuple[FloatArray, FloatArray]:
        """Matrices of state and force over a duration, by scaling and squaring of the Taylor series.

        SciPy's matrix exponential takes milliseconds for matrices of this size, which its library shares among threads.
        """
        doublings = max(math.ceil(math.log2(duration / self.reach)), 0) if duration > 0 else 0
        whole = np.tensordot((duration / 2**doublings / self.reach) ** np.arange(ORDER), self.terms, 1)
        size = len(whole)
        transition, gain = whole[:, :size], whole[:, size:]
        for _ in range(doublings):
            transition, gain = transition @ transition, transition @ gain + gain
        return transition, gain

    @cached_property
    def terms(self) -> FloatArray:
        """Terms of the exponential over `reach`, of shape (terms, 2 n, 3 n)."""
        n = len(self.acceleration_rows)
        generator = np.zeros((3 * n, 3 * n))
        generator[:n, n : 2 * n] = np.eye(n)
        generator[n : 2 * n] = self.acceleration_rows
        term, terms = np.eye(3 * n), []
        for order in range(1, ORDER + 1):
            terms.append(term[: 2 * n])
            term = generator @ term * (self.reach / order)
        return np.array(terms)
