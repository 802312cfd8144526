"""Generated regressors on exact motions of plants written by hand, for every axis of the catalogue and set of sensors.

The residual y - D X is judged against the size of its terms, sqrt(sum over samples of (|D| |X|)^2): with jets it is a
few rounding errors (1e-16), while one per cent of the least visible parameter makes it 1e-7.
"""

from math import factorial

import numpy as np
import pytest
from axes.catalogue import cases, every_set, generated
from axes.plant import Array, Motion, Plant, continued, harmonic_motion, random_motion
from scipy.integrate import solve_ivp

from symid.codegen import GeneratedModel, load_generated

ROUNDING = 1e-14
VISIBLE = 1e-9
SHIPPED = [(name, chosen) for name, chosen in every_set() if cases()[name].shipped]


def exact_motion(name: str, model: GeneratedModel, samples: int = 60) -> Motion:
    highest = max(model.highest_derivatives.values()) + 3
    return random_motion(cases()[name].plant(), highest, samples, seed=sum(map(ord, name)))


def observed(name: str, model: GeneratedModel, motion: Motion) -> tuple[Array, Array]:
    case = cases()[name]
    return model.sample(motion.signals(case.declared.drive.signal, case.sensors, model.signals))


def residual(W: Array, y: Array, X: Array) -> float:
    """Largest residual among the equations, relative to the size of their terms."""
    terms = np.linalg.norm(np.abs(W) @ np.abs(X), axis=1)
    return float(np.max(np.linalg.norm(y - W @ X, axis=1) / terms))


@pytest.mark.parametrize(("name", "chosen"), every_set())
def test_regressor_times_minimal_parameters_is_the_output(name: str, chosen: tuple[str, ...]) -> None:
    model = generated(name, chosen)
    W, y = observed(name, model, exact_motion(name, model))
    assert residual(W, y, model.minimal_parameters(**cases()[name].values)) < ROUNDING


@pytest.mark.parametrize(("name", "chosen"), every_set())
def test_one_per_cent_of_any_parameter_shows(name: str, chosen: tuple[str, ...]) -> None:
    model, values = generated(name, chosen), cases()[name].values
    W, y = observed(name, model, exact_motion(name, model))
    unseen = [
        parameter
        for parameter in values
        if residual(W, y, model.minimal_parameters(**{**values, parameter: 1.01 * values[parameter]}))
        < VISIBLE
    ]
    assert unseen == list(cases()[name].hidden.get(chosen, ()))


@pytest.mark.parametrize(("name", "chosen"), every_set())
def test_minimal_parameters_are_the_only_solution(name: str, chosen: tuple[str, ...]) -> None:
    """Columns of D that depend on each other along every motion would leave X without unique values."""
    model = generated(name, chosen)
    motion = exact_motion(name, model, samples=10 * len(model.minimal_units))
    W, y = observed(name, model, motion)
    expected = model.minimal_parameters(**cases()[name].values)
    terms = np.linalg.norm(np.abs(W) @ np.abs(expected), axis=1)
    stacked = (W / terms[:, None, None]).reshape(-1, W.shape[2])
    sizes = np.linalg.norm(stacked, axis=0)
    smallest, largest = np.linalg.svd(stacked / sizes, compute_uv=False)[[-1, 0]]
    assert smallest > 1e-8 * largest
    X = np.linalg.lstsq(stacked / sizes, (y / terms[:, None]).ravel())[0] / sizes
    assert pytest.approx(expected, rel=1e-6) == X


@pytest.mark.parametrize(("name", "chosen"), SHIPPED)
def test_committed_modules_hold_on_exact_signals(name: str, chosen: tuple[str, ...]) -> None:
    model = load_generated(name, chosen)
    W, y = observed(name, model, exact_motion(name, model))
    assert residual(W, y, model.minimal_parameters(**cases()[name].values)) < ROUNDING


def drifting(machine: Plant, motion: Motion, speed: float, samples: int, duration: float) -> Motion:
    """A harmonic motion with a drift at constant speed, driven by a constant force that holds friction and weight."""
    t = np.linspace(0.0, duration, samples)
    free = np.linalg.svd(machine.K)[2][-1]
    (push,) = [row for row, _ in machine.nonlinear] or [machine.B]
    free = free / (push @ free)
    opposing = machine.C @ (free * speed) - machine.constant
    for row, law in machine.nonlinear:
        opposing = opposing + row * law([np.zeros(1), np.array([speed])])[0]
    stiff = np.max(np.abs(machine.K)) or 1.0
    unknown = np.linalg.lstsq(np.column_stack([machine.B, -machine.K / stiff]), opposing)[0]
    x, force = list(motion.x), list(motion.force)
    x[0] = x[0] + unknown[1:, None] / stiff + np.outer(free, speed * t)
    x[1] = x[1] + free[:, None] * speed
    force[0] = force[0] + unknown[0]
    return Motion(x, force)


