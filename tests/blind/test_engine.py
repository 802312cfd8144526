"""The simulator of benchmarks/blind against solutions by hand, transfer functions, energy and momentum."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.blind import axes, engine
from benchmarks.blind.axes import Machine, with_row
from benchmarks.blind.laws import Effect, enter

OPEN = np.array([0.0, 0.0, 0.0, 1.0])
TRAVEL = {"force": 100.0, "deflection": 1e-3}


def pushed(plant: Machine, force: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions and accelerations at 4 kHz under a force at 16 kHz, without a controller."""
    motion = np.vstack([np.zeros((2, force.size)), force])
    positions, accelerations, command = engine.loop(
        plant.arguments(), OPEN, motion, np.zeros((2, force.size))
    )
    assert np.array_equal(command, force)
    return positions, accelerations


def constant(force: float, seconds: float) -> np.ndarray:
    return np.full(int(seconds * engine.CONTROL_HZ), force)


def rigid(M: float = 10.0, Fv: float = 0.0, Fs: float = 0.0) -> Machine:
    return axes.machine("rigid_1m", {"M": M, "Fv": Fv, "Fs": Fs})


def end(plant: Machine, force: float = 50.0, seconds: float = 0.5) -> tuple[float, float, float]:
    """Time, position and speed at the last sample but one, from a force that is constant from rest."""
    x = pushed(plant, constant(force, seconds))[0][:, 0]
    t = (x.size - 2) / 4000
    return t, x[-2], (x[-1] - x[-3]) * 2000


def with_effect(
    plant: Machine, name: str, axis: str = "rigid_1m", at: str = "motor", **numbers: float
) -> Machine:
    return enter(plant, Effect(name, at, next(iter(numbers)), numbers, np.inf), axis, TRAVEL)


def test_mass_with_both_frictions_from_rest():
    t, x, v = end(rigid(10, 30, 20))
    speed = 1 - np.exp(-3 * t)  # (50 - 20) / 30 = 1 m/s in the end
    assert v == pytest.approx(speed, rel=1e-6)
    assert x == pytest.approx(t - speed / 3, rel=1e-9)


def test_friction_holds_what_it_can():
    x, a = pushed(rigid(Fs=20), constant(19.99, 0.2))
    assert not x.any()
    assert np.abs(a).max() < 1e-12


def test_work_of_the_force_is_the_heat_of_friction():
    force = np.concatenate([constant(50, 0.1), constant(0, 0.4)])
    x = pushed(rigid(10, 0, 20), force)[0][:, 0]
    assert 50 * x[400] == pytest.approx(20 * x[-1], rel=1e-6)
    assert np.ptp(x[-400:]) < 1e-15


