"""The motion of a simulation, and its readings by sensors with delay, noise and resolution."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from symid.arrays import FloatArray
from symid.axis import Sensor
from symid.simulation.plants.law_code import array_function
from symid.simulation.plants.plant import Plant

_WHOLE = 1e-9
"""Distance from a whole number of samples, relative to one, below which a delay counts as whole."""


class MotionRecord(NamedTuple):
    """Exact motion at the samples of a controller, and forces between them."""

    states: FloatArray  # shape (n_samples + 1, 2 n): displacements and velocities
    # shape (n_samples + 1, n): under the force before the sample; zero if no sensor reads one
    accelerations: FloatArray
    forces: FloatArray  # shape (n_samples, n_drives): drive forces from each sample to the next
    # shape (n_between, n_samples): values that sensors took between one sample and the next
    between: FloatArray

    @classmethod
    def empty(cls, n_samples: int, n_bodies: int, n_drives: int, n_between: int) -> MotionRecord:
        """An empty record for a number of samples."""
        return cls(
            states=np.zeros((n_samples + 1, 2 * n_bodies)),
            accelerations=np.zeros((n_samples + 1, n_bodies)),
            forces=np.zeros((n_samples, n_drives)),
            between=np.zeros((n_between, n_samples)),
        )


class SensorChannel:
    """A sensor in a simulation.

    In each interval between two samples of the controller it takes one value, `moment` after the start of the interval;
    sample k reads the value of interval k - 1 - age. Without delay the moment is the end of the interval. `misread` is
    NumPy code of the erroneous reading as a function of the exact value y.
    """

    def __init__(
        self,
        sensor: Sensor,
        plant: Plant,
        n_samples: int,
        period: float,
        random: np.random.Generator,
        misread: str | None = None,
    ) -> None:
        self.signal, self.step = sensor.signal, sensor.resolution
        self.reading = plant.sensors[sensor.signal]
        self.law = None if self.reading.law is None else plant.laws[self.reading.law]
        if self.reading.constant:
            misread = re.sub(r"\by\b", f"(y + {self.reading.constant!r})", misread or "y")
        self.misread = misread
        self.noise = sensor.noise * random.standard_normal(n_samples)
        samples = sensor.delay / period
        self.age = math.floor(samples + _WHOLE)
        late = samples - self.age
        self.moment = period if late < _WHOLE else (1.0 - late) * period
        self.is_between = self.moment < period
        self.period = period

    @property
    def motion_row(self) -> FloatArray:
        """Exact value as a row on displacements, velocities and accelerations, of shape (3 n,)."""
        return np.asarray(self.reading.motion.ravel())

    def read_all(self, record: MotionRecord, between: Sequence[SensorChannel]) -> FloatArray:
        """Readings at all samples; the sensors `between` have a row in the record's array of that name."""
        exact = np.hstack([record.states, record.accelerations]) @ self.motion_row
        # Forces are held and jump at samples, where the mean of both sides is read.
        acting = record.forces @ self.reading.drives
        of_law = self._of_law(record.states)
        if self.is_between:
            share = self.moment / self.period
            inner = (
                record.between[between.index(self)] + acting + (1 - share) * of_law[:-1] + share * of_law[1:]
            )
            values = np.concatenate([np.full(self.age + 1, exact[0] + of_law[0]), inner])
        else:
            sides = np.concatenate([[0.0], acting, acting[-1:]])
            values = np.concatenate(
                [np.full(self.age, exact[0] + of_law[0]), exact + of_law + (sides[1:] + sides[:-1]) / 2]
            )
        values = values[: self.noise.size]
        if self.misread is not None:
            values = array_function(self.misread, ("y",))(values, values, values)
        return in_steps(values + self.noise, self.step)

    def _of_law(self, states: FloatArray) -> FloatArray:
        """Part of the reading of a spring's force that its nonlinear laws add, at all states."""
        if self.law is None:
            return np.zeros(len(states))
        q, v = np.split(states, 2, axis=1)
        return np.asarray(
            self.reading.per_force * self.law.force(q @ self.law.direction, v @ self.law.direction)
        )


def in_steps(values: FloatArray, step: float) -> FloatArray:
    """Values rounded to a resolution, if there is one."""
    return np.asarray(step * np.round(values / step)) if step else values
