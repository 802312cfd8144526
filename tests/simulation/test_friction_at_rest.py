"""Friction that holds, and motion that it stops: closed forms, an event-located solve_ivp, the energy balance."""

import numpy as np
import pytest
from driven import driven
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from symid import (
    Axis,
    Body,
    CoulombFriction,
    Drive,
    Law,
    PendulumWeight,
    Position,
    Spring,
    Term,
    ViscousFriction,
    Weight,
    load_axis,
)
from symid.simulation.plants.forward_dynamics import forward_dynamics, plant_of

STEP = 1 / 4000
DIRECT = {"Ms": 900.0, "Fvs": 3000.0, "Ks": 4e7, "Mm": 200.0, "Fvm": 150.0, "Fsm": 80.0}


def test_a_linear_axis_follows_the_matrix_exponential() -> None:
    axis, values = load_axis("direct_2m1s"), {**DIRECT, "Fsm": 0.0}
    plant = plant_of(axis, values)
    start = np.array([1e-4, -2e-4, 0.0, 0.1])
    inverse = np.linalg.inv(plant.mass)
    generator = np.block(
        [[np.zeros((2, 2)), np.eye(2)], [-inverse @ plant.stiffness, -inverse @ plant.damping]]
    )
    states = driven(axis, values, np.zeros(4000), STEP, start)
    exact = expm(generator * 4000 * STEP) @ start
    assert states[-1] == pytest.approx(exact, rel=1e-9, abs=1e-13)


def test_coulomb_friction_stops_a_sliding_mass_where_it_must() -> None:
    """M v(1) = -Fs - Fv v from v0: stops at t = M/Fv ln(1 + Fv v0/Fs) and stays there."""
    M, Fv, Fs, v0 = 5.0, 3.0, 2.0, 0.7
    stop = M / Fv * np.log(1 + Fv * v0 / Fs)
    way = M * v0 / Fv - Fs / Fv * stop
    rest = np.zeros(int(2 * stop / STEP))
    states = driven(load_axis("rigid_1m"), {"M": M, "Fv": Fv, "Fs": Fs}, rest, STEP, np.array([0.0, v0]))
    assert states[-1] == pytest.approx([way, 0.0], abs=1e-13)
    late = states[int(stop / STEP) + 2 :]
    assert np.all(late == late[0])


@pytest.mark.parametrize("start", [0.7, -0.4])
def test_friction_that_differs_by_direction_stops_a_mass_where_it_must(start: float) -> None:
    """As above, with the coefficients of the direction: the law is a straight line in each."""
    values = {"M": 95.0, "Fvp": 166.0, "Fcp": 20.0, "Fvn": 240.0, "Fcn": 21.0}
    Fv, Fc = (166.0, 20.0) if start > 0 else (240.0, 21.0)
    stop = 95.0 / Fv * np.log(1 + Fv * abs(start) / Fc)
    way = np.sign(start) * (95.0 * abs(start) / Fv - Fc / Fv * stop)
    rest = np.zeros(int(stop / STEP) + 10)
    states = driven(load_axis("emps_asymmetric"), values, rest, STEP, np.array([0.0, start]))
    assert states[-1] == pytest.approx([way, 0.0], abs=1e-13)
    assert states[int(stop / STEP), 1] != 0
    assert states[int(stop / STEP) + 1, 1] == 0


def test_a_level_that_varies_along_the_stroke_holds_with_its_value_there() -> None:
    """Friction 4 + 3 cos(2 pi q / 0.1), pulled at a quarter of its period by a rising force: it breaks loose at 4 N."""

    class Wavy(Law):
        def terms(self) -> tuple[Term, ...]:
            return (Term("Fs", "sign(v)"), Term("dF", "sign(v)*cos(62.83185307179586*q)"))

    body = Body("slide", mass="M")
    axis = Axis("wavy", (body, Wavy(body)), Drive("F", body), (Position("q", body),))
    values = {"M": 2.0, "Fs": 4.0, "dF": 3.0}
    ramp = np.linspace(0, 8, 801)
    for place, level in ((0.025, 4.0), (0.05, 1.0), (0.1, 7.0)):
        states = driven(axis, values, ramp, STEP, np.array([place, 0.0]))
        assert ramp[np.argmax(states[1:, 1] > 0)] == pytest.approx(level, abs=0.011)


