"""Friction that changes with the speed, where the model has Coulomb friction, and readings that jump for a sample."""

import numpy as np
import pytest

from symid import Log, identify, load_generated


def run(stribeck: float = 0.0, spikes: tuple[int, ...] = ()) -> Log:
    """A mass of 5 kg that moves with two sines, 4 N s/m and 6 N of friction, more of it below 1 m/s."""
    t, rng = np.arange(8000) / 1000, np.random.default_rng(0)
    w, size = np.array([[3.0], [17.0]]), np.array([[1.0], [0.1]])
    q, v = np.sum(size * np.sin(w * t), axis=0), np.sum(size * w * np.cos(w * t), axis=0)
    F = 5 * np.sum(-size * w**2 * np.sin(w * t), axis=0) + 4 * v
    F += (6 + stribeck * np.exp(-np.abs(v))) * np.sign(v) + 0.02 * rng.standard_normal(t.size)
    q = q + 1e-7 * rng.standard_normal(t.size)
    q[list(spikes)] += 0.3
    return Log.from_arrays({"q": q, "F": F}, sampling_period=1e-3)


@pytest.mark.parametrize("share", [0.0, 0.3, -0.3])
def test_friction_of_another_course_over_the_speed_is_named(share: float) -> None:
    found = identify(load_generated("rigid_1m"), run(stribeck=6 * share))
    assert ("more of it at low speed" in found.message) == (share > 0)
    assert ("less of it at low speed" in found.message) == (share < 0)
    assert (found.status == "ok") == (share == 0)


def test_a_reading_that_jumps_for_a_sample_is_named() -> None:
    found = identify(load_generated("rigid_1m"), run(spikes=(2000, 5000)))
    assert "q jumps by 0.301 and back within a sample at t = 2 s" in found.message
    assert found.status != "ok"
