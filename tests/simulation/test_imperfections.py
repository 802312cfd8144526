"""Each imperfection beside the same equation integrated in small steps by hand."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from axes import gantry
from axes.gears_and_weights import rack_and_pinion_case

from symid import (
    ActuatorDelay,
    ActuatorLag,
    Axis,
    CoulombFriction,
    EncoderRipple,
    ForceConstantRipple,
    ForceLimit,
    FrictionDrift,
    FrictionTrend,
    GainAsymmetry,
    GainNonlinearity,
    LoadDependentFriction,
    PayloadChange,
    PeriodicForce,
    PreslidingFriction,
    axis_source,
    load_axis,
)
from symid.errors import DeclarationError
from symid.simulation import Cascade, OpenLoop, Trajectory, plant_of, simulate, trapezoids
from symid.simulation.plants.plant import direction_of

AXIS = load_axis("rigid_1m")
MOTOR = AXIS.bodies[0]
VALUES = {"M": 5.0, "Fv": 40.0, "Fs": 6.0}
PERIOD, SECONDS, FINE = 1e-3, 1.2, 50
TIME = PERIOD * np.arange(round(SECONDS / PERIOD))
FORCE = 40.0 * np.sin(2 * np.pi * 3.0 * TIME) + 12.0 * np.cos(2 * np.pi * 7.0 * TIME)


def simulated(axis: Axis, force: np.ndarray = FORCE, values: dict[str, float] = VALUES):
    """The axis driven by a given force, held from sample to sample."""
    none = np.zeros(force.size)
    return simulate(axis, values, Trajectory(none, none, none, PERIOD, "rest"), OpenLoop(force))


def by_hand(
    acting: Callable[[float], float] | None = None,
    friction: Callable[[float, float, float], float] | None = None,
    mass: Callable[[float], float] = lambda t: 5.0,
) -> np.ndarray:
    """Position by semi-implicit Euler in steps of 20 us: M a = f(t) - Fv v - friction(t, q, v, level by default)."""
    q = v = 0.0
    h, found = PERIOD / FINE, []
    for k in range(TIME.size):
        found.append(q)
        for i in range(FINE):
            t = (k + (i + 0.5) / FINE) * PERIOD
            force = FORCE[k] if acting is None else acting(t)
            level, other = (6.0, 0.0) if friction is None else friction(t, q, v)
            push = force - 40.0 * v - other
            v_next = v + h * push / mass(t)
            drop = h * level / mass(t)
            v = np.sign(v_next) * max(abs(v_next) - drop, 0.0)  # set-valued friction, implicitly
            q += h * v
    return np.array(found)


def held(t: float) -> float:
    """The force that was sent at a time."""
    return FORCE[min(max(int(t / PERIOD + 1e-9), 0), FORCE.size - 1)]


def lagged(time: float) -> Callable[[float], float]:
    """The force behind a first-order lag, by its exact recursion in small steps."""
    h, course, f = PERIOD / FINE, [], FORCE[0]
    for k in range(TIME.size):
        for _ in range(FINE):
            f += (FORCE[k] - f) * (1 - np.exp(-h / time))
            course.append(f)
    return lambda t: course[int(t / h)]


def drift(t: float, q: float, v: float) -> tuple[float, float]:
    fading = np.exp(-t / 0.4)
    return 6.0 + 4.0 * fading, 15.0 * fading * v


class ByHandDahl:
    """z by its differential equation."""

    def __init__(self) -> None:
        self.z, self.q = 0.0, 0.0

    def __call__(self, t: float, q: float, v: float) -> tuple[float, float]:
        way = q - self.q
        self.z += (way - abs(way) * self.z) / 1e-3
        self.q = q
        return 0.0, 6.0 * self.z


CASES = {
    "delay": (ActuatorDelay(0.0034), lambda: by_hand(acting=lambda t: held(t - 0.0034))),
    "lag": (ActuatorLag(0.004), lambda: by_hand(acting=lagged(0.004))),
    "limit": (ForceLimit(25.0), lambda: by_hand(acting=lambda t: float(np.clip(held(t), -25, 25)))),
    "bend": (
        GainNonlinearity(0.004, power=2),
        lambda: by_hand(acting=lambda t: held(t) - 0.004 * held(t) * abs(held(t))),
    ),
    "asymmetry": (GainAsymmetry(0.1), lambda: by_hand(acting=lambda t: held(t) - 0.1 * abs(held(t)))),
    "periodic": (
        PeriodicForce(MOTOR, 5.0, -3.0, frequency=11.0),
        lambda: by_hand(friction=lambda t, q, v: (6.0, 5 * np.sin(22 * np.pi * t) - 3 * np.cos(22 * np.pi * t))),
    ),
    "drift": (FrictionDrift(MOTOR, 4.0, 15.0, time_constant=0.4), lambda: by_hand(friction=drift)),
    "trend": (
        FrictionTrend(MOTOR, 5.0, 20.0),
        lambda: by_hand(friction=lambda t, q, v: (6.0 + 5.0 * t, 20.0 * t * v)),
    ),
    "load": (
        LoadDependentFriction(MOTOR, 0.2),
        lambda: by_hand(friction=lambda t, q, v: (6.0 + 0.2 * abs(held(t)), 0.0)),
    ),
    "force_constant": (
        ForceConstantRipple(0.2, -0.1, pitch=0.01),
        lambda: by_hand(
            friction=lambda t, q, v: (
                6.0,
                held(t) * (0.2 * np.sin(200 * np.pi * q) - 0.1 * np.cos(200 * np.pi * q)),
            )
        ),
    ),
    "payload": (PayloadChange(MOTOR, 3.0, time=0.5), lambda: by_hand(mass=lambda t: 5.0 if t < 0.5 else 8.0)),
    "presliding": (PreslidingFriction(MOTOR, 6.0, reach=1e-3), lambda: by_hand(friction=ByHandDahl())),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_the_axis_moves_as_the_equation_says(name: str) -> None:
    element, hand = CASES[name]
    run, wanted = simulated(AXIS.with_effect(element)), hand()
    plain = simulated(AXIS).states[:, 0]
    error = np.abs(run.states[:, 0] - wanted).max()
    assert error < 0.03 * np.abs(plain - wanted).max()
    assert run.log["F"] == pytest.approx(FORCE)


def test_the_equation_by_hand_is_that_of_the_axis_without_imperfection() -> None:
    assert np.abs(simulated(AXIS).states[:, 0] - by_hand()).max() < 1e-3 * np.ptp(by_hand())


def test_a_ripple_is_read_and_controlled() -> None:
    ripple = EncoderRipple("q", 2e-5, 1e-5, pitch=0.01)
    path = trapezoids(0.08, 0.2, acceleration=2.0, jerk=50.0, sampling_period=PERIOD)
    loop = Cascade("q", position_gain=30.0, velocity_gain=300.0, integral_gain=5.0)
    run = simulate(AXIS.with_effect(ripple), VALUES, path, loop)
    q = run.states[:, 0]
    wave = 2 * np.pi * q / 0.01
    assert run.log["q"] == pytest.approx(q + 2e-5 * np.sin(wave) + 1e-5 * np.cos(wave), abs=1e-12)
    perfect = simulate(AXIS, VALUES, path, loop)
    assert np.abs(run.log["F"] - perfect.log["F"]).max() > 0.5  # the controller answers to what it reads


def test_a_joint_sticks_while_load_dependent_friction_holds_it() -> None:
    """A force that grows slowly: it moves once F exceeds Fs + mu F, that is F = Fs/(1 - mu)."""
    force = 10.0 * TIME
    run = simulated(AXIS.with_effect(LoadDependentFriction(MOTOR, 0.25)), force)
    first = TIME[np.flatnonzero(run.states[:, 1] > 0)[0]]
    assert first == pytest.approx(0.6 / 0.75, abs=3 * PERIOD)


def test_load_is_a_force_where_the_signal_is_a_current() -> None:
    element = LoadDependentFriction(MOTOR, 0.2)
    driven = replace(AXIS, drive=replace(AXIS.only_drive, gain="Kf", unit="A")).with_effect(element)
    currents = simulated(driven, FORCE / 20.0, VALUES | {"Kf": 20.0})
    forces = simulated(AXIS.with_effect(element))
    assert currents.states == pytest.approx(forces.states, abs=1e-12)


def test_directions_are_those_of_the_derivation() -> None:
    for name in ("direct_2m1s", "emps"):
        axis = load_axis(name)
        values = dict.fromkeys(axis.physical_parameters, 1.0)
        derived = {tuple(law.direction) for law in plant_of(axis, values).laws}
        declared = {
            tuple(direction_of(law.at, [body.name for body in axis.free_bodies]))
            for law in axis.laws
            if isinstance(law, CoulombFriction)
        }
        assert declared <= derived


def test_a_load_on_a_geared_carriage_moves_by_its_own_coordinate() -> None:
    axis = rack_and_pinion_case().declared
    load = next(body for body in axis.bodies if body.name == "load")
    assert direction_of(load, ["pinion", "load"]).tolist() == [0.0, 1.0]


def test_faults_are_reported_and_files_written() -> None:
    with pytest.raises(DeclarationError, match=r"time_constant is 0\.0: it must be positive"):
        AXIS.with_effect(FrictionDrift(MOTOR, 1.0, 0.0, time_constant=0.0))
    with pytest.raises(DeclarationError, match="not a position sensor: choose from q"):
        AXIS.with_effect(EncoderRipple("qx", 1e-6, 0.0, pitch=0.01))
    two = load_axis("ballscrew_2m1s")
    with pytest.raises(
        DeclarationError, match=r"PreslidingFriction at 'load': .* declare CoulombFriction there too"
    ):
        two.with_effect(PreslidingFriction(two.bodies[1], 5.0, reach=1e-4))
    with pytest.raises(DeclarationError, match=r"drive='F3' is not a drive: choose from F1, F2"):
        gantry.AXIS.with_effect(ForceConstantRipple(0.1, 0.0, pitch=0.02, drive="F3"))
    better = AXIS.with_effect(*(element for element, _ in CASES.values()))
    space: dict[str, object] = {}
    exec(axis_source(better), space)
    assert space["axis"] == better
