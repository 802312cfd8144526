"""Blocks of samples against single ones, recursions against their definition, readings against closed forms."""

import math
from collections.abc import Mapping

import numpy as np
import pytest
from driven import called, driven
from scipy.linalg import expm

from symid import Acceleration, Axis, Body, CoulombFriction, Drive, Position, Velocity, load_axis
from symid.arrays import FloatArray
from symid.simulation import (
    Cascade,
    Command,
    Controller,
    LinearLaw,
    OpenLoop,
    Trajectory,
    plant_of,
    simulate,
    trapezoids,
    tuned_cascade,
)

PERIOD = 1 / 4000


RIGID = {"M": 100.0, "Fv": 80.0, "Fs": 40.0}


DIRECT = {"Ms": 900.0, "Fvs": 3000.0, "Ks": 4e7, "Mm": 200.0, "Fvm": 150.0, "Fsm": 80.0}


AXES = {
    "rigid_1m": (RIGID, "q", 20.0),
    "direct_2m1s": (DIRECT, "q2", 10.0),
    "ballscrew_2m1s": (
        {"Mm": 20.0, "Fvm": 30.0, "Fsm": 15.0, "Kt": 2e6, "Ft": 100.0, "Ml": 50.0, "Fvl": 40.0},
        "qm",
        15.0,
    ),
    "direct_3m2s": ({**DIRECT, "Kl": 1e6, "Fl": 200.0, "Ml": 40.0}, "q2", 10.0),
}


def moves(period: float = PERIOD) -> Trajectory:
    return trapezoids([0.05], [0.1, 0.4], acceleration=4.0, jerk=200.0, dwell=0.1, sampling_period=period)


@pytest.mark.parametrize("name", AXES)
@pytest.mark.parametrize(
    ("imperfections", "limit"),
    [({}, math.inf), ({}, 200.0), ({"noise": 2e-7}, math.inf), ({"delay": 2.5 * PERIOD}, math.inf)],
    ids=["clean", "limit", "noise", "delay"],
)
def test_blocks_equal_single_samples(name: str, imperfections: dict[str, float], limit: float) -> None:
    values, signal, bandwidth = AXES[name]
    axis = load_axis(name).with_signal(signal, **{"noise": 0.0, **imperfections})
    cascade = tuned_cascade(plant_of(axis, values), signal, bandwidth / 2, limit)
    blocks, single = (simulate(axis, values, moves(), c, seed=2) for c in (cascade, called(cascade)))
    n = blocks.states.shape[1] // 2
    for part in (slice(0, n), slice(n, 2 * n)):
        size = np.abs(single.states[:, part]).max()
        assert np.abs(blocks.states[:, part] - single.states[:, part]).max() < 2e-12 * size
    assert np.abs(blocks.forces - single.forces).max() < 1e-10 * np.abs(single.forces).max()
    assert np.abs(blocks.log[signal] - single.log[signal]).max() < 1e-13
    if limit < math.inf:
        assert np.abs(blocks.forces).max() == limit


@pytest.mark.parametrize("name", ["rigid_1m", "direct_2m1s"])
def test_a_run_is_that_of_its_forces_and_the_controller_by_turns(name: str) -> None:
    values, signal, bandwidth = AXES[name]
    axis, path = load_axis(name), moves()
    plant = plant_of(axis, values)
    cascade = tuned_cascade(plant, signal, bandwidth)
    run = simulate(axis, values, path, cascade)
    assert np.abs(run.states - driven(axis, values, run.forces, PERIOD)[:-1]).max() < 1e-12
    memory, row = cascade.start, plant.sensors[signal].row
    for k in range(path.n_samples):
        command = Command(k, path.position[k], path.velocity[k], path.acceleration[k])
        measured = {signal: float(row @ run.states[k, : row.size])}
        force, memory = cascade.force(command, measured, memory, PERIOD)
        assert run.forces[k] == pytest.approx(force, rel=1e-12, abs=1e-6)


