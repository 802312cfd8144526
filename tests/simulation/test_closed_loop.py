"""Closed loops: against an independent integration, controllers' limits, imperfections of signals, round trips."""

import math

import numpy as np
import pytest
from scipy.linalg import expm

from symid import (
    Axis,
    Body,
    Drive,
    Geared,
    Position,
    Preparation,
    Velocity,
    ViscousFriction,
    identify,
    load_axis,
    load_generated,
)
from symid.errors import SettingError
from symid.simulation import (
    Cascade,
    OpenLoop,
    Trajectory,
    plant_of,
    simulate,
    steps,
    trapezoids,
    tuned_cascade,
)
from symid.units import Unit

RATE = 4000.0
RIGID = {"M": 100.0, "Fv": 80.0, "Fs": 40.0}
EMPS = {"M": 95.1, "Fv": 203.5, "Fc": 20.4, "OF": -3.16}


def moves(rate: float = RATE) -> Trajectory:
    return trapezoids([0.2], [0.1, 0.4], acceleration=4.0, jerk=200.0, dwell=0.1, sampling_period=1 / rate)


def test_the_closed_loop_is_that_of_matrices() -> None:
    """Linear axis and cascade as one discrete system, written by hand: z = (q, v, integral, last position)."""
    M, Fv = 100.0, 80.0
    gains = Cascade("q", position_gain=25.0, velocity_gain=8000.0, integral_gain=20.0)
    reference = moves()
    period = reference.sampling_period
    whole = expm(np.array([[0, 1, 0], [0, -Fv / M, 1 / M], [0, 0, 0]]) * period)
    q = v = integral = last = 0.0
    expected = []
    for k in range(reference.n_samples):
        expected.append(q)
        speed = (q - last) / period if k else 0.0
        error = reference.velocity[k] + 25.0 * (reference.position[k] - q) - speed
        integral += 20.0 * period * error
        force = 8000.0 * (error + integral)
        last = q
        q, v, _ = whole @ [q, v, force]
    run = simulate(load_axis("rigid_1m"), {"M": M, "Fv": Fv, "Fs": 0.0}, reference, gains)
    assert np.abs(run.log["q"] - expected).max() < 1e-13


def test_a_tachometer_closes_the_velocity_loop() -> None:
    """Wheel on a free hub, by hand: their relative motion has the reduced inertia, and torques are held."""
    hub, wheel = Body("hub", inertia="Jh"), Body("wheel", inertia="Jw", on=Body("hub", inertia="Jh"))
    sensors = (Velocity("w", wheel), Velocity("gyro", hub))
    axis = Axis("wheel", (hub, wheel, ViscousFriction(wheel, "Fv")), Drive("T", wheel), sensors)
    values = {"Jh": 3.0, "Jw": 0.02, "Fv": 1e-3}
    reference = trapezoids([20.0], [10.0], acceleration=20.0, jerk=2e3, dwell=0.1, sampling_period=1e-3)
    loop = tuned_cascade(plant_of(axis, values), "w", 5.0)
    run = simulate(axis, values, reference, loop, start="equilibrium")
    inertia = 0.02 * 3.0 / 3.02
    kept, speed, integral, expected = math.exp(-1e-3 / inertia * 1e-3), 0.0, 0.0, []
    for wanted in reference.velocity:
        expected.append(speed)
        integral += loop.integral_gain * 1e-3 * (wanted - speed)
        torque = loop.velocity_gain * (wanted - speed + integral)
        speed = kept * speed + (1 - kept) * torque / 1e-3
    assert loop.velocity_gain == pytest.approx(inertia * math.tau * 5.0, rel=0.02)
    assert np.abs(run.log["w"] - expected).max() < 1e-11
    assert np.abs(3.02 * run.log["gyro"] + 0.02 * run.log["w"]).max() < 1e-11
    assert axis.reference_units == (Unit.of("rad"),)


@pytest.mark.parametrize(
    ("axis", "parameters"),
    [
        ("rigid_1m", RIGID),
        ("emps", EMPS),
        ("emps_asymmetric", {"M": 95.0, "Fvp": 166.0, "Fcp": 20.0, "Fvn": 240.0, "Fcn": 21.0}),
    ],
)
def test_a_simulated_log_gives_its_parameters_back(axis: str, parameters: dict[str, float]) -> None:
    declared = load_axis(axis)
    controller = tuned_cascade(plant_of(declared, parameters), "q")
    run = simulate(declared, parameters, moves(), controller, steps=4 if axis == "emps_asymmetric" else 1)
    held = Preparation(late={"F": -0.5 / RATE})
    found = identify(load_generated(axis), run.log, preparation=held)
    for name, value in found.physical_parameters.items():
        assert value == pytest.approx(parameters[name], rel=2e-3), name


