"""A delay at which the estimate is no machine any more is not offered as the cure."""

import numpy as np
import pytest

from symid import Log, Preparation, identify

RATE, HALF_PERIOD, FAR = 500.0, 0.15, 0.2
PREPARED = Preparation(cutoff_hz=20.0)


def swinging(mass: float, late: float, rates: tuple[float, ...]) -> Log:
    """A slide that swings and drifts on in one direction; the force is that of `late` seconds before."""
    t = np.arange(3000) / RATE
    w = 2 * np.pi * np.array(rates)[:, None]
    phase = np.arange(len(rates))[:, None]

    def moved(s: np.ndarray, order: int) -> np.ndarray:
        return np.sum(w ** (order - 1) * np.sin(w * s + phase + order * np.pi / 2), axis=0) / len(rates)

    past = t - late
    force = mass * 0.3 * moved(past, 2) + 12.0 * (0.4 + 0.3 * moved(past, 1)) + 9.0
    noise = np.random.default_rng(1).standard_normal((2, t.size))
    q = 0.4 * t + 0.3 * moved(t, 0) + 1e-6 * noise[0]
    return Log.from_arrays({"q": q, "F": force + 0.5 * noise[1]}, sampling_period=1 / RATE)


def test_a_delay_that_makes_a_mass_negative_is_none() -> None:
    """What swings at nearly one frequency is met half a period later by the opposite mass."""
    found = identify("rigid_1m", swinging(-6.0, HALF_PERIOD, (3.0, 3.7)), preparation=PREPARED)
    assert found.physical_parameters["M"] > 0
    assert found.timing is None or abs(found.timing.late) < HALF_PERIOD / 2


def test_a_far_delay_of_a_machine_is_still_found() -> None:
    found = identify("rigid_1m", swinging(6.0, FAR, (0.3, 0.8, 1.7)), preparation=PREPARED)
    assert found.timing is not None
    assert found.timing.late == pytest.approx(FAR, abs=3 * found.timing.deviation)
    assert found.timing.deviation < 2 / RATE
