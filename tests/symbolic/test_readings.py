"""Regressors with force sensors, gains and offsets, against steady vibrations of equations written by hand."""

import numpy as np
import pytest
from axes.force_sensors import DRIVE, ELEMENTS, LOAD, MOTOR, SHAFT, VALUES, celled, phasors

from symid import (
    Acceleration,
    Axis,
    Between,
    Body,
    CoulombFriction,
    Drive,
    Force,
    Position,
    Sensor,
    Spring,
    StribeckFriction,
    Velocity,
    ViscousFriction,
    derive,
)
from symid.codegen.generated_models import compiled
from symid.errors import DeclarationError, EliminationError
from symid.signal_names import split_derivative

SCALES = {"cq": 1.25, "oq": 0.003, "cf": 2000.0, "of": 5.0, "Kt": 40.0}


def residual(axis: Axis, measured: tuple[str, ...], scaled: dict[str, tuple[float, float, complex]]) -> float:
    """Largest error of y = W X over a vibration, relative to y; `scaled` has gain, offset and phasor of a signal."""
    model, omega, t = compiled(derive(axis, measured)), 40.0, np.linspace(0.0, 0.3, 50)
    found = {name: (1.0, 0.0, phasor) for name, phasor in phasors(omega).items()} | scaled
    signals = {}
    for name in model.signals:
        signal, order = split_derivative(name)
        gain, offset, phasor = found[signal]
        vibration = np.real((1j * omega) ** order * phasor * np.exp(1j * omega * t))
        signals[name] = (vibration - (offset if order == 0 else 0.0)) / gain
    W, y = model.sample(signals)
    values = VALUES | SCALES
    X = model.minimal_parameters(*(values[name] for name in model.physical_units))
    return float(np.max(np.abs(W @ X - y)) / np.max(np.abs(y)))


@pytest.mark.parametrize("measured", [("qm", "cell"), ("ql", "cell"), ("qm", "ql", "cell")])
def test_a_force_sensor_in_a_spring(measured: tuple[str, ...]) -> None:
    axis = celled()
    assert residual(axis, measured, {}) < 1e-12
    identified = derive(axis, measured).parameter_map.identifiability
    assert {identified[name] for name in VALUES} == {"unique"}


def test_a_balance_holds_the_force_that_is_read_in_place_of_the_spring() -> None:
    lines = str(derive(celled(), ("qm", "ql", "cell"))).splitlines()
    assert any(line.strip() == "-cell = X5*(ql_d2) + X6*(ql_d1)" for line in lines), lines


def test_a_transducer_at_a_drive_determines_its_constant() -> None:
    drive = Drive("iq", MOTOR, gain="Kt", unit="A")
    axis = Axis("t", ELEMENTS, drive, (Position("qm", MOTOR), Force("fd", drive)))
    vibration = phasors(40.0)
    current = (1.0, 0.0, vibration["F"] / SCALES["Kt"])
    assert residual(axis, ("qm", "fd"), {"fd": (1.0, 0.0, vibration["F"]), "iq": current}) < 1e-12
    assert derive(axis, ("qm", "fd")).parameter_map.identifiability["Kt"] == "unique"
    assert derive(axis, ("qm",)).parameter_map.identifiability["Kt"] == "none"


def test_a_transducer_at_a_drive_whose_force_is_known_adds_no_equation() -> None:
    axis = celled((Position("qm", MOTOR), Force("fd", DRIVE)))
    both, one = derive(axis, ("qm", "fd")), derive(axis, ("qm",))
    assert both.minimal.written == one.minimal.written
    assert "fd repeats the record of its drive and is not used" in both.assumptions


@pytest.mark.parametrize(
    ("sensor", "phasor"),
    [
        (Position("r", LOAD, gain="cq", offset="oq"), phasors(40.0)["ql"]),
        (Position("r", MOTOR, gain="cq", offset="oq"), phasors(40.0)["qm"]),
        (Velocity("r", MOTOR, gain="cq", offset="oq"), 40j * phasors(40.0)["qm"]),
        (Acceleration("r", LOAD, gain="cq", offset="oq"), -(40.0**2) * phasors(40.0)["ql"]),
    ],
)
def test_gain_and_offset_beside_another_sensor(sensor: Sensor, phasor: complex) -> None:
    axis = celled((Position("qm", MOTOR), sensor))
    assert residual(axis, ("qm", "r"), {"r": (SCALES["cq"], SCALES["oq"], phasor)}) < 1e-12
    assert derive(axis, ("qm", "r")).parameter_map.identifiability["cq"] == "unique"


