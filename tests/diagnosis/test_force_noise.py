"""Noise of recorded forces: neither the weight that a drive holds nor what its controller does is noise."""

import numpy as np
import pytest

from symid import Log, load_axis
from symid.diagnosis.prediction.record import record_of
from symid.simulation import Cascade, forward_dynamics, simulate, trapezoids


def test_a_weight_that_the_drive_holds_makes_no_noise() -> None:
    """A hoist holds 700 N: a noise of 0.02 N was taken for none, and 0.7 N in its place hid a gap of 0.29 N."""
    t = np.arange(20_000) / 1000
    q, F = 0.05 * np.sin(7 * t) + 0.002 * np.sin(40 * t), 30 * np.cos(11 * t)
    random = np.random.default_rng(5)
    noise = 0.02 * random.standard_normal(t.size)
    for weight in (0.0, 700.0):
        signals = {"q": q + 1e-8 * random.standard_normal(t.size), "F": weight + F + noise}
        log = Log("by hand", 0.0, 1e-3, signals)
        assert record_of(forward_dynamics(load_axis("rigid_1m")), log, 40.0).noise[1] == pytest.approx(
            0.02, rel=0.2
        )


def test_what_a_controller_makes_of_the_noise_of_an_encoder_is_no_noise_of_the_force() -> None:
    axis = load_axis("rigid_1m").with_signal("q", noise=2e-5).with_signal("F", noise=0.3)
    values = {"M": 20.0, "Fv": 15.0, "Fs": 20.0}
    path = trapezoids([0.3], [0.2, 0.5], acceleration=4.0, jerk=100.0, dwell=0.1, sampling_period=1e-3)
    loop = Cascade("q", position_gain=30.0, velocity_gain=2000.0, integral_gain=4.0)
    log = simulate(axis, values, path, loop, seed=3).log
    assert np.diff(log["F"]).std() > 30.0  # a hundred times the noise that the recorder adds
    position, force = record_of(forward_dynamics(axis), log).noise
    assert position == pytest.approx(2e-5, rel=0.2)
    assert force == pytest.approx(0.3, rel=0.4)
