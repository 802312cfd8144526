"""A gantry with two drives in C, as a unit and in MuJoCo, against its hand-written matrices."""

import ctypes
import math
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from axes.gantry import AXIS, LEFT, RIGHT, TRUE, matrices
from export.compiler import Compiled
from export.exported_unit import run_unit
from fmpy.validation import validate_fmu
from scipy.linalg import expm

from symid import (
    ActuatorDelay,
    ActuatorLag,
    Axis,
    Body,
    Drive,
    ForceConstantRipple,
    ForceLimit,
    GainAsymmetry,
    LoadDependentFriction,
    Position,
    Spring,
    ViscousFriction,
)
from symid.axis import Between
from symid.errors import SettingError
from symid.export import c_source, mjcf, write_fmu
from symid.export.feedforward import feedforward
from symid.symbolic import derive

RIPPLE = ForceConstantRipple(0.2, 0.1, pitch=0.002, drive="F2")
COMMANDED = replace(AXIS, drive=(AXIS.drives[0], Drive("F2", RIGHT, gain=-2.5, command="u2")))
SMOOTH = TRUE | {"Fs1": 0.0, "Fs2": 0.0}
PERIOD, N = 1e-3, 300


def by_hand(x: np.ndarray, v: np.ndarray, forces: np.ndarray) -> np.ndarray:
    """Accelerations of left, right and beam while both carriages slide."""
    M, C, K = matrices()
    friction = np.array([TRUE["Fs1"], TRUE["Fs2"], 0.0]) * np.sign(v)
    return np.linalg.solve(M, np.append(forces, 0.0) - C @ v - K @ x - friction)


