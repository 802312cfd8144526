"""Force that a controller makes of the encoder's noise is no fault of the recording."""

import numpy as np
import pytest

from symid import Axis, Body, CoulombFriction, Drive, Log, Position, ViscousFriction, derive
from symid.identification import identify_by_least_squares

M, FV, FS = 40.0, 120.0, 30.0
PERIOD = 5e-4


def slow_log(seed: int) -> Log:
    """A mass with friction that follows a slow sine, held by a cascade that reads a noisy encoder."""
    rng = np.random.default_rng(seed)
    t = PERIOD * np.arange(20_000)
    w = 2 * np.pi * 0.15
    reference, speed = 0.1 * np.sin(w * t), 0.1 * w * np.cos(w * t)
    noise = 2e-7 * rng.standard_normal(t.size)
    decay = np.exp(-FV * PERIOD / M)
    read, force = np.zeros(t.size), np.zeros(t.size)
    q, v, mean, last, integral = 0.0, float(speed[0]), float(speed[0]), float(noise[0]), FS
    for k in range(t.size):
        read[k] = q + noise[k]
        mean += 0.3 * ((read[k] - last) / PERIOD - mean) if k else 0.0
        last = read[k]
        error = 60.0 * (reference[k] - read[k]) + speed[k] - mean
        force[k] = M * 180.0 * error + integral
        integral += M * 180.0 * 45.0 * error * PERIOD
        # exact for a held force, and friction that keeps its direction within a sample
        goal = (force[k] - FS * np.sign(v)) / FV
        q += goal * PERIOD + (v - goal) * (1.0 - decay) * M / FV
        v = goal + (v - goal) * decay
    force += 0.02 * rng.standard_normal(t.size)
    return Log.from_arrays({"q": read, "F": force}, sampling_period=PERIOD)


@pytest.mark.parametrize("seed", [0, 2])  # it was called a high-pass of 0.005 Hz
def test_a_slow_motion_in_closed_loop_is_ok(seed: int) -> None:
    body = Body("body", mass="M")
    laws = (ViscousFriction(body, "Fv"), CoulombFriction(body, "Fs"))
    axis = Axis("slow", (body, *laws), Drive("F", body, held=True), (Position("q", body),))
    found = identify_by_least_squares(derive(axis, ("q",)), slow_log(seed))
    assert found.status == "ok", found.message
    error = np.abs(np.array(list(found.physical_parameters.values())) - [M, FV, FS])
    assert np.all(error < 3 * found.physical_deviations)
    assert np.all(found.physical_deviations < 0.03 * np.array([M, FV, FS]))  # no effect is seen in the noise
