"""A log that shows the law of its controller is not read as one that shows the machine."""

import re

import numpy as np
import pytest

from symid import Axis, Body, CoulombFriction, Drive, Log, Position, ViscousFriction
from symid.diagnosis import diagnose

STEP = 1e-3
GAIN, RATE_GAIN, LATE = 8.0, 1.2, 25
HUB = Body("hub", inertia="J")
AXIS = Axis(
    "hub",
    (HUB, ViscousFriction(HUB, "Fv"), CoulombFriction(HUB, "Fc")),
    Drive("u", HUB, unit="V"),
    (Position("q", HUB),),
)


def closed_loop(reference: np.ndarray) -> Log:
    """J q'' = u(t - 25 ms) - Fv q' - Fc sign(q') with u = K (r - q) - D q', by Euler's rule at 20 kHz."""
    parts = 20
    q, v, kept = 0.0, 0.0, np.zeros((2, reference.size))
    for k, wanted in enumerate(reference):
        kept[:, k] = q, GAIN * (wanted - q) - RATE_GAIN * v
        acting = kept[1, k - LATE] if k >= LATE else 0.0
        for _ in range(parts):
            rate = v + STEP / parts * (acting - 0.2 * v) / 0.08
            held = STEP / parts * 0.3 / 0.08
            v = np.sign(rate) * max(abs(rate) - held, 0.0)
            q += STEP / parts * v
    noisy = kept[0] + 2e-5 * np.random.default_rng(1).standard_normal(reference.size)
    return Log.from_arrays({"q": noisy, "u": kept[1]}, sampling_period=STEP, source="loop")


def test_one_step_of_the_reference_shows_the_controller() -> None:
    found = diagnose(AXIS, closed_loop(np.ones(700)), nominal={"J": 0.08, "Fv": 0.2, "Fc": 0.3})
    assert found.verdict == "recording"
    assert not found.effects
    law = re.search(r"([\d.]+) - ([\d.]+) q - ([\d.]+) dq/dt", found.faults[0])
    assert law is not None
    assert [float(gain) for gain in law.groups()] == pytest.approx([GAIN, GAIN, RATE_GAIN], rel=0.01)


def test_a_reference_that_moves_shows_the_machine() -> None:
    time = STEP * np.arange(6000)
    moved = np.sin(2 * np.pi * 0.7 * time) + 0.4 * np.sin(2 * np.pi * 1.9 * time)
    found = diagnose(AXIS, closed_loop(moved), nominal={"J": 0.08, "Fv": 0.2, "Fc": 0.3})
    assert found.verdict in ("effect", "partly")
    assert found.effects[0].effect in ("delay", "actuator_lag")
    assert not any("controller" in text for text in found.faults)


def test_a_force_of_the_other_sign_is_distinguished_from_an_axis_that_lacks_something() -> None:
    time = STEP * np.arange(6000)
    log = closed_loop(np.sin(2 * np.pi * 0.7 * time) + 0.4 * np.sin(2 * np.pi * 1.9 * time))
    turned = Log.from_arrays({"q": log["q"], "u": -log["u"]}, sampling_period=STEP, source="turned")
    nominal = {"J": 0.08, "Fv": 0.2, "Fc": 0.3}
    assert "opposite to the force that the motion needs" in diagnose(AXIS, turned, nominal=nominal).faults[0]