def test_the_force_stays_within_its_limit_and_the_integral_does_not_wind_up() -> None:
    axis = load_axis("rigid_1m")
    free = tuned_cascade(plant_of(axis, RIGID), "q")
    limited = tuned_cascade(plant_of(axis, RIGID), "q", force_limit=300.0)
    reference = steps([0.0, 0.05], 1.0, sampling_period=1 / RATE)
    runs = [simulate(axis, RIGID, reference, controller) for controller in (free, limited)]
    assert np.abs(runs[0].forces).max() > 1000
    assert np.abs(runs[1].forces).max() == 300.0
    overshoot = runs[1].log["q"].max() - 0.05
    assert overshoot < 0.02
    assert runs[1].log["q"][-1] == pytest.approx(0.05, abs=1e-3)


def test_the_logged_force_drives_the_axis_as_the_controller_did() -> None:
    axis = load_axis("rigid_1m")
    closed = simulate(axis, RIGID, moves(), tuned_cascade(plant_of(axis, RIGID), "q"))
    again = simulate(axis, RIGID, moves(), OpenLoop(closed.log["F"]))
    assert np.abs(again.log["q"] - closed.log["q"]).max() < 1e-12


def test_signals_are_as_imperfect_as_declared() -> None:
    axis = load_axis("direct_2m1s").with_signal("q2", noise=0.0, resolution=1e-6, delay=2 / RATE)
    axis = axis.with_signal("ddq1", noise=0.01).with_signal("Fm", noise=2.0)
    values = {"Ms": 900.0, "Fvs": 3000.0, "Ks": 4e7, "Mm": 200.0, "Fvm": 150.0, "Fsm": 80.0}
    controller = tuned_cascade(plant_of(axis, values), "q2", 10.0)
    run = simulate(axis, values, moves(), controller, seed=5)
    exact = run.states[:, 1] - run.states[:, 0]
    assert np.abs(run.log["q2"][2:] - exact[:-2]).max() <= 0.5001e-6
    assert np.allclose(np.round(run.log["q2"] / 1e-6), run.log["q2"] / 1e-6)
    assert np.std(run.log["ddq1"] - run.accelerations[:, 0]) == pytest.approx(0.01, rel=0.05)
    assert np.std(run.log["Fm"] - run.forces) == pytest.approx(2.0, rel=0.05)
    again = simulate(axis, values, moves(), controller, seed=5)
    assert np.array_equal(again.log["ddq1"], run.log["ddq1"])


def test_a_slower_log_holds_every_so_many_samples() -> None:
    axis = load_axis("rigid_1m")
    controller = tuned_cascade(plant_of(axis, RIGID), "q")
    fast, slow = (simulate(axis, RIGID, moves(), controller, frequency_hz=f) for f in (RATE, RATE / 16))
    assert slow.log.sampling_frequency == pytest.approx(RATE / 16)
    assert np.array_equal(slow.log["q"], fast.log["q"][::16])


def test_mistakes_are_refused() -> None:
    axis = load_axis("rigid_1m")
    controller = tuned_cascade(plant_of(axis, RIGID), "q")
    with pytest.raises(SettingError, match="multiple"):
        simulate(axis, RIGID, moves(), controller, frequency_hz=3000.0)
    with pytest.raises(SettingError, match="lack Fv, Fs"):
        simulate(axis, {"M": 1.0}, moves(), controller)
    with pytest.raises(SettingError, match="positive"):
        simulate(axis, {**RIGID, "M": -1.0}, moves(), controller)
    with pytest.raises(SettingError, match="runs away"):
        simulate(axis, RIGID, moves(), Cascade("q", 25.0, -1e6, 20.0))
    with pytest.raises(SettingError, match="'qm', which is not a sensor of this axis: use q"):
        simulate(axis, RIGID, moves(), Cascade("qm", 25.0, 8000.0, 20.0))
    with pytest.raises(SettingError, match="not a position or velocity sensor"):
        tuned_cascade(plant_of(axis, RIGID), "F")
    with pytest.raises(SettingError, match="Kpp is 25, and 'w' reads a velocity"):
        Cascade("w", 25.0, 8000.0, 20.0, reads_velocity=True)


def test_imperfections_do_not_make_generated_modules_stale() -> None:
    axis: Axis = load_axis("emps")
    assert axis.with_signal("q", noise=1e-6, resolution=5e-8).signature == axis.signature
    assert math.isinf(tuned_cascade(plant_of(axis, EMPS), "q").force_limit)


@pytest.mark.parametrize("limit", [math.inf, 0.3])
def test_a_sensor_behind_a_gear_that_turns_round_is_followed(limit: float) -> None:
    motor = Body("motor", inertia=0.0004)
    arm = Body("arm", inertia="J", geared=Geared(to=motor, ratio=-0.0125))
    axis = Axis("reversed", (motor, arm), Drive("tau", motor), (Position("q", arm),))
    values = {"J": 4.0}
    controller = tuned_cascade(plant_of(axis, values), "q", force_limit=limit)
    path = trapezoids(0.02, 0.5, acceleration=5.0, jerk=500.0, dwell=0.4, sampling_period=1e-3)
    read = simulate(axis, values, path, controller).log["q"]
    assert np.abs(read - path.position[: len(read)])[-100:].max() < 1e-4
