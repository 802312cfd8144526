"""The motion of a simulation, and its readings by sensors with delay, noise and resolution."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from symid.arrays import FloatArray
from symid.axis import Sensor
from symid.simulation.mode import StickSlipMode
from symid.simulation.plant import Plant

_WHOLE = 1e-9
"""Distance from a whole number of samples, relative to one, below which a delay counts as whole."""


@dataclass(frozen=True, eq=False)
class MotionRecord:
    """Exact motion at the samples of a controller, and forces between them.

    Parameters
    ----------
    states : array of shape (n_samples + 1, 2 n)
        Displacements and velocities.
    accelerations : array of shape (n_samples + 1, n)
        Under the force before the sample; zero if no sensor reads one.
    forces : array of shape (n_samples, n_drives)
        Drive forces from each sample to the next.
    between : dict of str to array of shape (n_samples,)
        Values that sensors took between one sample and the next.
    """

    states: FloatArray
    accelerations: FloatArray
    forces: FloatArray
    between: dict[str, FloatArray]

    @classmethod
    def empty(cls, n_samples: int, n_bodies: int, n_drives: int, between: Sequence[str]) -> Self:
        """An empty record for a number of samples."""
        return cls(
            states=np.zeros((n_samples + 1, 2 * n_bodies)),
            accelerations=np.zeros((n_samples + 1, n_bodies)),
            forces=np.zeros((n_samples, n_drives)),
            between={signal: np.zeros(n_samples) for signal in between},
        )


class SensorChannel:
    """A sensor in a simulation.

    In each interval between two samples of the controller it takes one value, `moment` after the begin of the interval;
    sample k reads the value of interval k - 1 - age. Without delay the moment is the interval's end. `misread` adds the
    error of the sensor to exact values.
    """

    def __init__(
        self,
        sensor: Sensor,
        plant: Plant,
        n_samples: int,
        period: float,
        random: np.random.Generator,
        misread: Callable[[FloatArray], FloatArray] | None = None,
    ) -> None:
        self.misread = misread
        self.signal, self.step = sensor.signal, sensor.resolution
        self.row, self.order = plant.sensors[sensor.signal]
        self.noise = sensor.noise * random.standard_normal(n_samples)
        samples = sensor.delay / period
        self.age = math.floor(samples + _WHOLE)
        late = samples - self.age
        self.moment = period if late < _WHOLE else (1.0 - late) * period
        self.is_between = self.moment < period

    def of_state(self, mode: StickSlipMode) -> tuple[FloatArray, FloatArray, float]:
        """Value as rows on the state and the drive forces and a constant, in a mode without varying laws."""
        n = self.row.size
        if self.order == 2:
            rows = self.row @ mode.flow.acceleration_rows
            forces = rows[2 * n :]
            return rows[: 2 * n], forces @ mode.plant.drives, float(forces @ mode.constant)
        row = np.zeros(2 * n)
        row[self.order * n : (self.order + 1) * n] = self.row
        return row, np.zeros(mode.plant.drives.shape[1]), 0.0

    def of_begin(self, mode: StickSlipMode) -> tuple[FloatArray, FloatArray, float]:
        """The value in terms of the state at the begin of the interval."""
        row, drives, constant = self.of_state(mode)
        step = mode.step(self.moment)
        return row @ step.transition, row @ step.drives + drives, float(row @ step.offset) + constant

    def exact(self, record: MotionRecord, samples: slice) -> FloatArray:
        """Exact values at samples."""
        n = self.row.size
        if self.order == 2:
            return np.asarray(record.accelerations[samples] @ self.row)
        return np.asarray(record.states[samples, self.order * n : (self.order + 1) * n] @ self.row)

    def past(self, record: MotionRecord, k: int) -> FloatArray:
        """Values of intervals k - 1 - age to k - 1, that of the start before the first one; shape (age + 1,)."""
        intervals = np.arange(k - 1 - self.age, k)
        if self.is_between:
            known = record.between[self.signal][np.maximum(intervals, 0)]
            return np.where(intervals < 0, self.exact(record, slice(0, 1)), known)
        first = max(k - self.age, 0)
        values = self.exact(record, slice(first, k + 1))
        return np.concatenate([np.full(self.age + 1 - values.size, values[0]), values])

    def read(self, record: MotionRecord, k: int) -> float:
        """Reading at sample k, for the controller."""
        return float(in_steps(self._read(self.past(record, k)[:1]) + self.noise[k], self.step)[0])

    def read_all(self, record: MotionRecord) -> FloatArray:
        """Readings at all samples."""
        exact = self.exact(record, slice(None))
        if self.is_between:
            values = [np.full(self.age + 1, exact[0]), record.between[self.signal]]
        else:
            values = [np.full(self.age, exact[0]), exact]
        return in_steps(self._read(np.concatenate(values)[: self.noise.size]) + self.noise, self.step)

    def _read(self, exact: FloatArray) -> FloatArray:
        return exact if self.misread is None else self.misread(exact)


def in_steps(values: FloatArray, step: float) -> FloatArray:
    """Values rounded to a resolution, if there is one."""
    return np.asarray(step * np.round(values / step)) if step else values
