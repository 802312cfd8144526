"""Logs of the paper's axis under a loop at its own rate, with noise in the axis or in the record."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from scipy import signal

import symid
from benchmarks.cramer_rao import FloatArray, responses
from symid.axis import Axis
from symid.simulation import Cascade, Command, Trajectory, plant_of, simulate, trapezoids, tuned_cascade

PAPER = {"Ms": 3899.0, "Fvs": 3949.17, "Ks": 1e9, "Mm": 362.58, "Fvm": 88.6, "Fsm": 146.0}
SMOOTH = PAPER | {"Fsm": 0.0}
QUIET, LOUD = (1.0, 20e-9), (5.0, 100e-9)
"""Noise of the logged force, N, and of the encoder, m: a drive's current loop and a linear scale; five times that."""


def direct() -> Axis:
    return symid.load_axis("direct_2m1s")


def without_friction() -> Axis:
    """The paper's axis without Coulomb friction, as in the paper's own simulations."""
    axis = direct()
    return axis.without(*(e for e in axis.elements if isinstance(e, symid.CoulombFriction)))


def moves(rate: float, jerk: float = 2000.0) -> Trajectory:
    """Trapezoids there and back at three speeds."""
    return trapezoids(
        [0.3], [0.1, 0.25, 0.5], acceleration=10.0, jerk=jerk, dwell=0.2, sampling_period=1 / rate
    )


def machine(truth: Mapping[str, float], rate: float, jerk: float = 2000.0) -> symid.Log:
    """Trapezoids of the paper's axis under a cascade at a rate, without noise."""
    controller = tuned_cascade(plant_of(direct(), truth), "q2", bandwidth_hz=6.0)
    return simulate(direct(), truth, moves(rate, jerk), controller).log


@dataclass(frozen=True)
class Disturbed(Cascade):
    """A cascade whose force acts with a disturbance that the log does not hold."""

    disturbance: FloatArray = field(default_factory=lambda: np.zeros(1))

    def force(
        self, command: Command, measured: Mapping[str, float], state: FloatArray, period: float
    ) -> tuple[float, FloatArray]:
        sent, state = super().force(command, measured, state, period)
        return sent + float(self.disturbance[command.index]), state


def disturbed(truth: Mapping[str, float], noise: tuple[float, float], seed: int) -> symid.Log:
    """A log at 250 Hz of a loop that feeds back encoder noise, its force differing from the sent one by white noise."""
    reference = moves(250.0)
    added = noise[0] * np.random.default_rng(seed).standard_normal(reference.n_samples)
    axis = direct().with_signal("q2", noise=noise[1])
    gains = tuned_cascade(plant_of(axis, truth), "q2", bandwidth_hz=6.0)
    controller = Disturbed(**vars(gains), disturbance=added)
    run = simulate(axis, truth, reference, controller, seed=seed)
    signals = {"q2": run.log["q2"], "Fm": run.forces - added}
    return symid.Log.from_arrays(signals, sampling_period=1 / 250.0)


def recorded_with_noise(log: symid.Log, noise: tuple[float, float], seed: int) -> symid.Log:
    """The log with white noise on the records of force and encoder: the axis does not feel it."""
    random = np.random.default_rng(seed)
    signals = {
        name: log[name] + std * random.standard_normal(log.n_samples)
        for name, std in zip(("Fm", "q2"), noise, strict=True)
    }
    return symid.Log.from_arrays(signals, sampling_period=log.sampling_period)


def noisy(log: symid.Log, noise: tuple[float, float], seed: int) -> symid.Log:
    """The log of the same force when white noise adds to it in the axis (without friction) and to the encoder."""
    random = np.random.default_rng(seed)
    impulse, _ = responses(SMOOTH, log.n_samples, log.sampling_period)
    moved = signal.lfilter(
        np.append(0.0, impulse[:-1]), 1.0, noise[0] * random.standard_normal(log.n_samples)
    )
    q2 = log["q2"] + moved + noise[1] * random.standard_normal(log.n_samples)
    return symid.Log.from_arrays({"q2": q2, "Fm": log["Fm"]}, sampling_period=log.sampling_period)
