"""One-step prediction of the readings: the innovations form of a sampled axis.

Each force of the log is the true one plus white noise, and every reading has independent white noise. For each reading
beyond those of the drives there is an unknown white force along its direction, so that unmodelled forces are not put
on the sensors. The stationary Kalman gain turns the recursion of the axis into that of its innovations
e[k] = y[k] - y^[k | k-1], which are white if the model is right.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from symid.arrays import FloatArray
from symid.output_error.sampled_plant import SampledPlant


@dataclass(frozen=True, eq=False)
class StateSpace:
    """x[k+1] = A x[k] + B u[k], y[k] = C x[k] + D u[k]."""

    A: FloatArray
    B: FloatArray
    C: FloatArray
    D: FloatArray

    def free_response(self, n_samples: int, forgotten: float = 0.0) -> FloatArray:
        """Outputs from each unit initial state, of shape (n_samples, p, n); shorter if it falls to `forgotten` before.

        >>> system = StateSpace(np.array([[0.5]]), np.ones((1, 1)), np.ones((1, 1)), np.zeros((1, 1)))
        >>> system.free_response(4).ravel().tolist()
        [1.0, 0.5, 0.25, 0.125]
        """
        outputs, power = self.C, self.A  # the outputs of all samples, one below the other: one product each
        while len(outputs) < n_samples * len(self.C):
            following = outputs @ power
            if np.abs(following).max() <= forgotten * np.abs(outputs).max():
                break
            outputs, power = np.concatenate([outputs, following]), power @ power
        return outputs.reshape(-1, *self.C.shape)[:n_samples]

    def observed(self, C: FloatArray) -> StateSpace:
        """The recursion with other outputs, without direct feedthrough."""
        return StateSpace(self.A, self.B, C, np.zeros((len(C), self.B.shape[1])))

    def response(self, inputs: FloatArray, starts: Sequence[int]) -> FloatArray:
        """Outputs for inputs, one signal a column, from a zero state at each start: ascending, the first of them 0.

        >>> system = StateSpace(np.array([[0.5]]), np.ones((1, 1)), np.ones((1, 1)), np.zeros((1, 1)))
        >>> system.response(np.array([[1.0], [0.0], [0.0], [1.0]]), [0, 2]).ravel().tolist()
        [0.0, 1.0, 0.0, 0.0]
        """
        from symid.simulation.compiled_loop import recursion  # numba takes 0.3 s to import

        A, gained, outputs = np.ascontiguousarray(self.A), inputs @ self.B.T, inputs @ self.D.T
        for start, stop in pairwise([*starts, len(inputs)]):
            outputs[start:stop] += recursion(A, np.zeros(len(A)), gained[start:stop])[:-1] @ self.C.T
        return np.asarray(outputs)


@dataclass(frozen=True, eq=False)
class Predictor:
    """Innovations of a sampled axis."""

    # its inputs are the readings without what forces add to them directly, and the effects of the forces on the
    # state; its outputs the innovations
    innovations: StateSpace
    covariance: FloatArray  # shape (n_outputs, n_outputs): of the innovations, for the noise that was assumed


def predictor(plant: SampledPlant, force_noise: FloatArray, reading_noise: FloatArray) -> Predictor:
    """Stationary Kalman predictor; LinAlgError if none is found.

    `force_noise` holds the standard deviations of the noise of the logged forces, then of the disturbances;
    `reading_noise` those of the readings.

    >>> from symid.axis import load_axis
    >>> from symid.output_error.sampled_plant import sampled_plant
    >>> from symid.simulation import plant_of
    >>> plant = plant_of(load_axis("rigid_1m"), {"M": 1.0, "Fv": 0.0, "Fs": 0.0})
    >>> found = predictor(sampled_plant(plant, ["q"], 1.0, parts=1), np.ones(1), np.ones(1))
    >>> np.abs(np.linalg.eigvals(found.innovations.A)).round(3).tolist()
    [0.5, 0.5]
    """
    scale = _state_scale(plant)
    A = plant.transition * scale / scale[:, None]
    C = plant.output * scale / reading_noise[:, None]
    noise = plant.noise_effects * force_noise / scale[:, None]
    direct = plant.noise_feedthrough * force_noise / reading_noise[:, None]
    measurement = np.eye(len(C)) + direct @ direct.T
    cross = noise @ direct.T
    process = noise @ noise.T
    process += 1e-12 * np.trace(process) * np.eye(len(process))
    P = _stationary_covariance(A, C, process, measurement, cross)
    covariance = C @ P @ C.T + measurement
    gain = np.linalg.solve(covariance, (A @ P @ C.T + cross).T).T * scale[:, None] / reading_noise
    n, p = len(A), len(C)
    innovations = StateSpace(
        A=plant.transition - gain @ plant.output,
        B=np.hstack([gain, np.eye(n)]),
        C=-plant.output,
        D=np.hstack([np.eye(p), np.zeros((p, n))]),
    )
    return Predictor(innovations, covariance * np.outer(reading_noise, reading_noise))


def _state_scale(plant: SampledPlant) -> FloatArray:
    """Scale of each state for a well-conditioned equation: the effect of a force over a few samples."""
    effects = [plant.noise_effects[:, : plant.n_drives]]
    for _ in range(8):
        effects.append(plant.transition @ effects[-1])
    reach = np.abs(np.hstack(effects)).max(axis=1)
    return np.asarray(np.where(reach > 0, reach, reach.max()))


def _stationary_covariance(
    A: FloatArray, C: FloatArray, process: FloatArray, measurement: FloatArray, cross: FloatArray
) -> FloatArray:
    """Covariance of the predicted state."""
    from symid.output_error.compiled_algebra import doubled  # numba takes 0.3 s to import

    n = len(A)
    weighted = np.linalg.solve(measurement, np.hstack([C, cross.T]))
    covariance = process - cross @ weighted[:, n:]
    transition = np.ascontiguousarray((A - cross @ weighted[:, :n]).T)
    solution = doubled(transition, C.T @ weighted[:, :n], covariance)
    if not solution or not np.isfinite(covariance).all():
        raise np.linalg.LinAlgError("no stationary predictor is found")
    return covariance
