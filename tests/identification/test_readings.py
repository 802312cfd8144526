"""Parameters from force sensors and scaled sensors, of simulated logs whose values are known."""

from dataclasses import replace
from typing import Literal

import pytest
from axes.force_sensors import CELL, ELEMENTS, LOAD, LOAD_SCALE, MOTOR, MOTOR_SCALE, SHAFT, VALUES, celled

import symid
from symid import (
    Axis,
    Backlash,
    Body,
    CoulombFriction,
    Drive,
    Force,
    Law,
    Log,
    Position,
    Spring,
    StiffnessNonlinearity,
    ViscousFriction,
)
from symid.simulation import chirp, plant_of, simulate, trapezoids, tuned_cascade

REFERENCE = chirp(0.5, 20.0, 2.5, 0.002, sampling_period=5e-4)
SCALES = {"cq": 1.02, "oq": 0.003, "cf": 2000.0, "of": 5.0, "Kt": 40.0}


def logged(axis: Axis) -> Log:
    values = VALUES | SCALES
    return simulate(axis, values, REFERENCE, tuned_cascade(plant_of(axis, values), "qm"), seed=4).log


def close(found: symid.Identification, names: tuple[str, ...], share: float) -> None:
    assert found.status == "ok", found.message
    for name in names:
        assert found.physical_parameters[name] == pytest.approx((VALUES | SCALES)[name], rel=share), name


@pytest.mark.parametrize(
    ("sensors", "method"),
    [
        ((MOTOR_SCALE, CELL), "wls"),
        ((MOTOR_SCALE, LOAD_SCALE, CELL), "wls"),
        ((MOTOR_SCALE, LOAD_SCALE, CELL), "oe"),
    ],
)
def test_a_load_cell(sensors: tuple[symid.Sensor, ...], method: Literal["wls", "oe"]) -> None:
    axis = celled(sensors)
    found = symid.identify(axis, logged(axis), method=method)
    close(found, ("Mm", "K", "Ml"), 1e-3)
    close(found, ("D", "Fvl", "Fvm"), 0.02)


@pytest.mark.parametrize(
    "law", [StiffnessNonlinearity(SHAFT.at, "k3"), Backlash(SHAFT.at, "Kb", gap=4e-5)], ids=["cubic", "play"]
)
def test_a_load_cell_in_a_nonlinear_spring(law: Law) -> None:
    own = {"k3": 8e11, "Kb": VALUES["K"]}
    axis = celled((MOTOR_SCALE, LOAD_SCALE, CELL)).with_effect(law)
    values = VALUES | own
    log = simulate(axis, values, REFERENCE, tuned_cascade(plant_of(axis, values), "qm"), seed=4, steps=4).log
    found = symid.identify(axis, log)
    close(found, ("Mm", "K", "Ml"), 2e-3)
    (name,) = set(found.physical_parameters) & set(own)
    assert found.physical_parameters[name] == pytest.approx(own[name], rel=0.02)


def test_a_transducer_determines_the_constant_of_a_drive() -> None:
    drive = Drive("iq", MOTOR, gain="Kt", unit="A", held=True, noise=0.002)
    sensors = (MOTOR_SCALE, LOAD_SCALE, Force("fd", drive, noise=0.1))
    axis = Axis("t", ELEMENTS, drive, sensors)
    close(symid.identify(axis, logged(axis)), ("Kt", "Mm", "Ml", "K"), 2e-3)


def test_the_scale_of_a_second_encoder() -> None:
    scaled = Position("ql", LOAD, gain="cq", offset="oq", noise=1e-8)
    axis = celled((MOTOR_SCALE, scaled))
    close(symid.identify(axis, logged(axis), method="oe"), ("cq", "oq", "K", "Ml", "Mm"), 1e-3)


def test_gain_and_offset_of_a_load_cell() -> None:
    cell = Force("cell", SHAFT, gain="cf", offset="of", unit="V", noise=1e-4)
    axis = celled((MOTOR_SCALE, LOAD_SCALE, cell))
    close(symid.identify(axis, logged(axis)), ("cf", "of", "K", "Ml", "Mm"), 2e-3)


def test_a_scale_that_nothing_determines_is_named() -> None:
    scaled = Position("qm", MOTOR, gain="cq", noise=1e-8)
    axis = celled((scaled,))
    found = symid.identify(axis, logged(axis))
    assert found.status == "no_physical_parameters"
    assert ", cq, however the axis moves: give one with `fixed`" in found.message


@pytest.mark.parametrize(("wrong", "noise"), [(1.0, 1.0), (1.0, 3.0), (0.5, 1.0), (2.0, 0.3)])
def test_noise_of_a_load_cell_is_no_wrong_gain(wrong: float, noise: float) -> None:
    moves = trapezoids(0.2, [0.5, 0.1], acceleration=5.0, jerk=500.0, dwell=0.1, sampling_period=5e-4)
    axis, values = on_feet(noise)
    log = simulate(axis, values, moves, tuned_cascade(plant_of(axis, values), "q"), seed=1).log
    found = symid.identify(axis, replace(log, signals={**log.signals, "cell": wrong * log["cell"]}))
    if wrong == 1.0:
        assert found.status == "ok", found.message
        assert found.physical_parameters == pytest.approx(values, rel=0.02)
    else:
        assert found.status == "recording"
        assert "cell would have to be" in found.message


def on_feet(noise: float) -> tuple[Axis, dict[str, float]]:
    """A motor on a base whose feet hold a load cell, and values."""
    base = Body("base", mass="Mb")
    motor, feet = Body("motor", mass="Mm", on=base), Spring("feet", base, stiffness="Kb", damping="Db")
    elements = (base, feet, motor, ViscousFriction(motor, "Fv"), CoulombFriction(motor, "Fc"))
    sensors = (Position("q", motor, noise=1e-9), Force("cell", feet, noise=noise))
    values = {"Mb": 150.0, "Mm": 40.0, "Kb": 2e6, "Db": 1500.0, "Fv": 80.0, "Fc": 12.0}
    return Axis("on_feet", elements, Drive("F", motor, held=True), sensors), values


def test_a_cutoff_at_which_noise_drowns_the_cell_is_lowered() -> None:
    speeds = [0.5, 0.25, 0.1]
    moves = trapezoids(0.2, speeds, acceleration=5.0, jerk=500.0, dwell=0.2, sampling_period=1.25e-4)
    axis, values = on_feet(1.0)
    log = simulate(axis, values, moves, tuned_cascade(plant_of(axis, values), "q"), seed=1).log
    found = symid.identify(axis, log)
    assert found.status == "ok", found.message
    assert found.physical_parameters == pytest.approx(values, rel=0.02)
