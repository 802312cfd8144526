"""What does not repeat of an error is found where the motion repeats, and nowhere else."""

import numpy as np
import pytest
from hand_made import RIGID, Sines, plain_force

from symid import Log, load_axis
from symid.diagnosis import diagnose
from symid.diagnosis.findings.gap_of_comparison import repeated_after

RATE, PERIOD = 2000.0, 2.0
STROKES = Sines(np.array([0.08, 0.01, 0.001]), np.array([1, 4, 14]) / PERIOD, np.array([0.0, 1.0, 2.0]))


def log(wander: float) -> Log:
    """Four strokes with a drag that the model lacks, and a force that is another in each of them."""
    t = np.arange(round(4 * PERIOD * RATE)) / RATE
    rng, v = np.random.default_rng(8), STROKES.at(t, 1)
    new = np.interp(t, np.arange(0.0, 9.0, 0.1), wander * rng.standard_normal(90))
    force = plain_force(STROKES, t) + 400 * v * np.abs(v) + new + 2.0 * rng.standard_normal(t.size)
    q = STROKES.at(t) + 2e-8 * rng.standard_normal(t.size)
    return Log.from_arrays({"F": force, "q": q}, sampling_period=1 / RATE)


def test_what_is_new_each_time_is_neither_gap_nor_sensor_noise() -> None:
    found = diagnose(load_axis("rigid_1m"), log(6.0), validation=log(6.0), nominal=RIGID)
    new = found.gap.not_repeated
    assert new is not None
    assert new.period == pytest.approx(PERIOD, rel=0.01)
    assert new.level.rms == pytest.approx(6.0 * np.sqrt(2 / 3), rel=0.25)  # of straight lines between draws
    assert new.level.rms > 3 * found.gap.noise_floor.rms
    assert found.effects[0].effect == "quadratic_drag"
    assert "are new each time that the motion repeats, every 2 s" in " ".join(found.assumptions)


def test_motions_that_do_not_repeat() -> None:
    t = np.arange(0.0, 8.0, 0.01)
    assert repeated_after(np.sin(2 * np.pi * t / PERIOD)) == 200
    assert repeated_after(np.sin(2 * np.pi * t / 5.0)) is None  # not twice within the log
    # faster motion on it does not
    assert repeated_after(np.sin(np.pi * t) + 0.01 * np.sin(30 * t**1.5)) is None
    assert repeated_after(np.sin(t**2)) is None
    assert repeated_after(t) is None
    assert repeated_after(np.zeros(100)) is None
