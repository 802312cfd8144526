"""Simulation of an experiment with either cause, under a controller and with the noise of the machine.

The axis with each cause is simulated with noise, which determines the weights, and without. Both causes are fitted to
the noiseless readings, so that deficiencies of the models count as well. The logarithm of their likelihood ratio is
Gaussian: its mean is the gain of the true cause, its standard deviation the distance of both predictions in standard
deviations of the noise. If the model of the true cause is exact, the mean is half the square of that distance.
"""

import math
from dataclasses import replace

import numpy as np
import scipy

from symid.axis import Axis
from symid.diagnosis.experiment.discrimination import Rivals, drive_ratios, separation
from symid.diagnosis.findings.planned_experiment import SimulatedExperiment
from symid.diagnosis.fitting.state import State
from symid.diagnosis.in_motion.declared import axis_with_effects
from symid.diagnosis.in_motion.replayed import Part, driver_of
from symid.diagnosis.prediction.record import Record, record_of
from symid.errors import SettingError
from symid.simulation import (
    Cascade,
    Extremes,
    Simulation,
    Trajectory,
    plant_of,
    simulate,
    tuned_cascades,
    without_noise,
)

_LEAST_RATE = 1000.0  # lowest rate of the simulated controller, Hz


def simulated_experiment(rivals: Rivals, trajectory: Trajectory, seed: int = 0) -> SimulatedExperiment:
    """Simulate an experiment with either cause; SettingError if a cause cannot be simulated."""
    runs = [_run(rivals, model, trajectory, seed) for model in rivals.models]
    quiet = [_run(rivals, model, trajectory, None)[0] for model in rivals.models]
    records = tuple(record for record, _ in runs)
    demands = [_demand(record, run, trajectory) for record, run in runs]
    return SimulatedExperiment(
        separations=tuple(
            separation(rivals, i, *pair) for i, pair in enumerate(zip(records, quiet, strict=True))
        ),
        demand=Extremes(
            lowest=min(d.lowest for d in demands),
            highest=max(d.highest for d in demands),
            speed=max(d.speed for d in demands),
            acceleration=max(d.acceleration for d in demands),
            jerk=trajectory.extremes.jerk,
        ),
        forces={
            name: max(float(np.abs(run.log[name]).max()) for _, run in runs) for name in rivals.record.forces
        },
        records=records,
    )


def _run(rivals: Rivals, model: State, trajectory: Trajectory, seed: int | None) -> tuple[Record, Simulation]:
    """Readings and motion of the axis of a model; without a seed, readings are noiseless."""
    like, explained = rivals.record, axis_with_effects(model)
    if explained.left_out:
        raise SettingError("; ".join(explained.left_out))
    axis = without_noise(explained.axis) if seed is None else _with_noise(explained.axis, like)
    plant = plant_of(axis, explained.values)
    paths = [share.of(_fast(trajectory)) for share in drive_ratios(like)]
    tuned = tuned_cascades(plant, like.driven, min(20.0, like.log.sampling_frequency / 20))
    run = simulate(
        axis,
        explained.values,
        paths,
        [_controller(rivals, i, cascade) for i, cascade in enumerate(tuned)],
        frequency_hz=like.log.sampling_frequency,
        seed=seed or 0,
        start=plant.follows(
            {name: (float(path.position[0]), 0.0) for name, path in zip(like.driven, paths, strict=True)}
        ),
    )
    # The simulated controller holds its force from sample to sample.
    holds = dict.fromkeys(like.forces, paths[0].sampling_period)
    # The axis may declare sensors that the log lacks.
    seen = {name: run.log[name] for name in (*like.driven, *like.outputs)}
    log = replace(run.log, signals=seen, source=trajectory.name)
    return record_of(like.dynamics, log, like.motion_hz, holds=holds), run


def _controller(rivals: Rivals, drive: int, tuned: Cascade) -> Cascade:
    """The controller of a drive, estimated from the log if possible, else the given one."""
    record = rivals.record
    parts = [Part(record.log, np.ones(record.log.n_samples, dtype=bool), record, drive)]
    driver = driver_of(record, parts, None, rivals.step.before.state.inertia)
    return tuned if driver.kind == "observer" else driver.cascade


def _with_noise(axis: Axis, like: Record) -> Axis:
    """The axis with the noise of a log in its signals."""
    delays = {sensor.signal: sensor.delay for sensor in axis.sensors}
    for name, level in zip((*like.driven, *like.outputs), like.noise, strict=True):
        axis = axis.with_signal(name, float(level), delay=delays.get(name, 0.0))
    return axis


def _fast(trajectory: Trajectory) -> Trajectory:
    """A trajectory resampled to a rate sufficient for a controller."""
    factor = max(1, math.ceil(_LEAST_RATE * trajectory.sampling_period - 1e-9))
    if factor == 1:
        return trajectory
    n = trajectory.n_samples
    spline = scipy.interpolate.CubicSpline(np.arange(n) * trajectory.sampling_period, trajectory.position)
    period = trajectory.sampling_period / factor
    time = np.arange((n - 1) * factor + 1) * period
    position, velocity, acceleration = (spline(time, order) for order in range(3))
    return Trajectory(position, velocity, acceleration, period, trajectory.name)


def _demand(record: Record, run: Simulation, trajectory: Trajectory) -> Extremes:
    """Extremes of the driven joints, in terms of the first one."""
    plant = plant_of(record.dynamics.axis, dict.fromkeys(record.dynamics.parameters, 1.0))
    period, moved = float(run.time[1] - run.time[0]), []
    for name, share in zip(record.driven, drive_ratios(record), strict=True):
        row, n = plant.sensors[name].row, len(plant.bodies)
        if share.factor:
            position, speed = (run.states[:, part] @ row for part in (slice(n), slice(n, None)))
            moved.append(((position - share.offset) / share.factor, speed / share.factor))
    return Extremes(
        lowest=min(float(position.min()) for position, _ in moved),
        highest=max(float(position.max()) for position, _ in moved),
        speed=max(float(np.abs(speed).max()) for _, speed in moved),
        # A quantile leaves out the few samples in which friction jumps, as `limits_seen` does for a log.
        acceleration=max(float(np.quantile(np.abs(np.diff(speed) / period), 0.995)) for _, speed in moved),
        jerk=trajectory.extremes.jerk,
    )
