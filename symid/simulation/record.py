"""Record of a simulation in progress."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from symid.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class MotionRecord:
    """Exact motion at the samples of a controller, and forces between them.

    Parameters
    ----------
    states : array of shape (n_samples + 1, 2 n)
        Displacements and velocities.
    accelerations : array of shape (n_samples + 1, n)
        Under the force before the sample; zero if no sensor reads one.
    forces : array of shape (n_samples,)
        Drive force from each sample to the next.
    between : dict of str to array of shape (n_samples,)
        Values that sensors took between one sample and the next.
    """

    states: FloatArray
    accelerations: FloatArray
    forces: FloatArray
    between: dict[str, FloatArray]

    @classmethod
    def empty(cls, n_samples: int, n_bodies: int, between: Sequence[str]) -> Self:
        """An empty record for a number of samples."""
        return cls(
            states=np.zeros((n_samples + 1, 2 * n_bodies)),
            accelerations=np.zeros((n_samples + 1, n_bodies)),
            forces=np.zeros(n_samples),
            between={signal: np.zeros(n_samples) for signal in between},
        )
