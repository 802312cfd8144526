"""A second sensor in another unit than the axis says is a fault of the recording, and no gap that is passed over."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from symid import Axis, Between, Body, Drive, Force, Log, Position, Sensor, Spring, ViscousFriction, simulate
from symid.diagnosis import diagnose
from symid.simulation import chirp, plant_of, tuned_cascade

MOTOR, LOAD = Body("motor", inertia="Jm"), Body("load", inertia="Jl")
SHAFT = Spring("shaft", Between(first=MOTOR, second=LOAD, ratio=0.35), stiffness="K", damping="D")
ELEMENTS = (MOTOR, ViscousFriction(MOTOR, "Fm"), LOAD, ViscousFriction(LOAD, "Fl"), SHAFT)
TRUE = {"Jm": 1e-3, "Fm": 5e-3, "Jl": 8e-3, "Fl": 0.02, "K": 120.0, "D": 0.05}
SENSORS = {"ql": Position("ql", LOAD, noise=1e-6), "cell": Force("cell", SHAFT, noise=1e-4)}


def axis_with(sensor: Sensor) -> Axis:
    drive = Drive("T", MOTOR, held=True, noise=1e-4)
    others = (Position("qm", MOTOR, noise=1e-6), SENSORS["ql"])
    return Axis("joint", ELEMENTS, drive, tuple(dict.fromkeys((*others, sensor))))


@cache
def logged(name: str) -> Log:
    axis = axis_with(SENSORS[name])
    reference = chirp(1.0, 30.0, 5.0, 1.0, sampling_period=1e-3, quantity="velocity")
    controller = tuned_cascade(plant_of(axis, TRUE), "qm", bandwidth_hz=10.0)
    return simulate(axis, TRUE, reference, controller, seed=4).log


@pytest.mark.parametrize("name", list(SENSORS))
def test_a_sensor_of_another_gain(name: str) -> None:
    log, axis = logged(name), axis_with(SENSORS[name])
    wrong = replace(log, signals={**log.signals, name: 1.15 * log[name]})
    found = diagnose(axis, wrong, nominal=TRUE, library=())
    assert found.verdict == "recording"
    assert any(text.startswith(f"{name} would have to be 0.8") for text in found.faults), found.faults


@pytest.mark.parametrize("name", list(SENSORS))
def test_the_right_gain_is_no_fault(name: str) -> None:
    found = diagnose(axis_with(SENSORS[name]), logged(name), nominal=TRUE, library=())
    assert found.verdict == "no_gap", found.sentence


def test_a_reading_that_something_else_shakes_is_no_wrong_gain() -> None:
    """A reading many times the predicted one would need a gain near nothing, which explains it no better."""
    log, axis = logged("cell"), axis_with(SENSORS["cell"])
    shaken = log["cell"] + 20.0 * np.std(log["cell"]) * np.sin(2 * np.pi * 20.0 * log.time)
    found = diagnose(axis, replace(log, signals={**log.signals, "cell": shaken}), nominal=TRUE, library=())
    assert not any("would have to be" in text for text in found.faults), found.faults
