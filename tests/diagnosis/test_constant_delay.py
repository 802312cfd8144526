"""A delay of the force is one of the recording only if other data of the machine have it too."""

import math

import numpy as np

from symid import Axis, Body, CoulombFriction, Drive, Log, PendulumWeight, Position, ViscousFriction
from symid.diagnosis import diagnose

J, LOAD, FV, FC, WEIGHT = 3.3, 2.2, 9.0, 12.0, 38.0
ERROR, WAVES = 2e-4, 200.0
"""Error of the gear, rad, and its waves in a turn: the load accelerates and brakes with them."""
PERIOD, STEPS = 1e-3, 5


def followed(reference: np.ndarray, rng: np.random.Generator) -> Log:
    """A robot's joint with an error of its gear under a cascade, by a semi-implicit scheme of its own."""
    q, v, z, integral = float(reference[0]), 0.0, 0.0, WEIGHT * math.sin(reference[0])
    read, torque, h = np.empty(reference.size), np.empty(reference.size), PERIOD / STEPS
    speeds = np.gradient(reference, PERIOD)
    for k in range(reference.size):
        error = 25.0 * (reference[k] - q) + speeds[k] - v
        integral += 1500.0 * error * PERIOD
        T = 180.0 * error + integral
        read[k], torque[k] = q, T
        for _ in range(STEPS):
            rate = 6e4 * abs(v) / FC  # Dahl
            z = (z + h * v) / (1.0 + h * rate)
            wave = LOAD * ERROR * WAVES
            rest = T - 6e4 * z - FV * v - WEIGHT * math.sin(q) + wave * WAVES * math.sin(WAVES * q) * v * v
            v += h * rest / (J + wave * math.cos(WAVES * q))
            q += h * v
    noise = rng.standard_normal((2, reference.size))
    return Log.from_arrays(
        {"q": read + 5e-6 * noise[0], "T": torque + 0.05 * noise[1]}, sampling_period=PERIOD
    )


def test_a_delay_that_differs_between_logs_which_it_does_not_explain_is_none() -> None:
    rng = np.random.default_rng(1)
    t = PERIOD * np.arange(12_000)
    waves = ((0.35, 0.12, 0.3), (0.2, 0.24, 1.0), (0.1, 0.36, 2.0), (0.06, 0.48, 4.0))
    slow = 0.4 + sum(a * np.sin(2 * np.pi * f * t + p) for a, f, p in waves)
    there = np.concatenate(
        [np.full(round(0.6 / s / PERIOD), s * way) for s in (0.2, 0.4, 0.8) for way in (1, -1)]
    )
    smooth = np.hanning(121)
    speeds = np.convolve(np.pad(there, 60, mode="edge"), smooth / smooth.sum(), mode="valid")
    passes = 0.3 + np.cumsum(speeds) * PERIOD
    body = Body("joint", inertia="J")
    laws = (ViscousFriction(body, "Fv"), CoulombFriction(body, "Fc"), PendulumWeight(body, "ml"))
    axis = Axis("joint", (body, *laws), Drive("T", body), (Position("q", body),))
    found = diagnose(axis, followed(slow, rng), validation=followed(passes, rng), held=False)
    assert not {e.effect for e in found.effects} & {"delay", "actuator_lag"}
