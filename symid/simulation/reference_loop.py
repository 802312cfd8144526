"""The axis under its controllers along the reference of a log, without any noise."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from symid.arrays import FloatArray
from symid.axis import Axis, controlled_of
from symid.data import REFERENCE, Log
from symid.errors import SettingError
from symid.simulation.closed_loop import simulate
from symid.simulation.controllers.cascade_tuning import tuned_cascades
from symid.simulation.controllers.controller import Cascade, Controller
from symid.simulation.plants.forward_dynamics import plant_of
from symid.simulation.trajectories.trajectory import Trajectory

_SPLINE = 5
_SLOWEST_HZ = 1000.0
"""Least rate of a controller whose rate is not given; it runs at a multiple of the rate of the log."""


def without_noise(axis: Axis) -> Axis:
    """The axis without noise and resolution of its signals; delays stay."""
    return replace(
        axis,
        drive=tuple(replace(drive, noise=0.0, resolution=0.0) for drive in axis.drives),
        sensors=tuple(replace(sensor, noise=0.0, resolution=0.0) for sensor in axis.sensors),
    )


@dataclass(frozen=True)
class ClosedLoop:
    """Closed loop in which the axis follows a reference.

    Parameters
    ----------
    axis : Axis
        The declared axis; noise and resolution of its signals are ignored, delays of its sensors are not.
    controller : Controller or sequence of Controller, optional
        Controller of the machine, or one for each drive; by default cascades, tuned to the parameters or read from the
        log.
    rate_hz : float, optional
        Rate of the controller, a multiple of the rate of the log; by default the lowest one of at least 1 kHz.
    trajectory : Trajectory or sequence of Trajectory, optional
        Commanded motion at the controller's rate, or one for each drive. By default it is interpolated by splines from
        the log's column reference, or reference_F of a drive F.

    Raises
    ------
    SettingError
        If the axis has no position or velocity to control, or the rate is not positive.
    """

    axis: Axis
    controller: Controller | Sequence[Controller] | None = None
    rate_hz: float | None = None
    trajectory: Trajectory | Sequence[Trajectory] | None = None

    def __post_init__(self) -> None:
        if controlled_of(self.axis.sensors) is None:
            raise SettingError(
                f"axis {self.axis.name!r} has no sensor of a position or velocity, of which a controller is made: "
                "declare one, or identify by wls or oe"
            )
        if self.rate_hz is not None and not (math.isfinite(self.rate_hz) and self.rate_hz > 0):
            raise SettingError(f"the controller's rate is {self.rate_hz:g} Hz: give a positive number")
        object.__setattr__(self, "axis", without_noise(self.axis))

    @classmethod
    def with_gains(cls, axis: Axis, gains: Mapping[str, float], rate_hz: float | None = None) -> ClosedLoop:
        """The loop under a cascade for each drive with given gains, by field of `Cascade`; other gains are 0.

        Without gains the controller stays undetermined. SettingError if the gain of the velocity loop is missing.
        """
        loop = cls(axis, rate_hz=rate_hz)
        if not gains:
            return loop
        if "velocity_gain" not in gains:
            raise SettingError("`controller` lacks Kpv: give Kpp, Kpv and Kiv of the machine's controller")
        cascades = (Cascade(signal, 0.0, 0.0, 0.0) for signal in axis.controlled_signals)
        first, *others = (cascade.with_gains(**gains) for cascade in cascades)
        return replace(loop, controller=(first, *others) if others else first)

    def tuned(self, parameters: Mapping[str, float]) -> ClosedLoop:
        """The loop with cascades tuned to parameter values."""
        return replace(
            self, controller=tuned_cascades(plant_of(self.axis, parameters), self.axis.controlled_signals)
        )

    def run(self, parameters: Mapping[str, float], log: Log) -> Log:
        """Log of the simulated axis at the samples of the given log.

        The force is held over the controller's period (`held_for`): on average it acts half a period late.

        Raises
        ------
        SettingError
            If the log has no reference, the parameters are not possible, the rates do not divide, or the axis runs
            away.
        """
        self.check(log)
        controller = self.controller or self.tuned(parameters).controller
        assert controller is not None
        return simulate(
            self.axis,
            parameters,
            self._references(log),
            controller,
            frequency_hz=log.sampling_frequency,
            start="equilibrium",
        ).log

    def check(self, log: Log) -> None:
        """SettingError if the log has no reference, or the controller's rate is not a multiple of its rate."""
        if self.trajectory is None and not all(name in log.signals for name in self.reference_columns(log)):
            raise SettingError(
                f"{log.source} has no column reference (the commanded position), without which the closed loop cannot "
                "be simulated: map one with `columns` reference=NAME, or take `method=wls`"
            )
        self._samples_for_one(log)

    def held_for(self, log: Log) -> float:
        """Period of the controller, s."""
        return log.sampling_period / self._samples_for_one(log)

    def reference_columns(self, log: Log) -> tuple[str, ...]:
        """Column with the reference of each drive: its own, or else the common one."""
        own = (f"{REFERENCE}_{drive.signal}" for drive in self.axis.drives)
        return tuple(name if name in log.signals else REFERENCE for name in own)

    def _references(self, log: Log) -> tuple[Trajectory, ...]:
        """Commanded motions at the controller's rate, shifted to begin at zero, where the simulated axis rests."""
        given = self.trajectory
        if given is not None:
            paths = (given,) * len(self.axis.drives) if isinstance(given, Trajectory) else tuple(given)
            return tuple(path.shifted(-float(path.position[0])) for path in paths)
        factor = self._samples_for_one(log)
        return tuple(_splined(log[name] - log[name][0], log, factor) for name in self.reference_columns(log))

    def _samples_for_one(self, log: Log) -> int:
        if self.rate_hz is None:
            return max(1, math.ceil(_SLOWEST_HZ * log.sampling_period - 1e-9))
        ratio = self.rate_hz * log.sampling_period
        if round(ratio) < 1 or not math.isclose(ratio, round(ratio), rel_tol=1e-6):
            raise SettingError(
                f"the controller's rate of {self.rate_hz:g} Hz is not a multiple of the "
                f"{log.sampling_frequency:g} Hz of {log.source}: give one that is (`rate_hz`)"
            )
        return round(ratio)


def _splined(reference: FloatArray, log: Log, factor: int) -> Trajectory:
    """Reference of a log at `factor` times its rate, by quintic splines."""
    order = max(min(_SPLINE, (reference.size - 1) // 2 * 2 - 1), 1)
    spline = scipy.interpolate.make_interp_spline(np.arange(reference.size), reference, order)
    places = np.arange((reference.size - 1) * factor + 1) / factor
    rate = log.sampling_frequency
    return Trajectory(
        position=spline(places),
        velocity=rate * spline(places, 1),
        acceleration=rate**2 * spline(places, 2),
        sampling_period=log.sampling_period / factor,
        name=f"{REFERENCE} of {log.source}",
        start=log.start,
    )
