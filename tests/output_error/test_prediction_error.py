"""The scaled innovations against the exact likelihood of a Kalman filter with a vague start, step by step."""

import math

import numpy as np
import pytest
from scipy.linalg import expm

from symid import Log, load_axis
from symid.output_error.prediction_error import PredictionError
from symid.output_error.run import run_of
from symid.simulation import forward_dynamics

TRUTH = {"Ms": 40.0, "Fvs": 60.0, "Ks": 2e5, "Mm": 6.0, "Fvm": 5.0, "Fsm": 0.0}
PERIOD, N = 0.01, 6000
FORCE_NOISE, READING_NOISE = 0.5, {"q2": 2e-5, "ddq1": 0.02}


def matrices(p, directions):
    """A, B and the effects of disturbances; C and D of q2 and ddq1, from equations written by hand."""
    M = np.diag([p["Ms"], p["Mm"]])
    damping = np.array([[p["Fvs"] + p["Fvm"], -p["Fvm"]], [-p["Fvm"], p["Fvm"]]])
    inverse = np.linalg.inv(M)
    generator = np.block(
        [[np.zeros((2, 2)), np.eye(2)], [-inverse @ np.diag([p["Ks"], 0.0]), -inverse @ damping]]
    )
    inputs = np.vstack(
        [np.zeros((2, 1 + len(directions))), inverse @ np.column_stack([[-1.0, 1.0], *directions])]
    )
    m = inputs.shape[1]
    whole = expm(np.block([[generator, inputs], [np.zeros((m, 4 + m))]]) * PERIOD)
    C = np.vstack([[-1.0, 1.0, 0.0, 0.0], generator[2]])
    D = np.vstack([np.zeros(m), inputs[2]])
    return whole[:4, :4], whole[:4, 4:], C, D


def logged(seed: int = 0) -> Log:
    """A motor on its structure, its force held; noise on the log's force and on both readings."""
    random = np.random.default_rng(seed)
    A, B, C, D = matrices(TRUTH, [])
    force = 30 * np.sign(np.sin(np.arange(N) * 0.21)) + 10 * random.standard_normal(N)
    x, rows, before = np.zeros(4), [], force[0]
    for f in force:
        rows.append(C @ x + D[:, 0] * before)  # the acceleration just before the next force acts
        before = f
        x = A @ x + B[:, 0] * f
    noise = random.standard_normal((3, N))
    q2, ddq1 = np.transpose(rows)
    return Log.from_arrays(
        {
            "q2": q2 + READING_NOISE["q2"] * noise[0],
            "ddq1": ddq1 + READING_NOISE["ddq1"] * noise[1],
            "Fm": force + FORCE_NOISE * noise[2],
        },
        sampling_period=PERIOD,
    )


def likelihood(p, log, signals, forces, readings):
    """Twice the negative logarithm of the likelihood, its noise level at its best, by a Kalman filter."""
    A, B, C, D = matrices(p, [[1.0, 0.0]][: len(signals) - 1])
    C, D = C[: len(signals)], D[: len(signals)]
    sign = np.array([-1.0, 1.0])[: len(signals)]  # the log's force holds its noise
    into, onto = B * sign * forces, D * sign * forces
    Q, R, S = into @ into.T, onto @ onto.T + np.diag(np.square(readings)), into @ onto.T
    x, P = np.zeros(4), np.diag([1.0, 1.0, 1e3, 1e3])
    squares = determinants = 0.0
    rows = np.stack([log[name] for name in signals], axis=1)
    force = log["Fm"]
    for y, f, before in zip(rows, force, np.append(force[0], force), strict=False):
        F = C @ P @ C.T + R
        K = np.linalg.solve(F, (A @ P @ C.T + S).T).T
        e = y - C @ x - D[:, 0] * before
        squares += e @ np.linalg.solve(F, e)
        determinants += math.log(np.linalg.det(F))
        x = A @ x + B[:, 0] * f + K @ e
        P = A @ P @ A.T + Q - K @ F @ K.T
        P = (P + P.T) / 2
    return rows.size * math.log(squares) + determinants


def error_of(log: Log, signals: tuple[str, ...]) -> PredictionError:
    dynamics = forward_dynamics(load_axis("direct_2m1s"))
    run = run_of(dynamics, log, signals, "held", cutoff_hz=20.0, standstill=0.0)
    assert all(run.motions)
    return PredictionError(dynamics, run, run.motions)


CHANGES = [({"Mm": 6.2}, 0.0), ({"Ks": 2.02e5}, 0.0), ({"Fvs": 90.0, "Ms": 40.5}, 0.0), ({}, 0.7), ({}, -1.0)]


@pytest.mark.parametrize("signals", [("q2",), ("q2", "ddq1")])
@pytest.mark.parametrize(("changed", "louder"), CHANGES)
def test_least_squares_is_the_likelihood(signals, changed, louder) -> None:
    log = logged()
    error = error_of(log, signals)
    nuisance = error.first_nuisance
    moved = nuisance + louder * np.eye(nuisance.size)[0]
    found, expected = [], []
    for p, n in ((TRUTH, nuisance), ({**TRUTH, **changed}, moved)):
        scaled = error.scaled(p, n)
        found.append(scaled.size * math.log(scaled @ scaled))
        forces, readings = error._assumed_noise(error._sampled(error.dynamics.at(p)), n)
        expected.append(likelihood(p, log, signals, forces, readings))
    difference = expected[1] - expected[0]
    assert abs(difference) > 30
    assert found[1] - found[0] == pytest.approx(difference, abs=6.0)  # the start, of four states