@pytest.mark.parametrize(
    ("name", "chosen", "frequencies"),
    [
        ("rigid_1m", ("q",), (0.7, 2.3)),
        ("direct_2m1s", ("q2",), (31.0, 78.0, 83.0)),
        ("direct_2m1s", ("q2", "ddq1"), (31.0, 78.0, 83.0)),
        ("direct_2m1s", ("q2", "ddq1", "ddq2"), (31.0, 78.0, 83.0)),
        ("ballscrew_2m1s", ("qm",), (20.0, 79.0)),
        ("ballscrew_2m1s", ("qm", "ql"), (20.0, 79.0)),
        ("direct_3m2s", ("q2",), (40.0, 81.0, 110.0)),
        ("direct_3m2s", ("q2", "ddq1", "ddql"), (40.0, 81.0, 110.0)),
        ("geared_ballscrew_3m2s", ("qs", "ddl"), (30.0, 120.0)),
        ("vertical_2m1s", ("qm",), (12.0, 57.0)),
    ],
)
def test_steady_vibration_with_drift_from_the_frequency_response(
    name: str, chosen: tuple[str, ...], frequencies: tuple[float, ...]
) -> None:
    """Real values, real frequencies, velocity of one sign: the residual relative to the output itself."""
    case, model = cases()[name], generated(name, chosen)
    machine, samples = case.plant(), 400
    highest = max(model.highest_derivatives.values()) + 2
    motion = harmonic_motion(machine, frequencies, highest, samples)
    for speed in (-1.0, 1.0):
        row = machine.nonlinear[0][0]
        drift = 2 * speed * np.max(np.abs(row @ motion.x[1]))
        duration = 3.0 / min(frequencies)
        moving = drifting(machine, motion, drift, samples, duration)
        assert np.all(np.sign(row @ moving.x[1]) == speed)
        W, y = observed(name, model, moving)
        X = model.minimal_parameters(**case.values)
        largest = np.linalg.norm(y, axis=1)
        assert np.all(np.linalg.norm(y - W @ X, axis=1) < 1e-10 * largest)
        wrong = model.minimal_parameters(
            **{k: 1.01 * v if k == next(iter(case.values)) else v for k, v in case.values.items()}
        )
        assert np.any(np.linalg.norm(y - W @ wrong, axis=1) > 1e-6 * largest)


@pytest.mark.parametrize(
    "name", ["direct_2m1s", "pendulum", "hardening_spring", "emps_asymmetric", "vertical_2m1s"]
)
def test_jets_are_points_of_trajectories(name: str) -> None:
    """Taylor's series of a jet meets the trajectory that an integrator finds from the same state."""
    machine, orders = cases()[name].plant(), 14
    motion = random_motion(machine, orders, 8, seed=5)
    step = 0.02 / machine.angular_frequency
    for sample in range(8):
        force = [derivative[sample] for derivative in motion.force]
        jet = [derivative[:, sample] for derivative in motion.x]
        keeps_direction = all(
            abs(row @ jet[1]) > 3 * step * abs(row @ jet[2]) for row, _ in machine.nonlinear
        )
        if not keeps_direction:
            jet = [jet[0], jet[1] * 50]
            jet = [
                d[:, 0]
                for d in continued(machine, [d[:, None] for d in jet], [np.array([f]) for f in force], orders)
            ]

        def slope(t: float, state: Array, force: list[float] = force) -> Array:
            now = sum(f * t**k / factorial(k) for k, f in enumerate(force))
            halves = np.split(state, 2)
            x = continued(machine, [half[:, None] for half in halves], [np.array([now])], 2)
            return np.concatenate([halves[1], x[2][:, 0]])

        start = np.concatenate([jet[0], jet[1]])
        found = solve_ivp(
            slope, (0.0, step), start, method="DOP853", rtol=1e-12, atol=1e-15 * np.abs(start).max()
        )
        series = sum(derivative * step**k / factorial(k) for k, derivative in enumerate(jet))
        moved = np.max(np.abs(series - jet[0]))
        assert found.y[: machine.bodies, -1] - jet[0] == pytest.approx(series - jet[0], abs=1e-9 * moved)
