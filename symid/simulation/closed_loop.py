"""Simulation of an axis under its controller; the result is a log as a drive would record it."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from symid.arrays import FloatArray
from symid.axis import Axis, of_any_axis
from symid.data import Log, require_times_within
from symid.errors import SettingError
from symid.simulation.controllers.controller import Controller
from symid.simulation.drive_chain import ThroughDrive
from symid.simulation.loops.loop import Loop
from symid.simulation.loops.sensor_channel import MotionRecord, SensorChannel, in_steps
from symid.simulation.plants.equilibrium import equilibrium
from symid.simulation.plants.imperfect_plant import PlantStage, misread_code, stages, steps_for
from symid.simulation.plants.plant import Plant
from symid.simulation.stepping import SimulationRun
from symid.simulation.trajectories.trajectory import Trajectory

_PART = 8192
"""Samples between two reports of progress."""


@dataclass(frozen=True, eq=False)
class Simulation:
    """Result of a simulation."""

    log: Log
    """Sensor readings, force and reference, as recorded."""
    time: FloatArray
    """Times of the controller's samples, s; shape (n_samples,)."""
    states: FloatArray
    """Exact displacements and velocities of the bodies; shape (n_samples, 2 n)."""
    accelerations: FloatArray
    """Exact accelerations just before a sample's force acts; zero if the axis has no accelerometer; shape
    (n_samples, n)."""
    forces: FloatArray
    """Drive force that acts from each sample to the next; shape (n_samples,), or (n_samples, n_drives) with several
    drives."""


@of_any_axis
def simulate(
    axis: Axis,
    parameters: Mapping[str, float],
    trajectory: Trajectory | Sequence[Trajectory],
    controller: Controller | Sequence[Controller],
    *,
    frequency_hz: float | None = None,
    seed: int = 0,
    steps: int = 1,
    start: FloatArray | Literal["equilibrium"] | None = None,
    progress: Callable[[Sequence[int]], Iterable[int]] = iter,
) -> Simulation:
    """Simulate an axis along a trajectory; the controllers run at the trajectory's rate.

    Parameters
    ----------
    axis : Axis
        The declared axis.
    parameters : mapping of str to float
        Values of its physical parameters, SI.
    trajectory : Trajectory or sequence of Trajectory
        Reference, one for all drives or one for each; the controllers run at its sampling period.
    controller : Controller or sequence of Controller
        One for each drive; its force is held from one sample to the next.
    frequency_hz : float, optional
        Rate of the recorded log; the controller's rate, the default, must be a multiple of it.
    seed : int
        Seed of the noise that the signals of the axis declare.
    steps : int
        Steps in one controller sample; only nonlinear laws of speed or displacement need more than one.
    start : array of shape (2 n,) or "equilibrium", optional
        Displacements and velocities of the free bodies at the first sample; at rest at zero by default.
        "equilibrium" begins at rest at the first reference, weights held by springs and by the controllers.
    progress : callable, optional
        Receives the indices at which blocks of the simulation begin and yields them, to show progress.

    Returns
    -------
    Simulation
        The force in the log is sent at its sample and held, so on average it acts half a controller sample late.

    Raises
    ------
    SettingError
        If a parameter is missing, there is not one controller and trajectory for each drive, the rates do not divide,
        the start is of another shape, or the axis runs away.

    Examples
    --------
    >>> import numpy as np
    >>> from symid.axis import load_axis
    >>> from symid.simulation import plant_of, tuned_cascade
    >>> from symid.simulation.trajectories.excitation import chirp
    >>> axis, values = load_axis("rigid_1m"), {"M": 5.0, "Fv": 3.0, "Fs": 2.0}
    >>> reference = chirp(0.5, 3.0, 1.0, 0.01, sampling_period=1e-3)
    >>> run = simulate(axis, values, reference, tuned_cascade(plant_of(axis, values), "q"))
    >>> sorted(run.log.signals)
    ['F', 'q', 'reference']
    """
    controllers = (controller,) if isinstance(controller, Controller) else tuple(controller)
    paths = (trajectory,) * len(axis.drives) if isinstance(trajectory, Trajectory) else tuple(trajectory)
    _require_one_for_each_drive(axis, controllers, paths)
    every = _ratio(paths[0].sampling_period, frequency_hz)
    random = np.random.default_rng(seed)
    (first, *later), memories = stages(axis, parameters)
    plant, n_samples, period = first.plant, paths[0].n_samples, paths[0].sampling_period
    delays = {sensor.signal: sensor.delay for sensor in axis.sensors}
    require_times_within("the trajectory", delays, n_samples * period)
    readers = [
        SensorChannel(sensor, plant, n_samples, period, random, misread_code(axis, sensor.signal))
        for sensor in axis.sensors
    ]
    if isinstance(start, str):
        start, controllers = _in_equilibrium(axis, plant, paths, controllers, start)
    # Lags, delays and limits of a drive act between its controller and the plant.
    controllers = tuple(
        ThroughDrive(one, chain, np.zeros(n_samples), period) if chain else one
        for one, chain in zip(controllers, map(axis.imperfections_of, axis.drives), strict=True)
    )
    steps = max(steps, steps_for(axis, plant, parameters, period))
    loop = Loop(plant, paths, controllers, readers, steps, memories)
    record = MotionRecord.empty(n_samples, len(loop.plant.bodies), loop.n_drives, len(loop.between))
    if start is not None:
        state, n = np.asarray(start, dtype=np.float64), len(loop.plant.bodies)
        if state.shape != (2 * n,) or not np.isfinite(state).all():
            raise SettingError(
                f"the simulation starts at {state.tolist()}: give {n} displacements, then {n} velocities"
            )
        record.states[0] = state
    _run(loop, record, later, progress)
    signals = {name: values[::every] for name, values in _recorded(axis, loop, record, random).items()}
    log = Log.from_arrays(signals, sampling_period=every * loop.period, source=f"simulated {axis.name}")
    forces = record.forces[:, 0] if loop.n_drives == 1 else record.forces
    return Simulation(log, paths[0].time, record.states[:-1], record.accelerations[:-1], forces)


