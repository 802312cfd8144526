"""The axis between two samples, without approximation: linear motion under forces of a known course.

Each sampling interval is cut into a few parts in which the drive force and the forces of the nonlinear laws are
constant; their effect on the state at its end is exact (matrix exponential):

    x[k+1] = A x[k] + sum_i A_i G f[k, i],    y[k] = C x[k] + D f0[k]

x are displacements and velocities, f the forces (drives, laws by joint, constant) in part i of the interval after
sample k, and f0 their values at the sample, which accelerometers and force sensors see.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from symid.arrays import FloatArray
from symid.simulation import Plant

_UNFELT = 1e-9
"""Part of a displacement in readings and springs below which nothing depends on it."""


@dataclass(frozen=True, eq=False)
class SampledPlant:
    """Matrices of the exact recursion from sample to sample, as in the module's docstring."""

    transition: FloatArray  # shape (n_states, n_states): A
    # shape (n_parts, n_states, n_forces): A_i G; forces are those of the drives, those of the joints' laws, the
    # constant ones
    effects: FloatArray
    # shape (n_states, n_disturbed): effect of a force along the direction of each disturbed sensor, over a whole
    # interval
    disturbances: FloatArray
    output: FloatArray  # shape (n_outputs, n_states): C
    feedthrough: FloatArray  # shape (n_outputs, n_forces): D
    disturbance_feedthrough: FloatArray  # shape (n_outputs, n_disturbed): the same for the disturbances
    read_forces: (
        FloatArray  # shape (n_outputs, n_drives): the part of D by which sensors read the forces themselves
    )
    n_drives: int  # number of drives
    # shape (2 n_bodies, n_states): displacements and velocities by the states; unobservable ones are removed
    basis: FloatArray

    @cached_property
    def noise_effects(self) -> FloatArray:
        """Effects over an interval of the noise of each drive's logged force and of each disturbance.

        The logged force holds its noise, the true one does not: hence the sign. Of shape (n_states, n_sources).
        """
        return np.column_stack([-self.effects[:, :, : self.n_drives].sum(axis=0), self.disturbances])

    @cached_property
    def noise_feedthrough(self) -> FloatArray:
        """Direct feedthrough of these noises to the readings, of shape (n_outputs, n_sources)."""
        return np.column_stack([-self.feedthrough[:, : self.n_drives], self.disturbance_feedthrough])


def sampled_plant(
    plant: Plant, signals: Sequence[str], period: float, parts: int, disturbed: Sequence[str] = ()
) -> SampledPlant:
    """Exact recursion of a plant from sample to sample, a period, s, later; signals are the rows of its output.

    Forces are constant in each of the parts of an interval; a disturbing force acts along each disturbed sensor.

    >>> from symid.axis import load_axis
    >>> from symid.simulation import plant_of
    >>> plant = plant_of(load_axis("rigid_1m"), {"M": 2.0, "Fv": 0.0, "Fs": 1.0})
    >>> sampled_plant(plant, ["q"], 0.1, parts=2).effects[:, :, 0].sum(axis=0).round(6).tolist()
    [0.0025, 0.05]
    """
    generator, forces = _continuous(plant, [plant.sensors[signal][0] for signal in disturbed])
    n, m = forces.shape
    known = m - len(disturbed)
    whole = np.zeros((n + m, n + m))
    whole[:n] = np.hstack([generator, forces]) * (period / parts)
    exponential = scipy.linalg.expm(whole)
    step, last = exponential[:n, :n], exponential[:n, n:]
    effects = [last]
    for _ in range(parts - 1):
        effects.append(step @ effects[-1])
    rows, feedthrough = _outputs(plant, signals, generator, forces)
    basis = _observed(plant, signals)
    stacked = basis.T @ np.stack(effects[::-1])
    return SampledPlant(
        transition=basis.T @ np.linalg.matrix_power(step, parts) @ basis,
        effects=stacked[:, :, :known],
        disturbances=stacked[:, :, known:].sum(axis=0),
        output=rows @ basis,
        feedthrough=feedthrough[:, :known],
        disturbance_feedthrough=feedthrough[:, known:],
        read_forces=np.array([plant.sensors[signal].drives for signal in signals]),
        n_drives=plant.drives.shape[1],
        basis=basis,
    )


def _observed(plant: Plant, signals: Sequence[str]) -> FloatArray:
    """Basis of the states without displacements that neither a spring nor a reading depends on.

    Such are the place of a free axis of which only a speed is read, and that of a free base under a relative sensor.

    >>> from symid import Axis, Body, Drive, Position, Velocity
    >>> from symid.simulation import plant_of
    >>> body = Body("table", mass="M")
    >>> axis = Axis("table", (body,), Drive("F", body), (Position("q", body), Velocity("v", body)))
    >>> [_observed(plant_of(axis, {"M": 2.0}), [signal]).shape for signal in ("q", "v")]
    [(2, 2), (2, 1)]
    """
    n = len(plant.bodies)
    rows = np.stack([*plant.stiffness, *(plant.sensors[signal].motion[0] for signal in signals)])
    sizes = np.linalg.norm(rows, axis=1, keepdims=True)
    rows = rows / np.where(sizes > 0.0, sizes, 1.0)
    _, lengths, directions = np.linalg.svd(rows)
    felt = int(np.sum(lengths > _UNFELT * lengths[0]))
    return np.eye(2 * n) if felt == n else scipy.linalg.block_diag(directions[:felt].T, np.eye(n))


def _continuous(plant: Plant, disturbed: Sequence[FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Generator of the state, and effects on it of drives, laws (opposing), constant forces and given directions."""
    n = len(plant.bodies)
    inverse = np.linalg.inv(plant.mass)
    generator = np.zeros((2 * n, 2 * n))
    generator[:n, n:] = np.eye(n)
    generator[n:, :n] = -inverse @ plant.stiffness
    generator[n:, n:] = -inverse @ plant.damping
    columns = [*plant.drives.T, *(-law.direction for law in plant.laws), plant.constant, *disturbed]
    forces = np.zeros((2 * n, len(columns)))
    forces[n:] = inverse @ np.stack(columns, axis=1)
    return generator, forces


def _outputs(
    plant: Plant, signals: Sequence[str], generator: FloatArray, forces: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Readings as functions of the state, and of the forces, which accelerations and force sensors see."""
    n = len(plant.bodies)
    rows, feedthrough = np.zeros((len(signals), 2 * n)), np.zeros((len(signals), forces.shape[1]))
    for i, signal in enumerate(signals):
        reading = plant.sensors[signal]
        rows[i] = reading.motion[:2].ravel() + reading.motion[2] @ generator[n:]
        feedthrough[i] = reading.motion[2] @ forces[n:]
        feedthrough[i, : reading.drives.size] += reading.drives
        feedthrough[i, reading.drives.size + len(plant.laws)] += reading.constant
        if reading.law is not None:
            feedthrough[i, reading.drives.size + reading.law] += reading.per_force
    return rows, feedthrough
