"""The exported C against numpy's generated modules, the simulation and the equations written by hand."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from axes import force_sensors
from axes.case import PINION
from axes.catalogue import cases, derived, generated
from axes.effects import EFFECTS, values_of, with_effect
from axes.plant import random_motion
from driven import acceleration, driven
from export.compiler import Compiled, with_run

from symid import Axis, Backlash, Position
from symid.codegen.generated_models import compiled
from symid.export import c_source
from symid.simulation import plant_of
from symid.symbolic import derive

SAMPLES = 40
COORDINATES = {"rack_and_pinion": np.array([[1.0, 0.0], [-PINION, 1.0]])}
"""State displacements in those of the catalogue where they differ: a load on a geared carriage moves relative to it."""


def accelerations(
    code: Compiled, values: Mapping[str, float], x: np.ndarray, force: np.ndarray
) -> np.ndarray:
    """Derivatives of states by the compiled function, of shape (2 n, samples)."""
    p = code.parameters(values)
    samples = zip(np.ascontiguousarray(x.T), force, strict=True)
    return np.array([code.function("derivative", p, state, f, shape=state.shape) for state, f in samples]).T


def close(found: np.ndarray, wanted: np.ndarray, terms: np.ndarray) -> None:
    """Equal to rounding, relative to the largest term of the sum."""
    np.testing.assert_allclose(found, wanted, rtol=1e-12, atol=1e-12 * float(np.max(terms)))


@pytest.fixture(scope="module", params=list(cases()))
def code(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Compiled:
    """Each axis of the catalogue with its last set of sensors."""
    name, case = request.param, cases()[request.param]
    exported = c_source(derived(name, case.sensor_sets[-1]), case.values)
    return Compiled.of(exported, name, tmp_path_factory.mktemp(name))


def test_regressor_output_and_minimal_parameters_are_those_of_numpy(code: Compiled) -> None:
    case = cases()[code.name]
    model = generated(code.name, case.sensor_sets[-1])
    orders = max(model.highest_derivatives.values()) + 3
    motion = random_motion(case.plant(), orders, SAMPLES, seed=7)
    signals = motion.signals(case.declared.drive.signal, case.sensors, model.signals)
    W, y = model.sample(signals)
    for k in range(SAMPLES):
        row = np.array([signals[s][k] for s in model.signals])
        np.testing.assert_allclose(code.function("regressor", row, shape=W[:, k].shape), W[:, k], rtol=1e-12)
        np.testing.assert_allclose(code.function("output", row, shape=(len(y),)), y[:, k], rtol=1e-12)
    X = model.minimal_parameters(*(case.values[p] for p in model.physical_units))
    found = code.function("minimal_parameters", code.parameters(case.values), shape=X.shape)
    np.testing.assert_allclose(found, X, rtol=1e-12)


def test_known_values_among_the_parameters_keep_minimal_parameters(tmp_path: Path) -> None:
    case = cases()["direct_2m1s"]
    axis = case.declared.with_known({"Ms": case.values["Ms"], "Fvm": case.values["Fvm"]})
    model = derive(axis, ("q2",))
    values = {name: case.values[name] for name in axis.physical_parameters}
    code = Compiled.of(c_source(model, values), axis.name, tmp_path)
    X = compiled(model).minimal_parameters(*values.values())
    found = code.function("minimal_parameters", code.parameters(values), shape=X.shape)
    np.testing.assert_allclose(found, X, rtol=1e-12)


def test_forward_dynamics_are_those_written_by_hand_and_those_simulated(code: Compiled) -> None:
    case = cases()[code.name]
    machine, plant = case.plant(), plant_of(case.declared, case.values)
    motion = random_motion(machine, 3, SAMPLES, seed=3)
    n, change = machine.bodies, COORDINATES.get(code.name, np.eye(machine.bodies))
    x = np.vstack([change @ motion.x[0], change @ motion.x[1]])
    found = accelerations(code, case.values, x, motion.force[0])
    np.testing.assert_array_equal(found[:n], x[n:])
    by_hand, by_plant = change @ motion.x[2], simulated(plant, x, motion.force[0])
    sizes = np.abs(np.linalg.inv(machine.M)) @ (
        np.abs(machine.K) @ np.abs(motion.x[0]) + np.abs(machine.C) @ np.abs(motion.x[1])
    ) + np.abs(motion.x[2])
    close(found[n:], by_hand, sizes)
    close(found[n:], by_plant, sizes)


def simulated(plant, x: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Accelerations by the terms of the simulation, of shape (n, samples)."""
    states = zip(x.T, force, strict=True)
    return np.array([acceleration(plant, state, float(f)) for state, f in states]).T


@pytest.mark.parametrize("name", list(EFFECTS))
def test_effects_are_in_both(name: str, tmp_path: Path) -> None:
    axis, values = with_effect(name), values_of(name)
    values = {p: values[p] for p in axis.physical_parameters}
    measured = tuple(s.signal for s in axis.sensors)
    model = derive(axis, measured)
    code = Compiled.of(c_source(model, values), axis.name, tmp_path)
    x = states_of(axis, np.random.default_rng(5))
    force = np.random.default_rng(6).normal(size=SAMPLES) * 100
    plant, module = plant_of(axis, values), compiled(model)
    found = accelerations(code, values, x, force)
    close(found[len(plant.bodies) :], simulated(plant, x, force), np.array(50.0))
    signals = {s: np.random.default_rng(i).normal(size=SAMPLES) * 1e-2 for i, s in enumerate(module.signals)}
    W, _ = module.sample(signals)
    for k in range(SAMPLES):
        row = np.array([signals[s][k] for s in module.signals])
        np.testing.assert_allclose(
            code.function("regressor", row, shape=W[:, k].shape), W[:, k], rtol=1e-12, atol=1e-15
        )