def test_a_law_that_holds_away_from_zero_only_holds_there() -> None:
    """Friction 40 abs(q), pulled by a rising force: at 0.05 m it breaks loose at 2 N; damping alone never holds."""

    class Wedge(Law):
        def terms(self) -> tuple[Term, ...]:
            return (Term("k", "sign(v)*abs(q)", length_power=1),)

    class Rising(Law):
        def terms(self) -> tuple[Term, ...]:
            return (Term("d", "v*abs(q)", length_power=2, time_power=1),)

    body = Body("slide", mass="M")
    drive, sensor = Drive("F", body), Position("q", body)
    axis, values = Axis("wedge", (body, Wedge(body)), drive, (sensor,)), {"M": 2.0, "k": 40.0}
    damped = plant_of(Axis("rising", (body, Rising(body)), drive, (sensor,)), {"M": 2.0, "d": 40.0})
    ramp = np.linspace(0, 4, 401)
    states = driven(axis, values, ramp, STEP, np.array([0.05, 0.0]))
    assert ramp[np.argmax(states[1:, 1] > 0)] == pytest.approx(2.0, abs=0.011)
    # pushed by 1 N from 0: q = F/k (1 - cos(sqrt(k/M) t)), until it stops at 2 F/k
    pushed = driven(axis, values, np.ones(3000), STEP)
    assert pushed[-1].tolist() == pytest.approx([0.05, 0.0], abs=1e-9)
    assert not damped.laws[0].can_hold


def test_forward_dynamics_belong_to_a_declaration_not_to_its_name() -> None:
    """Derived once: noise of a signal changes nothing, another term does."""
    axis, values = load_axis("rigid_1m"), {"M": 2.0, "Fv": 3.0, "Fs": 4.0}
    noisy = axis.with_signal("q", noise=1e-6)
    assert forward_dynamics(noisy).axis is noisy
    assert forward_dynamics(noisy).motion is forward_dynamics(axis).motion
    body = Body("slide", mass="M")
    elements = (body, ViscousFriction(body, "Fv"), Spring("guide", body, "Fs"))
    sprung = Axis(axis.name, elements, Drive("F", body), (Position("q", body),))
    assert [plant_of(a, values).stiffness.item() for a in (axis, sprung)] == [0.0, 4.0]


def test_a_stiff_axis_stops_as_a_rigid_one() -> None:
    """2 kg with friction and 3 kg behind 1e13 N/m: 300 times stiffer than a step can follow by one series."""
    values = {"Mm": 2.0, "Fvm": 0.0, "Fsm": 4.0, "Kt": 1e13, "Ft": 4e6, "Ml": 3.0, "Fvl": 0.0}
    start = np.array([0.0, 0.0, 0.01, 0.01])
    states = driven(load_axis("ballscrew_2m1s"), values, np.zeros(80), STEP, start)
    stop, way = 5.0 * 0.01 / 4.0, 5.0 * 0.01**2 / (2 * 4.0)
    assert states[-1] == pytest.approx([way, way, 0.0, 0.0], abs=1e-9)
    sliding = np.arange(81) * STEP < stop
    assert np.all(states[sliding, 2] > 0)
    assert np.all(states[~sliding, 2] == pytest.approx(0.0, abs=1e-9))


def test_a_body_held_on_an_incline_does_not_creep() -> None:
    body = Body("slide", mass="M")
    incline = Weight(body, acceleration=9.80665 * np.sin(np.radians(20)))
    axis = Axis(
        "incline", (body, incline, CoulombFriction(body, "Fs")), Drive("F", body), (Position("q", body),)
    )
    values = {"M": 10.0, "Fs": 1.01 * 10 * 9.80665 * np.sin(np.radians(20))}
    held = driven(axis, values, np.zeros(40_000), STEP)
    assert np.abs(held).max() < 1e-15
    pushed = driven(axis, values, np.where(np.arange(8000) < 400, 100.0, 0.0), STEP)
    assert pushed[400, 0] > 1e-3
    assert np.ptp(pushed[-4000:, 0]) < 1e-15


def test_stiction_breaks_at_its_level_and_not_before() -> None:
    ramp = np.linspace(0, 4, 4001)[:-1]
    states = driven(load_axis("rigid_1m"), {"M": 5.0, "Fv": 0.0, "Fs": 2.0}, ramp, STEP)
    assert np.all(states[: np.searchsorted(ramp, 2.0) + 1] == 0)
    time = np.arange(4000) * STEP
    breaks = np.searchsorted(ramp, 2.0, side="right")
    velocity = np.cumsum(np.where(np.arange(4000) >= breaks, ramp - 2.0, 0)) * STEP / 5.0
    assert states[1:, 1] == pytest.approx(velocity, abs=1e-12)
    assert time.size == velocity.size


