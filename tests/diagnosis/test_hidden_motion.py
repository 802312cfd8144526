"""Hidden motion, step by step, against an integrator of scipy."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import scipy

from symid.arrays import FloatArray
from symid.axis import CoulombFriction, LoadDependentFriction, StiffnessNonlinearity, load_axis
from symid.data import Log
from symid.diagnosis.effects import LIBRARY, Placed, effects_of
from symid.diagnosis.effects.load_dependent_friction import LoadDependentFrictionEffect
from symid.diagnosis.effects.presliding_friction import dahl_state
from symid.diagnosis.fitting.acting_forces import law_to_integrate
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.gauss_newton import fitted
from symid.diagnosis.fitting.hidden_starts import of_grid
from symid.diagnosis.fitting.start import fitted_axis
from symid.diagnosis.fitting.state import first_state, with_effects
from symid.diagnosis.prediction.hidden_equation import equation_of
from symid.diagnosis.prediction.hidden_motion import (
    Pointwise,
    _Driven,
    _stepped,
    acts_on_hidden,
)
from symid.diagnosis.prediction.prediction import prediction_of
from symid.diagnosis.prediction.record import record_of
from symid.simulation import Cascade, forward_dynamics, plant_of, simulate, trapezoids

MASS, DAMPING, STIFFNESS = 2.0, 3.0, 4000.0
STEP, N = 2e-4, 8000
TIME = np.arange(N) * STEP
PUSH = 60 * np.sin(2 * np.pi * 3 * TIME) + 25 * np.sin(2 * np.pi * 7.3 * TIME)
LOAD, LOAD_BY_PLACE = 30 * np.cos(2 * np.pi * 5 * TIME), 2000.0


def stepped(law: Pointwise) -> tuple[FloatArray, FloatArray]:
    """Motion and force of a mass on a spring to the ground under a push, with one law more."""
    still = np.zeros(N)
    states, observed, (force,) = _stepped(
        equation_of([MASS], DAMPING, STIFFNESS, STEP),
        _Driven(
            np.zeros(N, dtype=np.intp),
            np.roll(PUSH, 1),
            PUSH,
            LOAD,
            np.array([[LOAD_BY_PLACE, 0.0]]),
            still,
            still,
            still,
            still,
        ),
        np.array([[0.0, 1.0, 1.0]]),
        np.zeros((1, 1)),
        [law],
    )
    np.testing.assert_array_equal(observed, states)
    return states, force


def integrated(force: Callable[[float, float, float], float]) -> FloatArray:
    """The same by a Runge-Kutta method of order 8."""

    def rate(t: float, y: FloatArray) -> list[float]:
        push = 60 * np.sin(2 * np.pi * 3 * t) + 25 * np.sin(2 * np.pi * 7.3 * t)
        return [y[1], (push - STIFFNESS * y[0] - DAMPING * y[1] - force(t, y[0], y[1])) / MASS]

    found = scipy.integrate.solve_ivp(
        rate, (0, TIME[-1]), [0.0, 0.0], method="DOP853", t_eval=TIME, rtol=1e-9, atol=1e-12, max_step=1e-3
    )
    return np.asarray(found.y[0])


@pytest.mark.parametrize(
    ("expression", "values", "force"),
    [
        ("number*q**3", {"number": 2e7}, lambda t, q, v: 2e7 * q**3),
        ("number*v*np.abs(v)", {"number": 40.0}, lambda t, q, v: 40 * v * abs(v)),
        ("number*np.sin(q/speed)", {"number": 9.0, "speed": 3e-3}, lambda t, q, v: 9 * np.sin(q / 3e-3)),
        (
            "number*v*np.exp(-(v/speed)**2)",
            {"number": 30.0, "speed": 0.1},
            lambda t, q, v: 30 * v * np.exp(-((v / 0.1) ** 2)),
        ),
    ],
    ids=["cubic", "drag", "cogging", "stribeck"],
)
def test_smooth_forces_are_integrated(expression, values, force):
    states, _ = stepped(Pointwise(expression, values))
    expected = integrated(force)
    assert np.abs(states - expected).max() < 2e-4 * np.abs(expected).max()


def test_a_factor_follows_the_time():
    course = np.exp(-TIME / 0.5)
    states, _ = stepped(Pointwise("number*v*_course", {"number": 100.0}, course))
    expected = integrated(lambda t, q, v: 100 * v * np.exp(-t / 0.5))
    assert np.abs(states - expected).max() < 2e-4 * np.abs(expected).max()


def test_dry_friction_holds_and_lets_go():
    level = 20.0
    states, force = stepped(Pointwise("number", {"number": level}, dry=True))
    expected = integrated(lambda t, q, v: level * np.tanh(v / 2e-5))
    assert np.abs(states - expected).max() < 5e-3 * np.abs(expected).max()
    assert np.abs(force).max() <= level
    held = np.abs(force[1:-1]) < 0.99 * level
    assert 0.005 < held.mean() < 0.5, "it rests at its reversals and moves in between"
    speed = np.abs(np.gradient(states, STEP))
    assert speed[1:-1][held].max() < 0.05 * speed.max()


def test_the_state_of_presliding_friction_is_that_of_the_course():
    states, force = stepped(Pointwise("number*_z", {"number": 20.0}, reach=2e-3))
    known = 20 * dahl_state(states, 2e-3)
    assert np.abs(force - known).max() < 0.2, "Heun's rule evaluates the force at the predicted place"


def test_a_level_that_varies_does_not_fall_below_zero():
    _, force = stepped(Pointwise("np.maximum(number*q, 0)", {"number": 1e3}, dry=True))
    states, _ = stepped(Pointwise("np.maximum(number*q, 0)", {"number": 1e3}, dry=True))
    below = states[1:-1] < -1e-4
    assert np.abs(force[1:-1][below]).max() < 0.2
    assert np.abs(force).max() > 5


def test_friction_by_the_load_follows_the_drive_force():
    states, force = stepped(Pointwise("number*np.abs(_load)", {"number": 0.3}, dry=True))

    def by_load(t: float, q: float, v: float) -> float:
        return 0.3 * abs(30 * np.cos(2 * np.pi * 5 * t) + LOAD_BY_PLACE * q) * np.tanh(v / 2e-5)

    expected = integrated(by_load)
    assert np.abs(states - expected).max() < 5e-3 * np.abs(expected).max()
    assert np.abs(force).max() > 10


@pytest.mark.parametrize(
    ("name", "acts"),
    [("Ms", True), ("Fvs", True), ("Ks", True), ("Mm", True), ("Fvm", False), ("Fsm", False)],
)
def test_what_the_drive_alone_feels_does_not_act_on_hidden_motion(name: str, acts: bool) -> None:
    """The motor pushes itself off the structure: its friction is between the two, its mass is not."""
    axis = load_axis("direct_2m1s")
    values = {"Ms": 3899.0, "Fvs": 3e4, "Ks": 1e9, "Mm": 362.58, "Fvm": 90.0, "Fsm": 50.0}
    plant, other = (plant_of(axis, each) for each in (values, values | {name: 1.1 * values[name]}))
    assert acts_on_hidden(plant, other, plant.sensors["q2"][0]) is acts


STRUCTURE = next(body for body in load_axis("direct_2m1s").bodies if body.name == "structure")
HELD = {
    "coulomb": (CoulombFriction(STRUCTURE, "Fc"), effects_of(CoulombFriction)[0], 400.0),
    "by the load": (LoadDependentFriction(STRUCTURE, 0.25), LoadDependentFrictionEffect(), 0.25),
}


@pytest.mark.parametrize("kind", HELD)
def test_a_structure_that_friction_holds_is_found_from_weak_to_strong(kind: str) -> None:
    """The linear model absorbs it in mass and damping of the structure, and no search leads back from there."""
    element, effect, size = HELD[kind]
    axis = load_axis("direct_2m1s").with_signal("q2", noise=1e-8).with_signal("Fm", noise=1.0)
    values = {"Ms": 2800.0, "Fvs": 3e4, "Ks": 2.2e8, "Mm": 390.0, "Fvm": 150.0, "Fsm": 150.0}
    held = axis.with_effect(element)
    gains = Cascade("q2", position_gain=30.0, velocity_gain=5e4, integral_gain=15.0)
    moves = trapezoids([0.05, 0.1, 0.02], [0.3, 0.15], acceleration=4.0, jerk=200.0, sampling_period=1e-3)
    log = simulate(held, values | ({"Fc": size} if kind == "coulomb" else {}), moves, gains).log
    # a force that is held acts half a sample late
    record = record_of(forward_dynamics(axis), log, None, {"Fm": -0.5e-3})
    nominal = {name: value * (1.1 if name == "Ks" else 0.95) for name, value in values.items()}
    state, weighting = first_state(record, nominal)
    plain = fitted_axis(state, weighting)
    starts = of_grid(plain, Fit(state, weighting), [effect])
    fits = [fitted(best, start.weighting, 12) for start in starts if (best := start.best_state()) is not None]
    found = min(fits, key=lambda fit: fit.mean_square)
    assert found.state.placed[-1].amplitudes[0] == pytest.approx(size, rel=0.05)
    assert found.mean_square < 0.2 * plain.mean_square
    assert found.parameters["Ks"] == pytest.approx(values["Ks"], rel=0.05)


def test_a_stiffening_spring_that_rings_when_the_log_ends_begins_at_rest() -> None:
    """The motor moves as prescribed; load and drive force come from an integrator of scipy."""
    values = {"Mm": 80.0, "Fvm": 80.0, "Fsm": 0.0, "Kt": 2e6, "Ft": 300.0, "Ml": 120.0, "Fvl": 100.0}
    cubic, t, w = 3e13, np.arange(1500) / 1000, 2 * np.pi * 16

    def motor(t: FloatArray) -> FloatArray:
        """Position, velocity and acceleration of the motor: an oscillation that grows from rest."""
        x, v = 4e-5 * t**3, 12e-5 * t**2
        position, speed = x * np.sin(w * t), v * np.sin(w * t) + x * w * np.cos(w * t)
        return np.stack([position, speed, (24e-5 * t - x * w**2) * np.sin(w * t) + 2 * v * w * np.cos(w * t)])

    def spring(t: FloatArray, y: FloatArray) -> FloatArray:
        q, v, _ = motor(t)
        deflection = y[0] - q
        return values["Kt"] * deflection + cubic * deflection**3 + values["Ft"] * (y[1] - v)

    def rate(t: float, y: FloatArray) -> list[float]:
        return [y[1], -(spring(np.asarray(t), y) + values["Fvl"] * y[1]) / values["Ml"]]

    load = scipy.integrate.solve_ivp(
        rate, (0, t[-1]), [0, 0], method="DOP853", t_eval=t, rtol=1e-10, atol=1e-14
    ).y
    q, v, a = motor(t)
    force = values["Mm"] * a + values["Fvm"] * v - spring(t, load)
    noise = np.random.default_rng(1).normal(size=(2, t.size))
    log = Log("by hand", 0.0, 1e-3, {"qm": q + 1e-8 * noise[0], "Fm": force + 0.5 * noise[1]})
    state, weighting = first_state(record_of(forward_dynamics(load_axis("ballscrew_2m1s")), log), values)
    stiffens = Placed(effects_of(StiffnessNonlinearity)[0], "transmission", (), (cubic,), integrated=True)
    assert Fit(state, weighting).mean_square > 50
    assert Fit(with_effects(state, weighting, (stiffens,)), weighting).mean_square < 1.5


def test_motion_that_a_sensor_reads_is_integrated_on_demand_only() -> None:
    """A load whose encoder is compared with the model sticks as one without an encoder does."""
    dynamics, t = forward_dynamics(load_axis("ballscrew_2m1s")), np.arange(4000) / 1000
    q = 0.05 * np.sin(7 * t)
    log = Log("by hand", 0.0, 1e-3, {"qm": q, "ql": q, "Fm": 30 * np.cos(11 * t)})
    values = {"Mm": 80.0, "Fvm": 80.0, "Fsm": 40.0, "Kt": 8e6, "Ft": 900.0, "Ml": 160.0, "Fvl": 100.0}
    prediction = prediction_of(record_of(dynamics, log, 40.0), values)
    friction = Placed(effects_of(CoulombFriction)[0], "load", (), (10.0,))
    assert not law_to_integrate(prediction, friction)
    assert law_to_integrate(prediction, friction, read=True)
    assert not law_to_integrate(prediction, replace(friction, at="motor"), read=True)


def test_a_play_within_which_a_spring_is_hardly_softer_is_none() -> None:
    t = np.arange(4000) / 1000
    log = Log("by hand", 0.0, 1e-3, {"qm": 0.05 * np.sin(7 * t), "Fm": 30 * np.cos(11 * t)})
    values = {"Mm": 80.0, "Fvm": 80.0, "Fsm": 40.0, "Kt": 8e6, "Ft": 900.0, "Ml": 160.0, "Fvl": 100.0}
    prediction = prediction_of(record_of(forward_dynamics(load_axis("ballscrew_2m1s")), log, 40.0), values)
    backlash = next(effect for effect in LIBRARY if effect.name == "backlash")
    possible = [
        backlash.is_possible(prediction, Placed(backlash, "transmission", (2e-5,), (share * 8e6,)))
        for share in (-0.1, 0.08, 0.5, 1.0)
    ]
    assert possible == [False, False, True, True]