@pytest.mark.parametrize("signals", [("q2",), ("q2", "ddq1")])
def test_innovations_and_noise_of_the_true_model_are_those_of_the_log(signals) -> None:
    """With the nuisance parameters that belong to the noise that was added, and no disturbance."""
    error = error_of(logged(1), signals)
    nuisance = error.first_nuisance
    for _ in range(8):  # the ratios enter through one function; a few substitutions find them
        forces, readings = error._assumed_noise(error._sampled(error.dynamics.at(TRUTH)), nuisance)
        nuisance[0] += math.log(FORCE_NOISE / READING_NOISE["q2"] / (forces[0] / readings[0]))
        if len(signals) == 2:
            nuisance[1] = -10.0
            nuisance[2] += math.log(READING_NOISE["ddq1"] / READING_NOISE["q2"] / (readings[1] / readings[0]))
    noise = error.noise(TRUTH, nuisance)
    assert noise["Fm"] == pytest.approx(FORCE_NOISE, rel=0.05)
    for name in signals:
        assert noise[name] == pytest.approx(READING_NOISE[name], rel=0.05)
    e = error.innovations(TRUTH, nuisance)
    white = e / e.std(axis=0)
    # An accelerometer sees the noise of the force that was held before; the predictor puts it one sample later.
    for lag in (1, 2, 3, 10) if signals == ("q2",) else (2, 3, 10):
        assert np.abs(white[lag:].T @ white[:-lag] / N).max() < 4 / math.sqrt(N)


def test_predicted_states_are_those_of_the_axis() -> None:
    A, B, _, _ = matrices(TRUTH, [])
    log = logged(2)
    error = error_of(log, ("q2",))
    states = error.states(TRUTH, np.array([2.0]))
    random = np.random.default_rng(2)
    force = 30 * np.sign(np.sin(np.arange(N) * 0.21)) + 10 * random.standard_normal(N)
    x, expected = np.zeros(4), []
    for f in force:
        expected.append(x)
        x = A @ x + B[:, 0] * f
    misfit = states - np.array(expected)
    assert np.all(misfit[100:].std(axis=0) < 0.05 * np.std(expected, axis=0))


def test_any_initial_state_of_a_stretch_is_projected_out() -> None:
    error, log = error_of(logged(), ("q2",)), logged()
    A, _, C, _ = matrices(TRUTH, [])
    free = np.array([C[0] @ np.linalg.matrix_power(A, k) @ [1e-3, 2e-3, 0.1, -0.2] for k in range(N)])
    started = Log.from_arrays({**log.signals, "q2": log["q2"] + free}, sampling_period=PERIOD)
    here, there = (e.scaled(TRUTH, np.array([2.0])) for e in (error, error_of(started, ("q2",))))
    units = np.sqrt(np.mean(np.diff(log["q2"], 2) ** 2)), np.sqrt(np.mean(np.diff(started["q2"], 2) ** 2))
    assert units[0] == pytest.approx(units[1], rel=0.05)
    np.testing.assert_allclose(here, there, atol=0.05 * here.std())


def test_the_noise_is_that_of_a_log_that_begins_in_motion() -> None:
    """Initial states are projected out in the measure of the likelihood, not in that of the units."""
    log = logged(3)
    A, _, C, _ = matrices(TRUTH, [])
    free = np.array([C @ np.linalg.matrix_power(A, k) @ [1e-3, 2e-3, 0.1, -0.2] for k in range(N)])
    signals = {**log.signals, "q2": log["q2"] + free[:, 0], "ddq1": log["ddq1"] + free[:, 1]}
    still, moving = (
        error_of(Log.from_arrays(s, sampling_period=PERIOD), ("q2", "ddq1")) for s in (log.signals, signals)
    )
    nuisance = still.first_nuisance
    here, there = still.noise(TRUTH, nuisance), moving.noise(TRUTH, nuisance)
    assert here == pytest.approx(there, rel=0.05)


def test_noise_is_counted_alike_in_an_excerpt_of_a_long_travel() -> None:
    """Joints between its parts are jumps of the position, not noise."""
    axis = load_axis("rigid_1m")
    dynamics, values = forward_dynamics(axis), {"M": 2.0, "Fv": 3.0, "Fs": 0.0}
    t = np.arange(40_000) * 1e-3
    q = 0.1 * t + 1e-6 * np.random.default_rng(0).standard_normal(t.size)
    log = Log.from_arrays({"q": q, "F": np.full(t.size, 0.3)}, sampling_period=1e-3)
    run = run_of(dynamics, log, ("q",), "held", cutoff_hz=200.0, standstill=0.0)
    whole = PredictionError(dynamics, run, run.known_motions)
    costs = [np.mean(e.scaled(values, e.first_nuisance) ** 2) for e in (whole, whole.excerpt())]
    assert costs[1] == pytest.approx(costs[0], rel=0.2)
