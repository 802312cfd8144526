"""Spans in which a force without visible noise keeps one value: while the acceleration changes, no drive does so."""

import numpy as np
import pytest

from symid import Log, identify, load_generated
from symid.arrays import FloatArray

PERIOD = 1e-3


def record(a: FloatArray) -> dict[str, FloatArray]:
    """A mass of 5 kg with friction that is accelerated from rest: the reading has noise, the force has none."""
    v = PERIOD * np.cumsum(a)
    q = PERIOD * np.cumsum(v) + 1e-7 * np.random.default_rng(3).standard_normal(a.size)
    return {"q": q, "F": 5 * a + 4 * v + 6 * np.sign(v)}


def message_of(signals: dict[str, FloatArray]) -> str:
    log = Log.from_arrays(signals, sampling_period=PERIOD)
    return identify(load_generated("rigid_1m"), log).message


@pytest.mark.parametrize("is_held", [True, False])
def test_a_force_that_is_held_while_the_acceleration_changes_is_named(is_held: bool) -> None:
    t = PERIOD * np.arange(6000)
    signals = record(20 * np.cos(17 * t) + 30 * np.cos(41 * t))
    for start in range(500, 5500, 500) if is_held else ():
        signals["F"][start : start + 40] = signals["F"][start]
    assert ("F keeps exactly one value over" in message_of(signals)) == is_held


def test_a_force_that_stays_the_same_at_constant_speed_is_none_that_is_held() -> None:
    ramp, cruise = np.full(200, 4.0), np.zeros(300)
    move = np.concatenate([ramp, cruise, -ramp])
    assert "keeps exactly one value" not in message_of(record(np.tile(np.concatenate([move, -move]), 4)))
