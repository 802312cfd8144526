"""Tuned cascades: stability and modulus margin of the sampled loop around matrices written by hand."""

import math

import numpy as np
import pytest
from axes.gantry import AXIS as GANTRY, TRUE, matrices
from scipy.linalg import block_diag, expm

from symid import Axis, Between, Body, Drive, Position, Spring, ViscousFriction
from symid.errors import SettingError
from symid.simulation import Cascade, plant_of, tuned_cascades

PERIOD = 5e-4
Matrices = tuple[np.ndarray, np.ndarray, np.ndarray]


def screw(
    lead: float, J: float, M: float, K: float, Fv: float, Ft: float, Kb: float
) -> tuple[Axis, Matrices]:
    """A motor that drives a table through a screw of `lead` m/rad, with bellows Kb between table and ground."""
    motor, table = Body("motor", inertia="J"), Body("table", mass="M")
    nut = Spring("nut", Between(first=motor, second=table, ratio=lead), stiffness="K")
    friction = ViscousFriction(motor, "Fv"), ViscousFriction(table, "Ft")
    bellows = Spring("bellows", table, stiffness="Kb")
    axis = Axis("screw", (motor, table, nut, bellows, *friction), Drive("T", motor), (Position("q", motor),))
    stiffness = K * np.array([[lead**2, -lead], [-lead, 1.0]]) + np.diag([0.0, Kb])
    return axis, (np.diag([J, M]), np.diag([Fv, Ft]), stiffness)


def rotor(J: float, Fv: float, K: float) -> tuple[Axis, Matrices]:
    """A rotor with a torsion spring to the ground."""
    body = Body("rotor", inertia="J")
    parts = (body, ViscousFriction(body, "Fv"), Spring("torsion", body, stiffness="K"))
    return Axis("rotor", parts, Drive("T", body), (Position("q", body),)), tuple(
        np.array([[value]]) for value in (J, Fv, K)
    )


def loop(controllers: tuple[Cascade, ...], plant: Matrices, driven: np.ndarray) -> tuple[float, float]:
    """Largest modulus of the poles, and least distance of the return difference from singular."""
    M, C, K = plant
    n, m = driven.shape
    zero = np.zeros((n, n))
    speed = np.block([[zero, np.eye(n)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    push = np.vstack([0 * driven, np.linalg.solve(M, driven)])
    held = expm(np.block([[speed, push], [np.zeros((m, 2 * n + m))]]) * PERIOD)
    A, B, read = held[: 2 * n, : 2 * n], held[: 2 * n, 2 * n :], np.hstack([driven.T, 0 * driven.T])
    gains = [(c.velocity_gain, c.position_gain, c.integral_gain) for c in controllers]
    Kv, Kp, Ki = (np.diag(one) for one in zip(*gains, strict=True))
    # States: motion, last readings and integrals of the velocity error.
    error = np.hstack([-(Kp + np.eye(m) / PERIOD) @ read, np.eye(m) / PERIOD, np.zeros((m, m))])
    integral = np.hstack([np.zeros((m, 2 * n + m)), np.eye(m)]) + PERIOD * Ki @ error
    step = block_diag(A, np.zeros((2 * m, 2 * m)))
    step[: 2 * n] += B @ Kv @ (error + integral)
    step[2 * n : 2 * n + m, : 2 * n], step[2 * n + m :] = read, integral
    distances = []
    for z in np.exp(1j * np.geomspace(1e-4, math.pi, 1000)):
        rate = (1 - 1 / z) / PERIOD
        law = Kv @ (np.eye(m) + Ki / rate) @ (Kp + rate * np.eye(m))
        around = np.eye(m) + law @ read @ np.linalg.solve(z * np.eye(2 * n) - A, B)
        distances.append(np.linalg.svd(around, compute_uv=False)[-1])
    return float(np.abs(np.linalg.eigvals(step)).max()), min(distances)


def is_robust(axis: Axis, values: dict[str, float], plant: Matrices) -> bool:
    """Whether the loop of 20 Hz is stable with a modulus margin above 0.4, each drive at the body that is read."""
    controllers = tuned_cascades(plant_of(axis, values), axis.controlled_signals, 20.0)
    pole, margin = loop(controllers, plant, np.eye(len(plant[0]))[:, : len(controllers)])
    return pole < 1 and margin > 0.4


@pytest.mark.parametrize("lead", [1e-4, 0.002 / (2 * math.pi), 0.005 / (2 * math.pi)])
@pytest.mark.parametrize("friction", [0.0, 1e-3, 0.01, 0.1])
@pytest.mark.parametrize("bellows", [0.0, 2e4, 2e6])
def test_a_screw_is_stable_beside_any_friction_and_bellows(
    lead: float, friction: float, bellows: float
) -> None:
    values = {"J": 1e-4, "M": 80.0, "K": 1e8, "Fv": friction, "Ft": 900.0, "Kb": bellows}
    axis, plant = screw(lead, **values)
    assert is_robust(axis, values, plant)


@pytest.mark.parametrize("friction", [0.002, 0.1, 1.0, 50.0])
@pytest.mark.parametrize("spring", [-0.1, 0.0, 0.01, 0.079, 0.5, 10.0, 1e4])
def test_a_rotor_is_stable_beside_any_friction_and_spring(friction: float, spring: float) -> None:
    values = {"J": 0.05, "Fv": friction, "K": spring}
    axis, plant = rotor(**values)
    assert is_robust(axis, values, plant)


@pytest.mark.parametrize("friction", [0.0, 1.0, 30.0, 1000.0])
def test_a_gantry_is_stable_beside_any_friction(friction: float) -> None:
    values = TRUE | {"Fs1": 0.0, "Fs2": 0.0} | {name: friction * TRUE[name] for name in ("Fv1", "Fv2")}
    assert is_robust(GANTRY, values, matrices(values))


def test_friction_and_springs_that_are_less_than_the_mass_count_in_it() -> None:
    values = {"J": 0.05, "Fv": 0.05, "K": 0.02}
    axis, _ = rotor(**values)
    (controller,) = tuned_cascades(plant_of(axis, values), ("q",), 20.0)
    rate = 2 * math.pi * 0.2
    felt = math.hypot(0.05 - 0.02 / rate**2, 0.05 / rate)
    assert controller.velocity_gain == pytest.approx(2 * math.pi * 20.0 * felt)


def test_a_mass_beyond_all_machines_is_refused_without_warnings() -> None:
    table = Body("table", mass="M")
    axis = Axis("slide", (table,), Drive("F", table), (Position("q", table),))
    for mass in (1e101, 1e308):
        with pytest.raises(SettingError, match=r"a drive of this axis moves .*: give masses below 1e\+100"):
            tuned_cascades(plant_of(axis, {"M": mass}), ("q",))
