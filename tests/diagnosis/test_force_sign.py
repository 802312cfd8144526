"""A force whose sign or samples are lost, and one that a weight keeps on one side."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.effect_machines import ELASTIC, LOAD, MOTOR, RIGID, SENSORS
from symid import Axis, Body, Drive, Log, Position, ViscousFriction, Weight, load_axis
from symid.diagnosis import diagnose
from symid.simulation import Cascade, plant_of, simulate, trapezoids, tuned_cascade

AXIS = load_axis("rigid_1m").with_signal("q", noise=1e-7).with_signal("F", noise=1.0)
VALUES = {"M": 100.0, "Fv": 120.0, "Fs": 30.0}
LOST = "F never changes its sign, though the motion asks for both"


@pytest.fixture(scope="module")
def log() -> Log:
    moves = trapezoids([0.1], [0.2, 0.3], acceleration=3.0, jerk=60.0, dwell=0.1, sampling_period=1e-3)
    return simulate(AXIS, VALUES, moves, tuned_cascade(plant_of(AXIS, VALUES), "q"), seed=1).log


@pytest.mark.parametrize("nominal", [VALUES, None])
def test_an_absolute_value_is_named_with_and_without_nominal_values(
    log: Log, nominal: dict[str, float] | None
) -> None:
    rectified = replace(log, signals={**log.signals, "F": np.abs(log["F"])})
    found = diagnose(AXIS, rectified, nominal=nominal)
    assert found.verdict == "recording"
    assert found.faults[0].startswith(LOST)


@pytest.mark.parametrize("weight", [700.0, 3000.0])
def test_a_weight_that_the_model_lacks_is_no_lost_sign(log: Log, weight: float) -> None:
    lifted = replace(log, signals={**log.signals, "F": log["F"] + weight})
    assert lifted["F"].min() > 0
    found = diagnose(AXIS, lifted)
    assert not any(text.startswith(LOST) for text in found.faults)
    assert found.effects[0].effect == "offset_force"


@pytest.mark.parametrize("stiffness", [2e5, 9e5])
def test_a_hoist_with_a_mode_is_no_lost_sign(stiffness: float) -> None:
    # Beside a mode that the model lacks, signs that the axis chooses itself fit better than the re-identified axis.
    hung = RIGID.with_effect(Weight(MOTOR))
    machine = replace(ELASTIC, sensors=SENSORS).with_effect(Weight(MOTOR), Weight(LOAD))
    values = {"M": 12.0, "Fv": 50.0, "Fs": 16.0, "Ml": 8.0, "K": stiffness, "C": 100.0}
    moves = trapezoids(
        [0.12, 0.04], [0.06, 0.2, 0.4], acceleration=5.0, jerk=200.0, dwell=0.1, sampling_period=5e-4
    )
    log = simulate(machine, values, moves, Cascade("q", 20.0, 900.0, 4.0), start="equilibrium").log
    assert log["F"].min() > 0
    found = diagnose(hung, log)
    assert not any(text.startswith(LOST) for text in found.faults)
    assert found.effects[0].effect == "flexible_mode"


def test_a_force_with_samples_filled_with_zero_is_no_right_model(log: Log) -> None:
    # They scale the force: mass and friction come out a tenth too small, and nothing but noise is left.
    lost = np.random.default_rng(2).random(log.n_samples) < 0.1
    found = diagnose(AXIS, replace(log, signals={**log.signals, "F": np.where(lost, 0.0, log["F"])}))
    assert found.verdict == "recording"
    assert "samples were lost and filled with 0" in found.sentence


def test_a_spring_that_outweighs_the_inertia_is_no_wrong_sign() -> None:
    # A pendulum that is moved slower than it swings: its drive pushes against the acceleration.
    t = np.arange(2500) / 1000
    rng, q = np.random.default_rng(3), np.zeros(t.size)
    a = np.zeros(t.size)
    for f, size in ((0.8, 0.5), (1.1, 0.15), (1.7, 0.05)):
        q += size * np.sin(2 * np.pi * f * t)
        a -= size * (2 * np.pi * f) ** 2 * np.sin(2 * np.pi * f * t)
    pushed = 0.1 * a + 20.0 * np.sin(q) + 0.2 * np.gradient(q, t) + 0.1 * rng.standard_normal(t.size)
    read = q + 1e-5 * rng.standard_normal(t.size)
    assert np.corrcoef(pushed, a)[0, 1] < -0.5
    joint = Body("joint", inertia="J")
    axis = Axis("swung", (joint, ViscousFriction(joint, "Fv")), Drive("T", joint), (Position("q", joint),))
    found = diagnose(axis, Log.from_arrays({"q": read, "T": pushed}, sampling_period=1e-3))
    assert not found.faults
    names = {found.effects[0].effect, *(name for name, _ in found.effects[0].indistinguishable_from)}
    assert "weight" in names


def test_a_constant_force_that_speeds_an_axis_up_is_no_lost_sign() -> None:
    t = np.arange(800) / 1000
    speed = -57.0 * (1 - np.exp(-np.clip(t - 0.1, 0.0, None) / 0.05))
    read = np.cumsum(speed) / 1000 + 0.02 * np.random.default_rng(4).standard_normal(t.size)
    log = Log.from_arrays({"q": read, "F": np.where(t < 0.1, 0.0, -7.0)}, sampling_period=1e-3)
    table = Body("table", mass="M")
    found = diagnose(Axis("pushed", (table,), Drive("F", table), (Position("q", table),)), log)
    assert not any(text.startswith(LOST) for text in found.faults)
