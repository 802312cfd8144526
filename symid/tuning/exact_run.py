"""Noise-free run of an axis without imperfections, sampled at any rate, and the chirp that it follows by default."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from scipy.interpolate import CubicHermiteSpline, CubicSpline, PPoly

from symid.arrays import FloatArray
from symid.axis import Acceleration, Axis, Position
from symid.data import Log
from symid.errors import SettingError
from symid.signal_names import derivative_name
from symid.simulation import (
    Controller,
    Plant,
    SensorRow,
    Simulation,
    Trajectory,
    chirp,
    largest_within,
    plant_of,
    simulate,
)
from symid.simulation.plants import JointLaw
from symid.simulation.trajectories import Sweep

_PLACE, _PROBE = "place_of_{}", "probe_of_{}"
"""Names of the virtual sensors that record the motion of every body."""


@dataclass(frozen=True, eq=False)
class ExactRun:
    """Exact motion of every body, and the forces, of a noise-free simulation.

    The force of the simulation is held during a controller sample. At the middle of it the force is that of a
    continuous controller up to (w T)^2 / 24, which the rate of the controller makes small; there it is taken.
    """

    axis: Axis  # the axis, its sensors without imperfections
    simulation: Simulation  # as simulated, with sensors of every motion
    rows: Mapping[str, SensorRow]  # as in `Plant`
    laws: tuple[JointLaw, ...] = ()  # as in `Plant`

    @property
    def period(self) -> float:
        """Time between two samples of the controller, s."""
        return float(self.simulation.time[1] - self.simulation.time[0])

    @property
    def rate(self) -> float:
        """Rate of the controller, Hz."""
        return 1.0 / self.period

    @property
    def forces(self) -> dict[str, FloatArray]:
        """Force of each drive by its signal, from each sample to the next."""
        columns = self.simulation.forces.reshape(self.simulation.time.size, -1).T
        return {drive.signal: column for drive, column in zip(self.axis.drives, columns, strict=True)}

    def exact_signals(self, every: int = 1) -> dict[str, FloatArray]:
        """Coordinates with their exact derivatives, such as ``q_motor_d2``, and the forces that caused them, by name.

        `every` is the number of controller samples per sample.
        """
        run, kept = self.simulation, slice(1, None, every)
        n = run.accelerations.shape[1]
        motion = {}
        for body in self.axis.free_bodies:
            row = self.rows[_PLACE.format(body.name)].row
            exact = (run.states[:, :n], run.states[:, n:], run.accelerations)
            for order, values in enumerate(exact):
                motion[derivative_name(f"q_{body.name}", order)] = values[kept] @ row
        return motion | {name: force[:-1:every] for name, force in self.forces.items()}

    def log(self, frequency_hz: float, signals: Sequence[str] | None = None) -> Log:
        """Log of the given sensors, all by default, sampled at any rate, all signals at the time of the sample."""
        names = [*(signals or (sensor.signal for sensor in self.axis.sensors)), *self.forces]
        count = int((self.simulation.time.size - 1) * self.period * frequency_hz * (1 + 1e-12)) + 1
        if count < 2:
            raise SettingError(f"{frequency_hz:g} Hz leaves {count} samples of the run: choose a higher rate")
        time = self.simulation.time[0] + np.arange(count) / frequency_hz
        sampled = {name: self._interpolants[name](time) for name in names}
        return Log.from_arrays(
            sampled, sampling_period=1.0 / frequency_hz, start=time[0], source=f"simulated {self.axis.name}"
        )

    @cached_property
    def _interpolants(self) -> dict[str, PPoly]:
        """Cubics through the forces and readings, by signal."""
        forces = {name: CubicSpline(self._middle, force[:-1]) for name, force in self.forces.items()}
        return forces | {s.signal: self._interpolant(self.rows[s.signal]) for s in self.axis.sensors}

    @property
    def _middle(self) -> FloatArray:
        """Time at the middle of each sample but the last, s."""
        return np.asarray(self.simulation.time[:-1] + 0.5 * self.period)

    def _interpolant(self, reading: SensorRow) -> PPoly:
        """Cubic through exact values and slopes of a motion, or means of acceleration and force between samples."""
        run, n = self.simulation, self.simulation.accelerations.shape[1]
        x, v = run.states[:, :n], run.states[:, n:]
        of_place, of_speed, of_rate = reading.motion
        if reading.order == 0:
            return CubicHermiteSpline(run.time, x @ of_place + reading.constant, v @ of_place)
        if reading.order == 1:
            speed = CubicHermiteSpline(run.time, x @ of_speed, v @ of_speed).derivative()
            speed.c[-1] += reading.constant
            return speed
        if reading.order == 2:
            return CubicSpline(self._middle, np.diff(v @ of_rate) / self.period + reading.constant)
        slopes = v @ of_place + run.accelerations @ of_speed
        smooth = CubicHermiteSpline(run.time, x @ of_place + v @ of_speed, slopes)(self._middle)
        held = np.reshape(run.forces, (len(run.time), -1)) @ reading.drives
        of_law = np.zeros(len(self._middle))
        if reading.law is not None:
            law = self.laws[reading.law]
            motion = ((x, v), (v, run.accelerations))
            at, rate = (
                CubicHermiteSpline(run.time, y @ law.direction, slope @ law.direction)(self._middle)
                for y, slope in motion
            )
            of_law = reading.per_force * law.force(at, rate)
        return CubicSpline(self._middle, smooth + held[:-1] + of_law + reading.constant)


def exact_run(
    axis: Axis,
    parameters: Mapping[str, float],
    trajectory: Trajectory | Sequence[Trajectory],
    controller: Controller | Sequence[Controller],
) -> ExactRun:
    """Simulate an axis without noise, resolution or delay of its signals, and without imperfections.

    Parameters
    ----------
    axis : Axis
        The declared axis.
    parameters : mapping of str to float
        Values of its physical parameters, SI.
    trajectory : Trajectory or sequence of Trajectory
        Reference, one for all drives or one for each; its rate, that of the controllers, should be far above the
        motion's frequencies.
    controller : Controller or sequence of Controller
        One for each drive; reads sensors of the axis.

    Raises
    ------
    SettingError
        As `simulate`.

    Examples
    --------
    >>> from symid.axis import load_axis
    >>> from symid.simulation import chirp, plant_of, tuned_cascade
    >>> axis, values = load_axis("rigid_1m"), {"M": 5.0, "Fv": 3.0, "Fs": 2.0}
    >>> reference = chirp(0.5, 3.0, 1.0, 0.01, sampling_period=1e-3)
    >>> run = exact_run(axis, values, reference, tuned_cascade(plant_of(axis, values), "q"))
    >>> run.log(333.3).sampling_frequency
    333.3
    """
    perfect = axis.without(*axis.imperfections)
    for signal in axis.signal_units:
        perfect = perfect.with_signal(signal, noise=0.0)
    bodies = axis.free_bodies
    probes = tuple(Position(_PLACE.format(body.name), body) for body in bodies)
    accelerometer = Acceleration(_PROBE.format(bodies[0].name), bodies[0])
    probed = replace(perfect, sensors=(*perfect.sensors, *probes, accelerometer))
    run = simulate(probed, parameters, trajectory, controller)
    plant = plant_of(probed, parameters)
    return ExactRun(perfect, run, plant.sensors, plant.laws)


LOWEST_HZ = 0.1
"""Frequency at which the chirp of the paper starts, Hz."""
_RIGID_HZ = 20.0
"""Frequency at which it ends for an axis without a flexible mode, Hz."""
_BEYOND_MODES = 1.25
"""End of the chirp over the highest mode: 100 Hz over about 80 Hz in the paper."""
_SWEEP: Sweep = "logarithmic"
_USED = 0.9
"""Share of the tightest limit that the chirp uses."""


def excited_band(plant: Plant) -> tuple[float, float]:
    """Band of a chirp that excites every mode, Hz: 0.1 Hz to 1.25 times the highest mode, or to 20 Hz without modes."""
    return LOWEST_HZ, _BEYOND_MODES * plant.highest_mode or _RIGID_HZ


def tuning_chirp(
    plant: Plant,
    rate: float,
    seconds: float = 10.0,
    band: tuple[float, float] | None = None,
    *,
    travel: float = 0.2,
    speed: float = 0.5,
    acceleration: float = 5.0,
) -> Trajectory:
    """Chirp of constant velocity, its frequency rising exponentially, through every mode of the axis.

    Parameters
    ----------
    plant : Plant
        The axis.
    rate : float
        Samples per second, Hz.
    seconds : float
        Duration.
    band : tuple of two float, optional
        Frequencies at the beginning and the end, Hz; `excited_band` by default.
    travel, speed, acceleration : float
        Limits from zero, m or rad and s; the chirp uses nine tenths of the tightest one.
    """
    made = partial(
        chirp,
        *(band or excited_band(plant)),
        seconds,
        sampling_period=1 / rate,
        quantity="velocity",
        sweep=_SWEEP,
    )
    limits = {"travel": travel, "speed": speed, "acceleration": acceleration}
    return largest_within(made, limits, _USED)
