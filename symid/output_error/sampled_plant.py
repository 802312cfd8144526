"""The axis between two samples, without approximation: linear motion under forces of a known course.

Each sampling interval is cut into a few parts in which the drive force and the forces of the nonlinear laws are
constant; their effect on the state at its end is exact (matrix exponential):

    x[k+1] = A x[k] + sum_i A_i G f[k, i],    y[k] = C x[k] + D f0[k]

x are displacements and velocities, f the forces (drive, laws by joint, constant) in part i of the interval after
sample k, and f0 their values at the sample, which only accelerometers see.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from symid.arrays import FloatArray
from symid.simulation import Plant


@dataclass(frozen=True, eq=False)
class SampledPlant:
    """Matrices of the recursion; see the module.

    Parameters
    ----------
    transition : array of shape (n_states, n_states)
        A.
    effects : array of shape (n_parts, n_states, n_forces)
        A_i G; forces are that of the drive, those of the joints' laws, the constant ones.
    disturbances : array of shape (n_states, n_outputs - 1)
        Effect of a force along the direction of each sensor but the first, over a whole interval.
    output : array of shape (n_outputs, n_states)
        C.
    feedthrough : array of shape (n_outputs, n_forces)
        D.
    disturbance_feedthrough : array of shape (n_outputs, n_outputs - 1)
        The same for the disturbances.
    """

    transition: FloatArray
    effects: FloatArray
    disturbances: FloatArray
    output: FloatArray
    feedthrough: FloatArray
    disturbance_feedthrough: FloatArray

    @property
    def force_effect(self) -> FloatArray:
        """Effect of a unit drive force that acts over the whole interval, shape (n_states,)."""
        return np.asarray(self.effects[:, :, 0].sum(axis=0))


def sampled_plant(plant: Plant, signals: Sequence[str], period: float, parts: int) -> SampledPlant:
    """Exact recursion of a plant from sample to sample.

    Parameters
    ----------
    plant : Plant
        The axis at parameter values.
    signals : sequence of str
        Sensors, the rows of the output.
    period : float
        Sampling period, s.
    parts : int
        Parts of an interval in which forces are constant.

    Examples
    --------
    >>> from symid.axis import load_axis
    >>> from symid.simulation import plant_of
    >>> plant = plant_of(load_axis("rigid_1m"), {"M": 2.0, "Fv": 0.0, "Fs": 1.0})
    >>> sampled_plant(plant, ["q"], 0.1, parts=2).force_effect.round(6).tolist()
    [0.0025, 0.05]
    """
    generator, forces = _continuous(plant, [plant.sensors[signal][0] for signal in signals[1:]])
    n, m = forces.shape
    known = m - len(signals) + 1
    whole = np.zeros((n + m, n + m))
    whole[:n] = np.hstack([generator, forces]) * (period / parts)
    exponential = scipy.linalg.expm(whole)
    step, last = exponential[:n, :n], exponential[:n, n:]
    effects = [last]
    for _ in range(parts - 1):
        effects.append(step @ effects[-1])
    rows, feedthrough = _outputs(plant, signals, generator, forces)
    stacked = np.stack(effects[::-1])
    return SampledPlant(
        transition=np.linalg.matrix_power(step, parts),
        effects=stacked[:, :, :known],
        disturbances=stacked[:, :, known:].sum(axis=0),
        output=rows,
        feedthrough=feedthrough[:, :known],
        disturbance_feedthrough=feedthrough[:, known:],
    )


def _continuous(plant: Plant, disturbed: Sequence[FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Generator of the state, and effects on it of drive, laws (opposing), constant forces and given directions."""
    n = len(plant.bodies)
    inverse = np.linalg.inv(plant.mass)
    generator = np.zeros((2 * n, 2 * n))
    generator[:n, n:] = np.eye(n)
    generator[n:, :n] = -inverse @ plant.stiffness
    generator[n:, n:] = -inverse @ plant.damping
    columns = [plant.drive, *(-law.direction for law in plant.laws), plant.constant, *disturbed]
    forces = np.zeros((2 * n, len(columns)))
    forces[n:] = inverse @ np.stack(columns, axis=1)
    return generator, forces


def _outputs(
    plant: Plant, signals: Sequence[str], generator: FloatArray, forces: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Readings as functions of the state, and of the forces, which only accelerations see."""
    n = len(plant.bodies)
    rows, feedthrough = np.zeros((len(signals), 2 * n)), np.zeros((len(signals), forces.shape[1]))
    for i, signal in enumerate(signals):
        row, order = plant.sensors[signal]
        if order == 2:
            rows[i] = row @ generator[n:]
            feedthrough[i] = row @ forces[n:]
        else:
            rows[i, order * n : (order + 1) * n] = row
    return rows, feedthrough
