"""A controller for each drive: against a loop with hand-written matrices, and an ODE with friction."""

from dataclasses import replace

import numpy as np
import pytest
from axes.gantry import AXIS, LEFT, NOISE, RIGHT, TRUE, matrices
from driven import called
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from symid import Acceleration, ActuatorLag, Drive, ForceConstantRipple, derive, identify
from symid.errors import SettingError
from symid.simulation import (
    Cascade,
    Controller,
    OpenLoop,
    Trajectory,
    chirp,
    plant_of,
    simulate,
    tuned_cascade,
    tuned_cascades,
)

PERIOD = 1 / 2000
SMOOTH = TRUE | {"Fs1": 0.0, "Fs2": 0.0}
KINDS = ("position", "velocity", "acceleration")
GAINS = (Cascade("q1", 20.0, 6e3, 15.0), Cascade("q2", 25.0, 7e3, 10.0, acceleration_feedforward=90.0))


def references(seconds: float = 1.0) -> tuple[Trajectory, Trajectory]:
    """Other paths for the two drives."""
    return tuple(
        chirp(low, 12.0, seconds, 1e-3, sampling_period=PERIOD, quantity="position") for low in (1.0, 2.0)
    )


def by_hand(values: dict[str, float], paths: tuple[Trajectory, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Displacements and forces of the two cascades, the motion by one matrix exponential."""
    M, C, K = matrices(values)
    A = np.zeros((8, 8))
    A[:3, 3:6] = np.eye(3)
    A[3:6, :6] = -np.linalg.solve(M, np.hstack([K, C]))
    A[3:5, 6:] = np.diag([1 / values["M1"], 1 / values["M2"]])
    step = expm(A * PERIOD)
    x, last, sums = np.zeros(8), np.zeros(2), np.zeros(2)
    motion, forces = [], []
    for k in range(paths[0].n_samples):
        for i, c in enumerate(GAINS):
            speed = (x[i] - last[i]) / PERIOD if k else 0.0
            error = paths[i].velocity[k] + c.position_gain * (paths[i].position[k] - x[i]) - speed
            sums[i] += c.integral_gain * PERIOD * error
            x[6 + i] = c.velocity_gain * (error + sums[i])
            x[6 + i] += c.acceleration_feedforward * paths[i].acceleration[k]
        motion.append(x[:3].copy())
        forces.append(x[6:].copy())
        last = x[:2].copy()
        x = step @ x
    return np.array(motion), np.array(forces)


@pytest.mark.parametrize("controllers", [GAINS, tuple(map(called, GAINS))])
def test_two_cascades_move_the_gantry_as_by_hand(controllers: tuple[Controller, ...]) -> None:
    paths = references()
    run = simulate(AXIS, SMOOTH, paths, controllers)
    motion, forces = by_hand(SMOOTH, paths)
    np.testing.assert_allclose(run.states[:, :3], motion, atol=1e-9 * np.abs(motion).max())
    np.testing.assert_allclose(run.forces, forces, atol=1e-7 * np.abs(forces).max())
    np.testing.assert_array_equal(run.log["reference"], paths[0].position)
    np.testing.assert_array_equal(run.log["reference_F2"], paths[1].position)


def test_sticking_and_slipping_under_two_forces_follow_the_ode() -> None:
    closed = simulate(AXIS, TRUE, references(), GAINS)
    again = simulate(AXIS, TRUE, references(), [OpenLoop(force) for force in closed.forces.T])
    np.testing.assert_allclose(again.states, closed.states, atol=1e-10)
    M, C, K = matrices()
    levels = np.array([TRUE["Fs1"], TRUE["Fs2"]])
    state, found = np.zeros(6), []
    for forces in closed.forces[:800]:
        found.append(state[:3])

        def slope(_: float, y: np.ndarray, forces: np.ndarray = forces) -> np.ndarray:
            force = -C @ y[3:] - K @ y[:3]
            force[:2] += forces - levels * np.tanh(y[3:5] / 1e-6)
            return np.concatenate([y[3:], force / np.diag(M)])

        state = solve_ivp(slope, (0, PERIOD), state, "LSODA", rtol=1e-6, atol=1e-12).y[:, -1]
    moved = np.abs(closed.states[:800, :3]).max()
    np.testing.assert_allclose(closed.states[:800, :3], found, atol=2e-3 * moved)


def test_what_is_in_the_loop_between_samples_too_is_that_of_single_samples() -> None:
    late = replace(AXIS, sensors=(*AXIS.sensors, Acceleration("ddqb", AXIS.bodies[2])))
    late = late.with_signal("q1", noise=1e-7, delay=1.3 * PERIOD).with_signal("q2", noise=1e-7, delay=PERIOD)
    runs = [simulate(late, SMOOTH, references(0.3), given) for given in (GAINS, tuple(map(called, GAINS)))]
    for signal, values in runs[0].log.signals.items():
        np.testing.assert_allclose(values, runs[1].log[signal], atol=1e-8 * np.abs(values).max())


def test_tuned_cascades_share_the_mass() -> None:
    plant = plant_of(AXIS, SMOOTH)
    one, two = tuned_cascades(plant, ("q1", "q2"), 20.0)
    whole = (one.velocity_gain + two.velocity_gain) / (2 * np.pi * 20.0)
    damped = np.hypot(sum(np.diag(matrices(SMOOTH)[0])), (TRUE["Fv1"] + TRUE["Fv2"]) / (2 * np.pi * 0.2))
    assert whole == pytest.approx(damped, rel=0.05)
    tandem = plant_of(replace(AXIS, drive=(AXIS.drives[0], replace(AXIS.drives[1], at=LEFT))), SMOOTH)
    gains = [cascade.velocity_gain for cascade in tuned_cascades(tandem, ("q1", "q1"))]
    assert gains[0] == pytest.approx(gains[1]) == pytest.approx(np.pi * 20.0 * damped, rel=0.05)
    with pytest.raises(SettingError, match="2 drives and 1 signals"):
        tuned_cascade(plant, "q1")


def test_an_imperfection_of_the_drive_is_in_each() -> None:
    lagging = AXIS.with_effect(ActuatorLag(1e-3))
    sent = np.ones(20)
    run = simulate(lagging, SMOOTH, references(20 * PERIOD), [OpenLoop(sent), OpenLoop(-sent)])
    assert run.forces[:, 0] == pytest.approx(-run.forces[:, 1])
    assert run.log["F2"] == pytest.approx(-1.0)


def test_a_ripple_of_a_force_constant_is_of_its_drive() -> None:
    """The current of the right motor has a force constant, of which a part varies along the motor's own stroke."""
    ripple = ForceConstantRipple(0.2, -0.1, pitch=0.004, drive="i2")
    driven = replace(AXIS, drive=(AXIS.drives[0], Drive("i2", RIGHT, gain="Kt", unit="A")))
    t = PERIOD * np.arange(401)
    first, current = 60.0 * np.sin(20.0 * t), 4.0 * np.cos(31.0 * t)
    sent = [OpenLoop(first), OpenLoop(current)]
    run = simulate(driven.with_effect(ripple), SMOOTH | {"Kt": 25.0}, references(0.2), sent, steps=4)
    M, C, K = matrices(SMOOTH)

    def slope(now: float, y: np.ndarray) -> np.ndarray:
        k, wave = int(now / PERIOD + 1e-9), 2 * np.pi * y[1] / 0.004
        acting = 25.0 * current[k] * (1.0 - 0.2 * np.sin(wave) + 0.1 * np.cos(wave))
        return np.concatenate([y[3:], np.linalg.solve(M, [first[k], acting, 0.0] - C @ y[3:] - K @ y[:3])])

    found = solve_ivp(slope, (0, t[-1]), np.zeros(6), t_eval=t, rtol=1e-8, atol=1e-12, max_step=PERIOD / 2).y
    plain = simulate(driven, SMOOTH | {"Kt": 25.0}, references(0.2), sent).states[:, :3]
    np.testing.assert_allclose(run.states[:, :3], found[:3].T, atol=1e-3 * np.abs(plain - found[:3].T).max())


def test_each_drive_needs_a_controller_and_a_trajectory() -> None:
    with pytest.raises(SettingError, match="has 2 drives and 1 controllers: give one for each drive"):
        simulate(AXIS, TRUE, references()[0], GAINS[0])
    with pytest.raises(SettingError, match="has 2 drives and 3 trajectories"):
        simulate(AXIS, TRUE, (*references(), references()[0]), GAINS)
    with pytest.raises(SettingError, match="differ in length"):
        simulate(AXIS, TRUE, (references()[0], references(2.0)[0]), GAINS)


def test_a_simulated_gantry_is_identified() -> None:
    axis = AXIS
    for signal, noise in NOISE.items():
        axis = axis.with_signal(signal, noise=noise)
    axis = replace(axis, drive=tuple(replace(drive, held=True) for drive in axis.drives))
    stroke = chirp(0.5, 60.0, 5.0, 0.2, sampling_period=PERIOD, quantity="velocity")
    turn = chirp(3.0, 90.0, 5.0, 0.01, sampling_period=PERIOD, quantity="velocity")
    paths = [
        Trajectory(*(getattr(stroke, x) + sign * getattr(turn, x) for x in KINDS), PERIOD, "turning")
        for sign in (1, -1)
    ]
    log = simulate(axis, TRUE, paths, tuned_cascades(plant_of(axis, TRUE), ("q1", "q2"), 60.0)).log
    found = identify(derive(axis, ("q1", "q2", "qb")), log)
    assert found.status == "ok"
    assert found.physical_parameters == pytest.approx(TRUE, rel=0.03)