@pytest.mark.parametrize("frequency", [5.0, 25.0, 47.0, 110.0])
@pytest.mark.parametrize("axis", ["direct_2m1s", "ballscrew_2m1s"])
def test_response_of_two_masses_is_that_of_their_transfer_function(axis: str, frequency: float):
    direct = {"Ms": 2000.0, "Fvs": 5e4, "Ks": 2e8, "Mm": 300.0, "Fvm": 4e3, "Fsm": 0.0}
    screw = {"Mm": 100.0, "Fvm": 3e3, "Fsm": 0.0, "Kt": 6e6, "Ft": 2e3, "Ml": 200.0, "Fvl": 3e3}
    s = 2j * np.pi * frequency
    if axis == "direct_2m1s":
        p = direct
        matrix = [
            [p["Ms"] * s**2 + p["Fvs"] * s + p["Ks"], -p["Fvm"] * s],
            [p["Mm"] * s**2, p["Mm"] * s**2 + p["Fvm"] * s],
        ]
        expected = np.linalg.solve(matrix, [-1, 1])  # of the structure, and of the motor on it
        expected[1] += expected[0]
    else:
        p = screw
        link = p["Ft"] * s + p["Kt"]
        motor, load = p["Mm"] * s**2 + p["Fvm"] * s + link, p["Ml"] * s**2 + p["Fvl"] * s + link
        expected = np.linalg.solve([[motor, -link], [-link, load]], [1, 0])
    t = np.arange(int(2.0 * engine.CONTROL_HZ)) / engine.CONTROL_HZ
    x, _ = pushed(axes.machine(axis, p), 100 * np.sin(2 * np.pi * frequency * t))
    late = x[x.shape[0] // 2 :]
    time = np.arange(x.shape[0])[x.shape[0] // 2 :] / 4000
    waves = np.stack([np.exp(s * time).imag, np.exp(s * time).real, np.ones(time.size), time], axis=1)
    sine, cosine = np.linalg.lstsq(waves, late, rcond=None)[0][:2]
    held = np.exp(-s / 2 / engine.CONTROL_HZ) * np.sinc(frequency / engine.CONTROL_HZ)
    np.testing.assert_allclose((sine + 1j * cosine) / 100, expected * held, rtol=2e-3)


def test_controller_by_its_own_recursion():
    """Of an axis that friction holds fast, the controller reads the noise, in whole steps."""
    gains, ticks, step = np.array([20.0, 800.0, 9000.0, 0.3]), 4000, 1e-6
    reference = 0.01 * (1 - np.cos(np.arange(ticks) / 600))
    motion = np.vstack([reference, np.gradient(reference) * engine.CONTROL_HZ, np.zeros(ticks)])
    noise = np.zeros((2, ticks))
    noise[0], noise[1, 0] = 3e-6 * np.random.default_rng(1).standard_normal(ticks), step
    x, _, command = engine.loop(rigid(10, 30, 1e9).arguments(), gains, motion, noise)
    assert not x.any()
    reading = np.round(noise[0] / step) * step
    speed, integral, expected = 0.0, 0.0, np.zeros(ticks)
    for k in range(ticks):
        speed += 0.3 * ((reading[k] - reading[k - 1]) * engine.CONTROL_HZ * (k > 0) - speed)
        error = motion[1, k] + 20 * (reference[k] - reading[k]) - speed
        integral += error / engine.CONTROL_HZ
        expected[k] = 800 * error + 9000 * integral
    np.testing.assert_allclose(command, expected, rtol=1e-9, atol=1e-9)


def test_frictions_at_a_steady_speed():
    """With Fv = 100 Ns/m and a force found by hand for v = 0.5 m/s."""
    plant, v = rigid(10, 100, 20), 0.5
    cases = {
        "viscous_friction": (70 + 40 * v, {"Fv": 40.0}),
        "coulomb_friction": (70 + 15, {"Fs": 15.0}),
        "stribeck_friction": (70 + 12 * np.exp(-((v / 0.4) ** 2)), {"dF": 12.0, "vs": 0.4}),
        "asymmetric_friction": (70 + 9, {"difference": 9.0, "side": 1.0}),
        "load_dependent_friction": (70 / 0.9, {"mu": 0.1}),
        "quadratic_drag": (70 + 60 * v**2, {"c": 60.0}),
        "presliding_friction": (70, {"reach": 1e-4}),
    }
    for name, (force, numbers) in cases.items():
        changed = with_effect(plant, name, **numbers)
        assert end(changed, force, 2.0)[2] == pytest.approx(v, rel=1e-6), name
        sign = 70 if name == "asymmetric_friction" else force
        assert end(changed, -sign, 2.0)[2] == pytest.approx(-v, rel=1e-6), name


def test_forces_of_position_by_the_energy_that_they_take():
    """M v^2 / 2 = F x - work of the law, for a mass without other friction."""
    wave = 2 * np.pi / 0.05

    def level(x: float) -> float:
        return 20 * x + 8 / wave * (np.cos(0.7) - np.cos(wave * x + 0.7))

    cases = {
        "offset_force": ({"force": 7.0, "side": -1.0}, 0.0, lambda x: 7 * x),
        "position_stiffness": ({"k": 60.0}, 0.0, lambda x: 30 * x**2),
        "cogging": ({"force": 8.0, "pitch": 0.05, "phase": 0.7}, 0.0, lambda x: 20 * x - level(x)),
        "position_dependent_friction": ({"dF": 8.0, "pitch": 0.05, "phase": 0.7}, 20.0, level),
        "sticky_zone": (
            {"force": 30.0, "place": 0.2, "half": 0.04},
            0.0,
            lambda x: 30 * np.clip(x - 0.16, 0, 0.08),
        ),
    }
    for name, (numbers, Fs, work) in cases.items():
        _, x, v = end(with_effect(rigid(Fs=Fs), name, **numbers))
        assert x > 0.25, name
        assert 10 * v**2 / 2 == pytest.approx(50 * x - work(x), rel=2e-5), name


def test_forces_of_time_and_motion_by_momentum():
    t, x, v = end(with_effect(rigid(), "periodic_disturbance", force=20.0, frequency=3.0, phase=0.4))
    w = 6 * np.pi
    assert 10 * v == pytest.approx(50 * t + 20 / w * (np.cos(0.4) - np.cos(w * t + 0.4)), rel=1e-5)
    t, x, v = end(with_effect(rigid(Fs=20), "friction_drift", relative=0.8, time=0.3))
    assert 10 * v == pytest.approx(50 * t - 20 * t - 16 * (t - 0.3 * (1 - np.exp(-t / 0.3))), rel=1e-6)
    # An inertia M + c x: (M + c x) a = F.
    t, x, v = end(with_effect(rigid(), "coupled_inertia", mass=4.0))
    assert 10 * v**2 / 2 == pytest.approx(50 * 10 / 4 * np.log(1 + 4 * x / 10), rel=1e-4)
    t, x, v = end(with_row(replace(rigid(), outside=np.arange(4001.0)), engine.OUTSIDE, 0, 0.01))
    assert 10 * v == pytest.approx(50 * t + 0.01 * 4000 * t**2 / 2, rel=1e-6)
    t, x, v = end(with_effect(rigid(), "payload_change", mass=0.5, time=0.25))
    assert v == pytest.approx(50 * 0.25 / 10 + 50 * (t - 0.25) / 15, rel=1e-9)
    t, x, v = end(with_effect(rigid(), "acceleration_squared", force=0.4))
    a = v / t
    assert 10 * a + 0.4 * a**2 == pytest.approx(50, rel=1e-4)


def test_bristles_bend_along_their_curve():
    force = np.concatenate([np.linspace(0, 15, 16000), constant(15, 1.5)])
    x = pushed(with_effect(rigid(10, 500, 20), "presliding_friction", reach=1e-3), force)[0][-1, 0]
    assert x == pytest.approx(-1e-3 * np.log(1 - 15 / 20), rel=1e-4)


def test_actuators():
    M, F = 10.0, 50.0
    t, x, v = end(with_effect(rigid(), "delay", at="actuator", time=0.002))
    assert x == pytest.approx(F / M * (t - 0.002) ** 2 / 2, rel=1e-9)
    t, x, v = end(with_effect(rigid(), "actuator_lag", at="actuator", time=0.01))
    assert v == pytest.approx(F / M * (t - 0.01), rel=1e-6)
    t, x, v = end(with_effect(rigid(), "saturation", at="actuator", cut=0.7))
    assert v == pytest.approx(30 / M * t, rel=1e-9)
    for cubic, share in ((0.0, 1 - 0.2 * 0.5), (1.0, 1 - 0.2 * 0.25)):
        t, x, v = end(with_effect(rigid(), "gain_nonlinearity", at="actuator", bend=0.2, cubic=cubic))
        assert v == pytest.approx(share * F / M * t, rel=1e-9)


def test_springs_at_rest():
    """A constant drive force bends the foundation of direct_2m1s, whose damping here is heavy."""
    values = {"Ms": 500.0, "Fvs": 2e5, "Ks": 1e7, "Mm": 5e4, "Fvm": 0.0, "Fsm": 0.0}
    plain = axes.machine("direct_2m1s", values)
    slack = with_effect(plain, "backlash", "direct_2m1s", "structure", gap=4e-5)
    hard = with_effect(plain, "stiffness_nonlinearity", "direct_2m1s", "structure", bend=0.5)
    still = [pushed(plant, constant(1000, 1.0))[0][-1, 0] for plant in (plain, slack, hard)]
    assert still[0] == pytest.approx(-1e-4, rel=1e-6)
    assert still[1] == pytest.approx(-1e-4 - 2e-5, rel=1e-6)
    d = -still[2]
    assert 1e7 * d + 0.5 * 1e7 / TRAVEL["deflection"] ** 2 * d**3 == pytest.approx(1000, rel=1e-6)


def test_an_extra_body_takes_its_share():
    plant = with_effect(rigid(), "flexible_mode", mass=0.3, frequency=30.0, damping=0.5)
    x = pushed(plant, constant(50, 0.5))[0]
    lag = x[-1, 0] - x[-1, 1]
    assert (10 * x[-1, 0] + 3 * x[-1, 1]) == pytest.approx(50 * ((x.shape[0] - 1) / 4000) ** 2 / 2, rel=1e-6)
    assert lag == pytest.approx(50 / 13 / (60 * np.pi) ** 2, rel=1e-3)