def test_a_quantised_reading_is_what_the_controller_acts_on() -> None:
    """The forces follow from the log's readings by the cascade's law, and the states from the forces."""
    axis = load_axis("rigid_1m").with_signal("q", noise=1e-7, resolution=1e-6)
    cascade, path = tuned_cascade(plant_of(axis, RIGID), "q"), moves()
    run = simulate(axis, RIGID, path, cascade, seed=4)
    memory = cascade.start
    for k, reading in enumerate(run.log["q"]):
        assert reading == pytest.approx(1e-6 * round(reading / 1e-6), abs=1e-18)
        command = Command(k, path.position[k], path.velocity[k], path.acceleration[k])
        force, memory = cascade.force(command, {"q": float(reading)}, memory, PERIOD)
        assert run.forces[k] == pytest.approx(force, abs=1e-6)
    assert run.states == pytest.approx(driven(axis, RIGID, run.forces, PERIOD)[:-1], abs=1e-11)
    assert np.abs(run.log["q"] - run.states[:, 0]).max() < 0.5e-6 + 6e-7


def test_a_delay_within_a_sample_is_that_of_the_parabola() -> None:
    """Friction alone: pushed by F for n samples, then braked: q, v and the acceleration in closed form."""
    M, Fs, F, n, delay = 2.0, 3.0, 11.0, 40, 1.3 * PERIOD
    body = Body("slide", mass="M")
    sensors = (Position("q", body), Velocity("v", body), Acceleration("a", body))
    axis = Axis("braked", (body, CoulombFriction(body, "Fs")), Drive("F", body), sensors)
    for signal in ("q", "v", "a"):
        axis = axis.with_signal(signal, noise=0.0, delay=delay)
    forces = np.where(np.arange(400) < n, F, 0.0)
    still = np.zeros(forces.size)
    run = simulate(
        axis, {"M": M, "Fs": Fs}, Trajectory(still, still, still, PERIOD, "rest"), OpenLoop(forces)
    )
    push, brake, end = (F - Fs) / M, Fs / M, n * PERIOD
    stop = end + push * end / brake
    time = np.maximum(run.time - delay, 0.0)
    moving, late = np.minimum(time, end), np.clip(time - end, 0.0, stop - end)
    speed = push * moving - brake * late
    assert run.log["v"] == pytest.approx(speed, abs=1e-15)
    way = push * moving**2 / 2 + push * end * late - brake * late**2 / 2
    assert run.log["q"] == pytest.approx(way, abs=1e-16)
    acceleration = np.where(time < end, push, np.where(time < stop, -brake, 0.0))
    acceleration[run.time < delay] = 0.0
    assert run.log["a"] == pytest.approx(acceleration, abs=1e-12)


@pytest.mark.parametrize("samples", [0.25, 1.0, 1.5, 20.4])
def test_a_delayed_loop_is_that_of_matrices(samples: float) -> None:
    """Mass with viscous friction under a cascade that reads the position as it was; all by hand."""
    M, Fv, delay = 100.0, 80.0, samples * PERIOD
    gains = Cascade("q", position_gain=2.0, velocity_gain=600.0, integral_gain=2.0)
    axis, path = load_axis("rigid_1m").with_signal("q", noise=0.0, delay=delay), moves()
    generator = np.array([[0, 1, 0], [0, -Fv / M, 1 / M], [0, 0, 0]])
    whole_samples = math.ceil(samples)
    whole, part = expm(generator * PERIOD), expm(generator * (whole_samples - samples) * PERIOD)
    states, integral, last = [np.zeros(3)], 0.0, 0.0
    for k in range(path.n_samples):
        then = k - whole_samples
        reading = (part @ states[then])[0] if then >= 0 else 0.0
        speed = (reading - last) / PERIOD if k else 0.0
        error = path.velocity[k] + 2.0 * (path.position[k] - reading) - speed
        integral, last = integral + 2.0 * PERIOD * error, reading
        states[k][2] = 600.0 * (error + integral)
        states.append(whole @ states[k])
    run = simulate(axis, {"M": M, "Fv": Fv, "Fs": 0.0}, path, gains)
    assert run.states == pytest.approx(np.array(states)[:-1, :2], abs=1e-12)