def _in_equilibrium(
    axis: Axis, plant: Plant, paths: Sequence[Trajectory], controllers: Sequence[Controller], start: str
) -> tuple[FloatArray, tuple[Controller, ...]]:
    """State at rest at the first references, and the controllers that hold it."""
    if start != "equilibrium":
        raise SettingError(f"start is {start!r}: give 'equilibrium', or displacements and velocities")
    begin = (float(path.position[0]) for path in paths)
    state, forces = equilibrium(plant, dict(zip(axis.controlled_signals, begin, strict=True)))
    return state, tuple(one.holding(float(force)) for one, force in zip(controllers, forces, strict=True))


def _run(
    loop: Loop,
    record: MotionRecord,
    later: list[PlantStage],
    progress: Callable[[Sequence[int]], Iterable[int]],
) -> None:
    """Simulate all samples; `later` has the plants after changes of mass."""
    run, n_samples = SimulationRun(loop, record), len(record.forces)
    for begin in progress(range(0, n_samples, _PART)):
        end = min(begin + _PART, n_samples)
        # A change of mass splits the run: the next plant continues from the state at that moment.
        while later and later[0].begin < end * loop.period:
            changed = later.pop(0)
            run.advance(max(round(changed.begin / loop.period), 1))
            run = SimulationRun(replace(loop, plant=changed.plant), record, run)
        run.advance(end)


def _recorded(
    axis: Axis, loop: Loop, record: MotionRecord, random: np.random.Generator
) -> dict[str, FloatArray]:
    """Readings, commanded forces and references at all samples of the controllers."""
    signals = {reader.signal: reader.read_all(record, loop.between) for reader in loop.readers}
    for i, (drive, one, path) in enumerate(
        zip(axis.drives, loop.controllers, loop.trajectories, strict=True)
    ):
        sent = record.forces[:, i]
        if isinstance(one, ThroughDrive):
            inputs = [path.position, path.velocity, path.acceleration, *(signals[s] for s in one.signals)]
            sent = one.sent_along(np.column_stack(inputs)) if loop.law else one.sent
        sent = sent + drive.noise * random.standard_normal(sent.size)
        signals[drive.signal] = in_steps(sent, drive.resolution)
    for drive, path in zip(axis.drives, loop.trajectories, strict=True):
        if path is loop.trajectories[0]:
            signals["reference"] = path.position
        else:
            signals[f"reference_{drive.signal}"] = path.position
    return signals


def _require_one_for_each_drive(
    axis: Axis, controllers: Sequence[Controller], paths: Sequence[Trajectory]
) -> None:
    for what, given in (("controllers", controllers), ("trajectories", paths)):
        if len(given) != len(axis.drives):
            raise SettingError(
                f"axis {axis.name!r} has {len(axis.drives)} drives and {len(given)} {what}: give one for each drive"
            )
    if len({(path.n_samples, path.sampling_period) for path in paths}) > 1:
        raise SettingError("the trajectories differ in length or sampling period: give all drives the same")


def _ratio(period: float, frequency_hz: float | None) -> int:
    """Controller samples for each recorded sample."""
    ratio = 1.0 if frequency_hz is None else 1.0 / (period * frequency_hz)
    if round(ratio) < 1 or not math.isclose(ratio, round(ratio), rel_tol=1e-9):
        raise SettingError(
            f"the controller's rate of {1 / period:g} Hz is not a multiple of the recorded {frequency_hz:g} Hz: "
            "choose rates that divide"
        )
    return round(ratio)