def test_stick_and_slip_agree_with_an_event_located_integration() -> None:
    """A mass on a spring with friction, pulled by a slow sine: it sticks twice a period."""
    body = Body("slide", mass="M")
    elements = (body, Spring("spring", body, "K"), ViscousFriction(body, "Fv"), CoulombFriction(body, "Fs"))
    axis = Axis("stick", elements, Drive("F", body), (Position("q", body),))
    M, K, Fv, Fs = 2.0, 500.0, 4.0, 6.0
    time = np.arange(8000) * STEP
    force = 15 * np.sin(2 * np.pi * 0.9 * time)
    states = driven(axis, {"M": M, "K": K, "Fv": Fv, "Fs": Fs}, force, STEP)
    reference = reference_run(M, K, Fv, Fs, force)
    assert np.abs(states[:, 0] - reference[:, 0]).max() < 1e-10
    assert np.abs(states[:, 1] - reference[:, 1]).max() < 1e-8
    assert np.mean(states[1:, 1] == 0) > 0.05


def reference_run(M: float, K: float, Fv: float, Fs: float, forces: np.ndarray) -> np.ndarray:
    """The same by solve_ivp over each sample, restarted at every zero of the velocity."""
    state, states = np.zeros(2), [np.zeros(2)]
    for force in forces:
        left = STEP
        while left > 1e-16:
            q, v = state
            pull = force - K * q
            if v == 0 and abs(pull) <= Fs:
                break
            sign = np.sign(v) if v != 0 else np.sign(pull)

            def motion(_: float, z: np.ndarray, f: float = force, s: float = sign) -> list[float]:
                return [z[1], (f - K * z[0] - Fv * z[1] - Fs * s) / M]

            def rest(_: float, z: np.ndarray, s: float = sign) -> float:
                return float(s * z[1] + (1e-18 if s * z[1] >= 0 else 0))

            rest.terminal, rest.direction = True, -1
            run = solve_ivp(motion, (0, left), state, "DOP853", rtol=1e-12, atol=1e-15, events=rest)
            state = run.y[:, -1].copy()
            left -= run.t[-1]
            if run.status == 1:
                state[1] = 0.0
        states.append(state.copy())
    return np.array(states)


def test_energy_lost_is_the_work_of_friction() -> None:
    """Free oscillation with Coulomb friction loses 4 Fs A per period; the work is Fs times the way."""
    body = Body("slide", mass="M")
    axis = Axis(
        "oscillator",
        (body, Spring("spring", body, "K"), CoulombFriction(body, "Fs")),
        Drive("F", body),
        (Position("q", body),),
    )
    M, K, Fs = 2.0, 800.0, 1.5
    states = driven(axis, {"M": M, "K": K, "Fs": Fs}, np.zeros(12_000), STEP, np.array([0.05, 0.0]))
    energy = 0.5 * M * states[:, 1] ** 2 + 0.5 * K * states[:, 0] ** 2
    turns = np.flatnonzero(np.diff(np.sign(states[:, 1])) != 0)
    extremes = states[turns, 0]
    assert np.abs(np.abs(np.diff(np.abs(extremes[:6]))) - 2 * Fs / K).max() < 1e-5
    assert np.all(np.diff(energy) <= 1e-12)
    assert abs(states[-1, 0]) <= Fs / K + 1e-12
    assert states[-1, 1] == 0


def test_a_pendulum_converges_with_the_second_order() -> None:
    arm = Body("arm", inertia="J")
    axis = Axis(
        "pendulum",
        (arm, PendulumWeight(arm, "ml"), ViscousFriction(arm, "Fv")),
        Drive("T", arm),
        (Position("q", arm),),
    )
    values = {"J": 0.15, "ml": 0.3, "Fv": 0.02}
    start = np.array([1.2, 0.0])
    exact = solve_ivp(
        lambda _, z: [z[1], (-0.3 * 9.80665 * np.sin(z[0]) - 0.02 * z[1]) / 0.15],
        (0, 2),
        start,
        "DOP853",
        rtol=1e-12,
        atol=1e-14,
    ).y[:, -1]
    errors = [
        np.abs(driven(axis, values, np.zeros(n), 2 / n, start)[-1] - exact).max() for n in (500, 1000, 2000)
    ]
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.15)
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.15)


def test_two_joints_with_friction_stick_independently() -> None:
    carriage = Body("carriage", mass="Mc")
    slide = Body("slide", mass="Ms", on=carriage)
    elements = (carriage, CoulombFriction(carriage, "Fc"), slide, CoulombFriction(slide, "Fs"))
    axis = Axis("two", elements, Drive("F", slide), (Position("q", slide),))
    values = {"Mc": 3.0, "Ms": 2.0, "Fc": 10.0, "Fs": 4.0}
    states = driven(axis, values, np.full(400, 8.0), STEP)
    assert np.all(states[:, 0] == 0)
    assert states[-1, 3] == pytest.approx((8 - 4) / 2 * 0.1, rel=1e-12)
    both = driven(axis, values, np.full(400, 20.0), STEP)
    assert both[-1, 2] == pytest.approx(-(20 - 4 - 10) / 3 * 0.1 if 20 - 4 > 10 else 0, rel=1e-9)
