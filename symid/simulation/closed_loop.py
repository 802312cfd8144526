"""Simulation of an axis under its controller, to a log as its drive would record it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from symid.arrays import FloatArray
from symid.axis import Axis, Sensor
from symid.data import Log
from symid.errors import SettingError
from symid.simulation.controller import Command, Controller
from symid.simulation.engine import Engine
from symid.simulation.plant import Plant, plant_of
from symid.simulation.trajectory import Trajectory

_RUNAWAY = 1e100
"""A drive force beyond this is that of an unstable loop."""


@dataclass(frozen=True, eq=False)
class Simulation:
    """What a simulation leaves.

    Parameters
    ----------
    log : Log
        Sensor readings, force and reference, as recorded.
    time : array of shape (n_samples,)
        Times of the controller's samples, s.
    states : array of shape (n_samples, 2 n)
        Exact displacements and velocities of the bodies.
    accelerations : array of shape (n_samples, n)
        Exact accelerations just before a sample's force acts; zero if the axis has no accelerometer.
    forces : array of shape (n_samples,)
        Drive force from each sample to the next.
    """

    log: Log
    time: FloatArray
    states: FloatArray
    accelerations: FloatArray
    forces: FloatArray


def simulate(
    axis: Axis,
    parameters: Mapping[str, float],
    trajectory: Trajectory,
    controller: Controller,
    *,
    frequency_hz: float | None = None,
    seed: int = 0,
    steps: int = 1,
) -> Simulation:
    """Simulate an axis along a trajectory; the controller runs at the trajectory's rate.

    Parameters
    ----------
    axis : Axis
        The declared axis.
    parameters : mapping of str to float
        Values of its physical parameters, SI.
    trajectory : Trajectory
        Reference; its sampling period is the controller's.
    controller : Controller
        Its force acts, held, from one sample to the next.
    frequency_hz : float, optional
        Rate of the recorded log, of which the controller's rate must be a multiple; the controller's rate by default.
    seed : int
        Of the noise that the signals of the axis declare.
    steps : int
        Steps of the engine in one controller sample; only laws that vary with speed or displacement need more than one.

    Returns
    -------
    Simulation
        A force of the log is sent at the time of its sample and held: it acts half a controller sample late.

    Raises
    ------
    SettingError
        If a parameter is missing, the rates do not divide, or the axis runs away.

    Examples
    --------
    >>> import numpy as np
    >>> from symid.axis import load_axis
    >>> from symid.simulation.controller import tuned_cascade
    >>> from symid.simulation.excitation import chirp
    >>> axis, values = load_axis("rigid_1m"), {"M": 5.0, "Fv": 3.0, "Fs": 2.0}
    >>> reference = chirp(0.5, 3.0, 1.0, 0.01, sampling_period=1e-3)
    >>> run = simulate(axis, values, reference, tuned_cascade(plant_of(axis, values), "q"))
    >>> sorted(run.log.signals)
    ['F', 'q', 'reference']
    """
    plant = plant_of(axis, parameters)
    every = _ratio(trajectory.sampling_period, frequency_hz)
    random = np.random.default_rng(seed)
    readers = {sensor.signal: _Reader(sensor, plant, trajectory, random) for sensor in axis.sensors}
    run = _run(plant, trajectory, controller, [readers[s] for s in controller.signals], steps)
    drive = axis.drive
    recorded = run.forces + drive.noise * random.standard_normal(run.forces.size)
    signals = {signal: reader.read_all(run)[::every] for signal, reader in readers.items()}
    signals[drive.signal] = _in_steps(recorded, drive.resolution)[::every]
    signals["reference"] = trajectory.position[::every]
    log = Log.from_arrays(
        signals, sampling_period=every * trajectory.sampling_period, source=f"simulated {axis.name}"
    )
    return Simulation(log, trajectory.time, run.states, run.accelerations, run.forces)


def _ratio(period: float, frequency_hz: float | None) -> int:
    """Controller samples for each recorded one."""
    ratio = 1.0 if frequency_hz is None else 1.0 / (period * frequency_hz)
    if round(ratio) < 1 or not math.isclose(ratio, round(ratio), rel_tol=1e-9):
        raise SettingError(
            f"the controller's rate of {1 / period:g} Hz is no multiple of the recorded {frequency_hz:g} Hz: "
            "choose rates that divide"
        )
    return round(ratio)


def _in_steps(values: FloatArray, step: float) -> FloatArray:
    return np.asarray(step * np.round(values / step)) if step else values


@dataclass(frozen=True, eq=False)
class _Run:
    """States, accelerations (under the last force) and forces at the samples of the controller."""

    states: FloatArray
    accelerations: FloatArray
    forces: FloatArray


class _Reader:
    """A sensor that reads with noise, in steps, and hands out old readings; its delay is rounded to whole samples."""

    def __init__(
        self, sensor: Sensor, plant: Plant, trajectory: Trajectory, random: np.random.Generator
    ) -> None:
        self.signal, self.step = sensor.signal, sensor.resolution
        self.row, self.order = plant.sensors[sensor.signal]
        self.noise = sensor.noise * random.standard_normal(trajectory.n_samples)
        self.age = round(sensor.delay / trajectory.sampling_period)

    def read(self, k: int, run: _Run) -> float:
        """Reading at sample k, for the controller."""
        value = float(
            self._exact(run, slice(max(k - self.age, 0), max(k - self.age, 0) + 1))[0] + self.noise[k]
        )
        return self.step * round(value / self.step) if self.step else value

    def read_all(self, run: _Run) -> FloatArray:
        """Readings at all samples."""
        exact = self._exact(run, slice(None))
        aged = np.concatenate([np.full(self.age, exact[0]), exact[: exact.size - self.age]])
        return _in_steps(aged + self.noise, self.step)

    def _exact(self, run: _Run, samples: slice) -> FloatArray:
        n = self.row.size
        if self.order == 2:
            return np.asarray(run.accelerations[samples] @ self.row)
        return np.asarray(run.states[samples, self.order * n : (self.order + 1) * n] @ self.row)


def _run(
    plant: Plant, trajectory: Trajectory, controller: Controller, read: Sequence[_Reader], steps: int
) -> _Run:
    """Let the controller and the axis run; sample k is read, then the force of sample k acts until the next one."""
    engine, period, n = Engine(plant), trajectory.sampling_period, len(plant.bodies)
    n_samples = trajectory.n_samples
    run = _Run(np.zeros((n_samples, 2 * n)), np.zeros((n_samples, n)), np.zeros(n_samples))
    accelerated = any(order == 2 for _, order in plant.sensors.values())
    memory, force = controller.start, 0.0
    commands = zip(trajectory.position, trajectory.velocity, trajectory.acceleration, strict=True)
    for k, (position, velocity, acceleration) in enumerate(commands):
        run.states[k] = engine.state
        if accelerated:
            run.accelerations[k] = engine.acceleration(force)
        measured = {reader.signal: reader.read(k, run) for reader in read}
        command = Command(k, float(position), float(velocity), float(acceleration))
        force, memory = controller.force(command, measured, memory, period)
        if not abs(force) < _RUNAWAY:
            time = trajectory.time[k]
            raise SettingError(f"the axis runs away at t = {time:g} s: lower the controller's gains")
        run.forces[k] = force
        for _ in range(steps):
            engine.advance(force, period / steps)
    return run
