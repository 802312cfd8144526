"""Error of the simulated closed loop: the axis under its known controller along its known reference.

Noise of the readings goes round the loop, so that the errors of readings and force are correlated in time and with each
other. An autoregressive model of them, fitted at the parameters of the moment, whitens them: generalised least squares,
iterated. Nothing is assumed of the force between samples: it is simulated at the controller's own rate.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from symid.arrays import FloatArray
from symid.axis import Axis
from symid.data import Log
from symid.estimation import Autoregression, autoregression
from symid.output_error.predicted_log import OutputErrorPrediction
from symid.simulation import ClosedLoop

WHITENING_ORDER = 12
"""Order of the autoregressive model of the errors."""
_OFFSET_STEP = 1e-2
_MEDIAN_OF_FOURTH_DIFFERENCES = 0.6745 * math.sqrt(70.0)
"""Median of the absolute fourth difference of white noise of unit deviation."""
_SMALLEST_NOISE = 1e-9
"""Lowest noise of a signal, relative to its spread."""


def whitening_of(errors: FloatArray) -> Autoregression:
    """Autoregressive model of errors of shape (n_samples, n_signals), scaled by their noise."""
    return autoregression(errors.T, np.ones(len(errors), dtype=bool), WHITENING_ORDER)


@dataclass(frozen=True, eq=False)
class ClosedLoopError:
    """Readings and force of a log, which begins at rest, less those of the simulated closed loop, whitened.

    Until a whitening is fitted, each signal is scaled by its own noise.
    """

    loop: ClosedLoop
    log: Log
    signals: tuple[str, ...]
    whitening: Autoregression | None = None

    @property
    def first_nuisance(self) -> FloatArray:
        """Offset of each position sensor, in units of its typical noise."""
        return np.zeros(len(self._positions))

    @property
    def nuisance_steps(self) -> FloatArray:
        """Difference steps of the nuisance parameters."""
        return np.full(len(self._positions), _OFFSET_STEP)

    @property
    def trials(self) -> tuple[tuple[int, int], ...]:
        """Iterations of each round of trials of starts, and how many go on after it."""
        return ((2, 4), (6, 2), (15, 1))

    @property
    def has_motion(self) -> bool:
        """Whether the log holds any motion."""
        return bool(np.ptp(self.log[self.signals[0]]) > 0)

    @property
    def n_signals(self) -> int:
        """Number of signals that are compared: sensors and forces."""
        return len(self._compared)

    def excerpt(self) -> ClosedLoopError:
        """The run itself: a loop is simulated from its beginning."""
        return self

    @property
    def is_settled(self) -> bool:
        """The whitening follows from the parameters."""
        return False

    def errors(self, parameters: Mapping[str, float], nuisance: FloatArray) -> FloatArray:
        """Measured less simulated, sensors first, then the forces, of shape (n_samples, n_signals)."""
        simulated = self.loop.run(parameters, self.log)
        errors = np.stack([self.log[name] - simulated[name] for name in self._compared], axis=1)
        scale = self._scale
        for offset, place in zip(nuisance, self._positions, strict=True):
            errors[:, place] -= self.log[self.signals[place]][0] + offset * scale[place]
        return errors

    def scaled(self, parameters: Mapping[str, float], nuisance: FloatArray) -> FloatArray:
        """Whitened errors of all signals as one vector."""
        errors = self.errors(parameters, nuisance) / self._scale
        return errors.ravel() if self.whitening is None else self.whitening.by_sample(errors.ravel())

    def updated(
        self, parameters: Mapping[str, float], nuisance: FloatArray
    ) -> tuple[ClosedLoopError, FloatArray]:
        """The run with the whitening of its errors at these parameters."""
        errors = self.errors(parameters, nuisance) / self._scale
        return replace(self, whitening=whitening_of(errors)), nuisance

    def noise(self, parameters: Mapping[str, float], nuisance: FloatArray) -> dict[str, float]:
        """Standard deviations of the errors by signal, SI: noise and what the loop makes of it."""
        deviations = np.std(self.errors(parameters, nuisance), axis=0)
        return dict(zip(self._compared, map(float, deviations), strict=True))

    def prediction(
        self, log: Log, parameters: Mapping[str, float], nuisance: FloatArray
    ) -> OutputErrorPrediction:
        """Readings and errors of a log."""
        errors = self.errors(parameters, nuisance)[:, : len(self.signals)]
        readings = np.stack([self.log[signal] for signal in self.signals], axis=1)
        return OutputErrorPrediction(log.source, self.log.time, readings, errors, self.signals)

    @property
    def _axis(self) -> Axis:
        return self.loop.axis

    @property
    def _compared(self) -> tuple[str, ...]:
        return (*self.signals, *(drive.signal for drive in self._axis.drives))

    @property
    def _positions(self) -> list[int]:
        orders = {sensor.signal: sensor.derivative for sensor in self._axis.sensors}
        return [place for place, signal in enumerate(self.signals) if orders[signal] == 0]

    @cached_property
    def _scale(self) -> FloatArray:
        """Noise of each signal, from the median of its fourth differences, which smooth motion does not affect."""
        values = np.stack([self.log[name] for name in self._compared], axis=1)
        noise = np.median(np.abs(np.diff(values, n=4, axis=0)), axis=0) / _MEDIAN_OF_FOURTH_DIFFERENCES
        floor = _SMALLEST_NOISE * np.maximum(np.std(values, axis=0), np.finfo(float).tiny)
        return np.asarray(np.maximum(noise, floor))