def samples() -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Displacements, velocities and forces."""
    draw = np.random.default_rng(4)
    return [(1e-3 * draw.normal(size=3), draw.normal(size=3), 200 * draw.normal(size=2)) for _ in range(8)]


def integrated(forces: np.ndarray) -> np.ndarray:
    """Position of the beam after each interval of held forces, without Coulomb friction."""
    M, C, K = matrices()
    A = np.zeros((8, 8))
    A[:3, 3:6] = np.eye(3)
    A[3:6, :6] = -np.linalg.solve(M, np.hstack([K, C]))
    A[3:5, 6:] = np.diag(1 / np.diag(M)[:2])
    step, x, found = expm(A * PERIOD), np.zeros(8), []
    for pair in forces:
        x[6:] = pair
        x = step @ x
        found.append(x[2])
    return np.array(found)


def held_forces() -> np.ndarray:
    t = PERIOD * np.arange(N)
    return np.stack([300 * np.sin(60 * t), 200 * np.sin(23 * t) - 100], axis=1)


def test_the_derivative_in_c_is_that_of_the_matrices(tmp_path: Path) -> None:
    code = Compiled.of(c_source(derive(AXIS), TRUE), "gantry", tmp_path)
    p = code.parameters(TRUE)
    for x, v, forces in samples():
        state = np.concatenate([x, v])
        found = code.function("derivative", p, state, *map(float, forces), shape=(6,))
        np.testing.assert_array_equal(found[:3], v)
        np.testing.assert_allclose(found[3:], by_hand(x, v, forces), rtol=1e-11)


def test_a_unit_has_an_input_for_each_drive_and_moves_as_the_matrices_say(tmp_path: Path) -> None:
    file = tmp_path / "gantry.fmu"
    write_fmu(derive(COMMANDED), SMOOTH, file)
    assert validate_fmu(str(file)) == []
    forces = held_forces()
    inputs = {"F1": forces[:, 0], "u2": forces[:, 1] / -2.5}
    read = run_unit(file, inputs, "qb", PERIOD, {"internal_step": 2e-6})
    wanted = integrated(forces)
    assert np.abs(read - wanted).max() < 1e-3 * np.ptp(wanted)


def acting(forces: np.ndarray, step: float) -> np.ndarray:
    """Forces that act in each step: F1 by direction and late by a lag, F2 limited and 2 ms late."""
    first, second = (np.repeat(f, round(PERIOD / step)) for f in forces.T)
    late = round(2e-3 / step)
    second = np.clip(np.append(np.full(late, second[0]), second[:-late]), -150.0, 150.0)
    lagged, z = np.empty_like(first), 0.0
    for k, force in enumerate(first - 0.05 * np.abs(first)):
        lagged[k] = z + (force - z) * (1 - math.exp(-step / 2 / 3e-3))  # in the middle of the step
        z += (force - z) * (1 - math.exp(-step / 3e-3))
    return np.stack([lagged, second], axis=1)


def test_each_drive_has_its_own_imperfections_and_friction_feels_all_of_them(tmp_path: Path) -> None:
    own = (ActuatorLag(3e-3, drive="F1"), GainAsymmetry(0.05, drive="F1"))
    other = (ForceLimit(150.0, drive="F2"), ActuatorDelay(2e-3, drive="F2"), RIPPLE)
    axis, step, n = AXIS.with_effect(*own, *other, LoadDependentFriction(LEFT, 0.2)), 2e-5, 120
    code = Compiled.of(c_source(derive(axis), SMOOTH), "gantry", tmp_path)
    forces = held_forces()[:n]
    p, way, h = code.parameters(SMOOTH), ctypes.create_string_buffer(1_000_000), ctypes.c_double(step)
    x, y, read = np.zeros(7), np.zeros(3), []
    for f in np.repeat(forces, round(PERIOD / step), axis=0).tolist():
        code.library["gantry_advance"](p.ctypes, way, x.ctypes, *map(ctypes.c_double, f), h, y.ctypes)
        read.append(x[:3].copy())
    M, C, K = matrices(SMOOTH)
    place, speed, wanted = np.zeros(3), np.zeros(3), []
    for f in acting(forces, step):
        friction = 0.2 * np.abs(f).sum() * np.sign(speed[0])
        wave = 2 * np.pi * place[1] / RIPPLE.pitch
        lost = f[1] * (RIPPLE.sine * np.sin(wave) + RIPPLE.cosine * np.cos(wave))
        acts = np.append(f, 0.0) - [friction, lost, 0]
        speed = speed + step * np.linalg.solve(M, acts - C @ speed - K @ place)
        place = place + step * speed
        wanted.append(place)
    assert np.abs(np.array(read) - wanted).max() < 1e-3 * np.ptp(wanted)


def test_mujoco_has_a_lag_in_each_drive() -> None:
    lags = ActuatorLag(3e-3, drive="F1"), ActuatorLag(2e-3, drive="F2")
    exported = mjcf(AXIS.with_effect(*lags), TRUE)
    assert [exported.text.count(f'dynprm="{lag.seconds}"') for lag in lags] == [1, 1]
    assert not any("ActuatorLag" in loss for loss in exported.losses)


def test_mujoco_has_a_motor_for_each_drive() -> None:
    model = mujoco.MjModel.from_xml_string(mjcf(COMMANDED, TRUE).text)
    data = mujoco.MjData(model)
    places = [model.joint(name).qposadr[0] for name in ("left", "right", "beam")]
    assert "ctrl[0] is F1, ctrl[1] is u2" in mjcf(COMMANDED, TRUE).text
    for x, v, forces in samples():
        data.qpos[places], data.qvel[places] = x, v
        data.ctrl[:2] = forces[0], forces[1] / -2.5
        mujoco.mj_forward(model, data)
        wanted = by_hand(x, v, forces)
        np.testing.assert_allclose(data.qacc[places], wanted, rtol=1e-6, atol=1e-6 * np.abs(wanted).max())


def test_what_cannot_be_exported_is_reported() -> None:
    with pytest.raises(SettingError, match=r"axis 'gantry' has 2 drives"):
        feedforward(AXIS)


def test_a_node_between_springs_balances_in_c_and_is_refused_by_mujoco(tmp_path: Path) -> None:
    motor, load, node = Body("motor", mass="M1"), Body("load", mass="M2"), Body("node", mass=0.0)
    springs = (
        Spring("first", Between(first=motor, second=node), stiffness="K1"),
        Spring("second", Between(first=node, second=load), stiffness="K2"),
    )
    sensors = (Position("q", motor), Position("n", node))
    series = Axis("series", (motor, load, node, *springs), Drive("F", motor), sensors)
    values = {"M1": 1.0, "M2": 2.0, "K1": 10.0, "K2": 20.0}
    exported = c_source(derive(series), values)
    code = Compiled.of(exported, "series", tmp_path)
    x = np.array([0.3, -0.1, 0.5, 0.2])
    dx = code.function("derivative", code.parameters(values), x, 3.0, shape=(4,))
    pull = 10 * 20 / 30 * 0.4  # both springs in series, stretched by 0.4
    np.testing.assert_allclose(dx, [0.5, 0.2, 3.0 - pull, pull / 2])
    # at the node K1 (n - 0.3) = K2 (-0.1 - n)
    np.testing.assert_allclose(code.function("sensors", x, dx, shape=(2,)), [0.3, (3.0 - 2.0) / 30])
    assert "n: it reads a body without mass, by the stiffnesses in series_values." in exported.losses
    with pytest.raises(SettingError, match=r"MuJoCo has no bodies without mass \(node\)"):
        mjcf(series, values)
    damped = replace(series, elements=(*series.elements, ViscousFriction(node, "Fn")))
    with pytest.raises(SettingError, match=r"\(node\) that carry more than springs"):
        c_source(damped, values | {"Fn": 1.0})