def test_a_deflection_behind_a_gear() -> None:
    vibration = phasors(40.0)
    sensor = Position("d", LOAD, relative_to=MOTOR, ratio=0.25)
    axis = celled((Position("qm", MOTOR), sensor))
    deflection = vibration["ql"] - 0.25 * vibration["qm"]
    assert residual(axis, ("qm", "d"), {"d": (1.0, 0.0, deflection)}) < 1e-12


def test_two_ratios_between_the_same_bodies_are_two_constants() -> None:
    screw, nut = Body("screw", inertia="J"), Body("nut", mass="M")
    spring = Spring("nut_spring", Between(first=screw, second=nut, ratio=0.0021), stiffness="K")
    sensors = (Position("q", screw), Position("d", nut, relative_to=screw, ratio=0.0019))
    model = derive(Axis("s", (screw, spring, nut), Drive("T", screw), sensors), ("q", "d"))
    assert sorted(model.minimal.source.source.constants.values()) == [0.0019, 0.0021]


def test_a_ratio_is_that_of_a_reference() -> None:
    screw, nut = Body("screw", inertia="J"), Body("nut", mass="M")
    spring = Spring("nut_spring", Between(first=screw, second=nut, ratio=0.002), stiffness="K")
    turning = (screw, spring, nut), Drive("T", screw)
    read = Axis("s", *turning, (Position("q", screw), Position("d", nut, relative_to=screw, ratio=0.002)))
    assert str(read.signal_units["d"]) == "m"
    with pytest.raises(DeclarationError, match="or with the ratio= of a deflection"):
        Axis("s", *turning, (Position("q", screw), Position("d", nut, relative_to=screw)))
    with pytest.raises(DeclarationError, match="ratio scales the body that relative_to= names"):
        Axis("s", *turning, (Position("q", screw), Position("d", nut, ratio=0.002)))


def test_an_accelerometer_beside_a_sensor_of_unknown_gain_determines_that_gain() -> None:
    slide = Body("slide", mass="M")
    sensors = (Position("wire", slide, gain="c", offset="o", unit="V"), Acceleration("a", slide))
    axis = Axis("drawn", (slide, ViscousFriction(slide, "Fv")), Drive("F", slide), sensors)
    model = derive(axis, ("wire", "a"))
    assert "a = X3*(wire_d2)" in [line.strip() for line in str(model).splitlines()], model
    assert model.parameter_map.identifiability["c"] == "unique"


def test_gain_and_offset_of_a_force_sensor() -> None:
    cell = Force("cell", SHAFT, gain="cf", offset="of", unit="V")
    axis = celled((Position("qm", MOTOR), Position("ql", LOAD), cell))
    assert (str(axis.parameter_units["cf"]), str(axis.parameter_units["of"])) == ("N/V", "N")
    scale = (SCALES["cf"], SCALES["of"], phasors(40.0)["cell"])
    assert residual(axis, ("qm", "ql", "cell"), {"cell": scale}) < 1e-12


def test_the_gain_of_the_only_sensor_needs_a_known_mass() -> None:
    table = Body("table", mass="M")
    laws = (table, ViscousFriction(table, "Fv"), CoulombFriction(table, "Fs"))
    axis = Axis("t", laws, Drive("F", table), (Position("q", table, gain="c"),))
    assert derive(axis).parameter_map.identifiability == {
        "M": "none",
        "Fv": "none",
        "Fs": "unique",
        "c": "none",
    }
    found = derive(axis.with_known({"M": 12.5})).parameter_map.identifiability
    assert found == {"Fv": "unique", "Fs": "unique", "c": "unique"}


def test_the_offset_of_a_position_is_felt_by_a_spring_to_the_ground() -> None:
    table = Body("table", mass="M")
    elements = (table, ViscousFriction(table, "Fv"), Spring("bellows", table, stiffness="K"))
    axis = Axis("t", elements, Drive("F", table), (Position("q", table, offset="o"),))
    assert str(derive(axis)).splitlines()[1].strip() == "F = X1*(q) + X2*(q_d1) + X3*(q_d2) + X4*(1)"
    assert str(derive(axis).minimal.parameters[3].function.expression) == "K*o"
    assert derive(axis).parameter_map.identifiability["o"] == "unique"


def test_a_law_that_feels_the_size_of_a_motion_needs_its_gain() -> None:
    table = Body("table", mass="M")
    axis = Axis(
        "t",
        (table, StribeckFriction(table, "dF", velocity=0.02)),
        Drive("F", table),
        (Position("q", table, gain="c"),),
    )
    with pytest.raises(
        EliminationError, match="StribeckFriction at 'table' depends on how large a motion is"
    ):
        derive(axis)
    assert "exp" in str(derive(axis.with_known({"c": 2.0})))