def states_of(axis: Axis, draw: np.random.Generator) -> np.ndarray:
    """States within a joint's play and beyond it."""
    n = len(axis.free_bodies)
    q = 0.1 * draw.normal(size=(1, SAMPLES)) + 5e-5 * draw.normal(size=(n, SAMPLES))
    return np.vstack([q, 0.1 * draw.normal(size=(n, SAMPLES))])


def test_sensors_read_what_the_simulation_reads(tmp_path: Path) -> None:
    case = cases()["direct_3m2s"]
    code = Compiled.of(c_source(derived("direct_3m2s", ("q2",)), case.values), "direct_3m2s", tmp_path)
    x, dx = np.arange(1.0, 7.0) ** 2, np.arange(1.0, 7.0) ** 3
    read = code.function("sensors", x, dx, shape=(3,))
    np.testing.assert_array_equal(read, [4.0 - 1.0, 4.0**3, 6.0**3 - 5.0**3])


def test_a_load_cell_and_a_scaled_sensor_are_read_from_the_state(tmp_path: Path) -> None:
    scale = Position("r", force_sensors.LOAD, gain=2.0, offset=0.5)
    axis, values = (
        force_sensors.celled((force_sensors.MOTOR_SCALE, force_sensors.CELL, scale)),
        force_sensors.VALUES,
    )
    code = Compiled.of(c_source(axis, values), "celled", tmp_path)
    read = code.function("sensors", np.array([0.1, 0.3, 2.0, 5.0]), np.zeros(4), shape=(3,))
    np.testing.assert_allclose(read, [0.1, 4e5 * 0.2 + 60.0 * 3.0, (0.3 - 0.5) / 2.0], rtol=1e-12)


def test_a_load_cell_reads_the_play_of_its_spring(tmp_path: Path) -> None:
    play = Backlash(force_sensors.SHAFT.at, "Kb", gap=0.1)
    axis = force_sensors.celled().with_effect(play)
    values = force_sensors.VALUES | {"Kb": 3e5}
    code = Compiled.of(c_source(axis, values), "celled", tmp_path)
    read = code.function("sensors", np.array([0.1, 0.3, 2.0, 5.0]), np.zeros(4), shape=(3,))
    np.testing.assert_allclose(read[2], 4e5 * 0.2 + 60.0 * 3.0 - 3e5 * 0.05, rtol=1e-12)


def test_a_rest_speed_smooths_friction(tmp_path: Path) -> None:
    values = {"M": 2.0, "Fv": 0.0, "Fs": 4.0}
    exported = c_source(derived("rigid_1m", ("q",)), values)
    (tmp_path / "sharp").mkdir(), (tmp_path / "smooth").mkdir()
    sharp = Compiled.of(exported, "rigid_1m", tmp_path / "sharp")
    smooth = Compiled.of(exported, "rigid_1m", tmp_path / "smooth", "-DSYMID_REST_SPEED=1e-3")
    x = np.array([[0.0] * 3, [5e-4, -5e-4, 2e-3]])
    force = np.zeros(3)
    assert accelerations(sharp, values, x, force)[1].tolist() == [-2.0, 2.0, -2.0]
    assert accelerations(smooth, values, x, force)[1].tolist() == pytest.approx([-1.0, 1.0, -2.0])
    assert any("rest" in loss for loss in exported.losses)


@pytest.mark.parametrize(
    "name",
    [
        "rigid_1m",
        "direct_2m1s",
        "ballscrew_2m1s",
        "vertical_2m1s",
        "emps_asymmetric",
        "both_ends",
        "pendulum",
        "ripple_and_drag",
    ],
)
def test_steps_stick_and_slide_as_the_simulation_does(name: str, tmp_path: Path) -> None:
    case = cases()[name]
    exported = c_source(derived(name, case.sensor_sets[0]), case.values)
    code = Compiled.of(with_run(exported, name), name, tmp_path)
    plant = plant_of(case.declared, case.values)
    t = np.arange(300) * 1e-3
    level = 0.5 * float(np.sum(np.diag(plant.mass))) + 2 * sum(law.limits(0.0)[1] for law in plant.laws)
    weight = -float(np.sum(plant.constant))
    forces = np.where(t < 0.2, level * np.sin(2 * np.pi * 7 * t), 0.0) + weight
    wanted = driven(case.declared, case.values, forces, 1e-3)[1:]
    n = len(plant.bodies)
    sizes = (2 * n, len(case.declared.sensors))
    coarse, fine = (code.run(case.values, forces, 1e-3, h, sizes)[0] for h in (2e-5, 1.25e-6))
    errors = [
        np.max(np.abs(found[:, :n] - wanted[:, :n])) / np.ptp(wanted[:, :n]) for found in (coarse, fine)
    ]
    assert errors[0] < 1e-3
    assert errors[1] < errors[0] / 5