class Relay(Controller):
    """Full force towards the reference; counts how often it is asked."""

    def __init__(self) -> None:
        self.asked: list[int] = []

    @property
    def signals(self) -> tuple[str, ...]:
        return ("q",)

    def force(
        self, command: Command, measured: Mapping[str, float], state: FloatArray, period: float
    ) -> tuple[float, FloatArray]:
        self.asked.append(command.index)
        return 60.0 * np.sign(command.position - measured["q"]), state


def test_a_controller_of_ones_own_is_asked_once_for_each_sample() -> None:
    relay, path = Relay(), moves()
    run = simulate(load_axis("rigid_1m"), RIGID, path, relay)
    assert relay.asked == list(range(path.n_samples))
    assert set(run.forces) == {-60.0, 0.0, 60.0}
    assert run.states == pytest.approx(
        driven(load_axis("rigid_1m"), RIGID, run.forces, PERIOD)[:-1], abs=1e-13
    )


class TwoEncoders(Controller):
    """Stiffness and damping on the motor, damping of the transmission, and a filtered push; as matrices too."""

    @property
    def signals(self) -> tuple[str, ...]:
        return ("ql", "qm")

    @property
    def start(self) -> FloatArray:
        return np.array([0.0, 0.0])

    def force(
        self, command: Command, measured: Mapping[str, float], state: FloatArray, period: float
    ) -> tuple[float, FloatArray]:
        filtered, last = state
        gap = measured["ql"] - measured["qm"]
        force = 3e4 * (command.position - measured["qm"]) + 900.0 * command.velocity
        force += filtered - 200.0 * (measured["qm"] - last) / period + 5e3 * gap
        return force, np.array([0.9 * filtered + 10.0 * command.acceleration + 50.0 * gap, measured["qm"]])

    def linear(self, period: float) -> LinearLaw:
        return LinearLaw(
            A=np.array([[0.9, 0.0], [0.0, 0.0]]),
            B=np.array([[0.0, 0.0, 10.0, 50.0, -50.0], [0.0, 0.0, 0.0, 0.0, 1.0]]),
            C=np.array([1.0, 200.0 / period]),
            D=np.array([3e4, 900.0, 0.0, 5e3, -3e4 - 200.0 / period - 5e3]),
        )


@pytest.mark.parametrize("delay", [0.0, 0.4 * PERIOD, 3.0 * PERIOD])
def test_a_controller_of_ones_own_with_matrices_runs_in_blocks(delay: float) -> None:
    axis = load_axis("ballscrew_2m1s").with_signal("ql", noise=1e-7, delay=delay)
    axis = axis.with_signal("qm", noise=1e-8)
    values = AXES["ballscrew_2m1s"][0]
    runs = [simulate(axis, values, moves(), c, seed=7) for c in (TwoEncoders(), called(TwoEncoders()))]
    assert np.abs(runs[1].states[:, :2]).max() > 0.04
    assert np.abs(runs[0].states - runs[1].states).max() < 1e-11
    assert np.abs(runs[0].forces - runs[1].forces).max() < 1e-7


def test_progress_is_told_the_parts_of_a_run() -> None:
    reported: list[int] = []

    def noted(begins: range) -> list[int]:
        reported.append(len(begins))
        return list(begins)

    path = moves(PERIOD / 4)
    axis = load_axis("rigid_1m")
    shown = simulate(axis, RIGID, path, tuned_cascade(plant_of(axis, RIGID), "q"), progress=noted)
    assert reported == [math.ceil(path.n_samples / 8192)]
    assert shown.log["q"].max() == pytest.approx(0.05, rel=0.05)
