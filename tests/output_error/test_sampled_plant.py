"""The recursion from sample to sample against an integration of equations of motion written by hand."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from symid import load_axis
from symid.output_error.sampled_plant import sampled_plant
from symid.simulation import plant_of

DIRECT = {"Ms": 40.0, "Fvs": 30.0, "Ks": 9e4, "Mm": 6.0, "Fvm": 5.0, "Fsm": 2.0}
BENCH = {"Jm": 2e-3, "Fvm": 4e-3, "Kt": 40.0, "Ft": 0.01, "Pt": -0.7, "Jl": 3e-3, "Fvl": 5e-3}


def direct_accelerations(x, force, friction):
    """Structure and motor, the motor's force and friction acting back on the structure."""
    x1, _, v1, v2 = x
    p = DIRECT
    between = force - p["Fvm"] * (v2 - v1) - friction
    return [(-between - p["Fvs"] * v1 - p["Ks"] * x1) / p["Ms"], between / p["Mm"]]


def bench_accelerations(x, current, _):
    """Two turning bodies and a coupling whose zero is off by a torque."""
    x1, x2, v1, v2 = x
    p = BENCH
    coupling = p["Kt"] * (x1 - x2) + p["Ft"] * (v1 - v2) - p["Pt"]
    return [(current - p["Fvm"] * v1 - coupling) / p["Jm"], (coupling - p["Fvl"] * v2) / p["Jl"]]


def integrated(accelerations, start, period, drive, friction):
    """States after one interval cut into parts with constant forces."""
    x = start
    for force, law in zip(drive, friction, strict=True):
        found = solve_ivp(
            lambda _, x, force=force, law=law: [*x[2:], *accelerations(x, force, law)],
            (0.0, period / len(drive)),
            x,
            method="DOP853",
            rtol=1e-12,
            atol=1e-14,
        )
        x = found.y[:, -1]
    return x


@pytest.mark.parametrize("parts", [1, 4])
@pytest.mark.parametrize(
    ("name", "values", "accelerations", "period"),
    [("direct_2m1s", DIRECT, direct_accelerations, 0.02), ("motor_bench", BENCH, bench_accelerations, 0.01)],
)
def test_one_interval_is_that_of_an_integration(name, values, accelerations, period, parts) -> None:
    random = np.random.default_rng(parts)
    plant = plant_of(load_axis(name), values)
    sampled = sampled_plant(plant, [next(iter(plant.sensors))], period, parts)
    drive, friction = random.standard_normal((2, parts))
    start = 0.01 * random.standard_normal(4)
    expected = integrated(accelerations, start, period, drive, friction)
    laws = [friction] * len(plant.laws)
    forces = np.stack([drive, *laws, np.ones(parts)], axis=1)
    reached = sampled.transition @ start + np.einsum("inm,im->n", sampled.effects, forces)
    np.testing.assert_allclose(reached, expected, rtol=1e-9, atol=1e-13)


def test_a_rigid_mass_with_friction_is_that_of_the_textbook() -> None:
    M, Fv, T = 2.0, 6.0, 0.3
    plant = plant_of(load_axis("rigid_1m"), {"M": M, "Fv": Fv, "Fs": 1.0})
    found = sampled_plant(plant, ["q"], T, parts=3)
    fade = np.exp(-Fv / M * T)
    np.testing.assert_allclose(found.transition, [[1, (1 - fade) * M / Fv], [0, fade]], rtol=1e-13)
    reached = [T / Fv - M / Fv**2 * (1 - fade), (1 - fade) / Fv]
    np.testing.assert_allclose(found.effects[:, :, 0].sum(axis=0), reached, rtol=1e-12)
    np.testing.assert_allclose(found.effects[:, :, 1].sum(axis=0), -np.array(reached), rtol=1e-12)
    assert found.disturbances.shape == (2, 0)


def test_accelerometers_see_forces_at_once_and_positions_do_not() -> None:
    signals = ["q2", "ddq1", "ddq2"]
    plant = plant_of(load_axis("direct_2m1s"), DIRECT)
    found = sampled_plant(plant, signals, 0.01, parts=2, disturbed=signals[1:])
    x, force, friction = np.array([1e-3, 2e-3, 0.1, -0.2]), 3.0, 0.7
    first, second = direct_accelerations(x, force, friction)
    read = found.output @ x + found.feedthrough @ [force, friction, 1.0]
    np.testing.assert_allclose(read, [x[1] - x[0], first, second - first], rtol=1e-12)
    assert not found.feedthrough[0].any()


def test_disturbances_act_along_the_direction_of_each_further_sensor() -> None:
    signals, T = ["q2", "ddq1", "ddq2"], 0.01
    plant = plant_of(load_axis("direct_2m1s"), DIRECT)
    found = sampled_plant(plant, signals, T, parts=2, disturbed=signals[1:])
    Ms, Mm = DIRECT["Ms"], DIRECT["Mm"]
    np.testing.assert_allclose(
        found.disturbance_feedthrough[1:], [[1 / Ms, -1 / Ms], [-1 / Ms, 1 / Ms + 1 / Mm]]
    )
    impulse = np.zeros(4)
    for direction, column in zip(([1, 0], [-1, 1]), found.disturbances.T, strict=True):
        forced = solve_ivp(
            lambda _, x, d=direction: [
                *x[2:],
                *np.add(direct_accelerations(x, 0.0, 0.0), [d[0] / Ms, d[1] / Mm]),
            ],
            (0.0, T),
            impulse,
            rtol=1e-12,
            atol=1e-16,
        )
        np.testing.assert_allclose(column, forced.y[:, -1], rtol=1e-8, atol=1e-14)
