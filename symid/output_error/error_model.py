"""Assumptions of the comparison of a log with its axis: course of the force between samples, and controller."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from symid.codegen import GeneratedModel, declared_delays
from symid.data import Log, require_times_within
from symid.errors import SettingError
from symid.identification import Preparation
from symid.output_error.closed_loop_error import ClosedLoopError
from symid.output_error.likelihood_fit import LikelihoodFit, fit_errors
from symid.output_error.prediction_error import PredictionError
from symid.output_error.run import run_of
from symid.output_error.search import RunError
from symid.signal_processing import QuinticSpline
from symid.simulation import ClosedLoop, ForwardDynamics

_VELOCITY_BAND = 0.2
"""Cutoff over sampling frequency for the velocities whose signs determine friction."""


@dataclass(frozen=True, eq=False)
class ErrorModel:
    """Model and assumptions for the comparison with a log."""

    model: GeneratedModel  # for the sensors used
    dynamics: ForwardDynamics  # the axis
    preparation: Preparation  # only `late` and `standstill` are used
    # course of the forces between samples: held, smooth, or that of the simulated closed loop
    force: Literal["held", "smooth", "simulated"]
    free_timing: bool = False  # whether the time by which the forces are recorded late is estimated
    loop: ClosedLoop | None = None  # of a simulated force

    def error(self, log: Log, late: float | None = None) -> RunError:
        """Error of a log, late readings where they belong; `late` (s) is that of the forces, else the preparation's.

        LogError or SettingError if the log does not have a signal, or if forces of several drives are late by
        different times.
        """
        require_times_within(log.source, self.preparation.late, log.n_samples * log.sampling_period)
        simulated = declared_delays(self.loop.axis) if self.loop else {}
        late_readings = {
            sensor.signal: seconds
            for sensor in self.dynamics.axis.sensors
            if sensor.signal in log.signals
            and (seconds := self.preparation.late.get(sensor.signal, 0.0) - simulated.get(sensor.signal, 0.0))
        }
        log = _earlier(log, late_readings) if late_readings else log
        if self.force == "simulated":
            assert self.loop is not None
            return ClosedLoopError(self.loop, log, self.model.measured)
        declared = {d.signal: self.preparation.late.get(d.signal, 0.0) for d in self.dynamics.axis.drives}
        if late is None and len(set(declared.values())) > 1:
            delays = ", ".join(f"{signal} {seconds:g} s" for signal, seconds in declared.items())
            raise SettingError(
                f"the forces are late by different times ({delays}): output error takes one for all drives, "
                "give each the same `late` or take `method=wls`"
            )
        run = run_of(
            self.dynamics,
            log,
            self.model.measured,
            self.force,
            cutoff_hz=_VELOCITY_BAND * log.sampling_frequency,
            late=next(iter(declared.values())) if late is None else late,
            standstill=self.preparation.standstill,
        )
        return PredictionError(self.dynamics, run, run.known_motions, self.free_timing)

    def fit(self, logs: Sequence[Log], starts: Sequence[Mapping[str, float]]) -> LikelihoodFit | None:
        """Maximum-likelihood estimate from logs; None if no start can be evaluated."""
        nyquist = 0.5 * max(log.sampling_frequency for log in logs)
        try:
            return fit_errors(self.model, self.dynamics, [self.error(log) for log in logs], starts, nyquist)
        except np.linalg.LinAlgError:
            return None


def _earlier(log: Log, late: Mapping[str, float]) -> Log:
    """The log with late readings (s) moved to the times at which they were taken, cut to where all are known."""
    shifts = {name: seconds / log.sampling_period for name, seconds in late.items()}
    moved = {name: QuinticSpline(log[name]).earlier(samples) for name, samples in shifts.items()}
    before, after = (max(0, math.ceil(end)) for end in (-min(shifts.values()), max(shifts.values())))
    return replace(log, signals={**log.signals, **moved}).window(before, log.n_samples - after)
