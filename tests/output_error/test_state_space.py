"""Recursions against plain loops and scipy."""

import numpy as np
import pytest
from scipy.signal import dlsim

from symid.output_error.predictor import StateSpace


def random_system(radius: float, n: int = 3, m: int = 2, p: int = 2) -> StateSpace:
    random = np.random.default_rng(n)
    A = random.standard_normal((n, n))
    A *= radius / np.abs(np.linalg.eigvals(A)).max()
    return StateSpace(
        A, random.standard_normal((n, m)), random.standard_normal((p, n)), random.standard_normal((p, m))
    )


def looped(system: StateSpace, inputs: np.ndarray, starts: tuple[int, ...]) -> np.ndarray:
    rows, x = [], np.zeros(len(system.A))
    for k, u in enumerate(inputs):
        if k in starts:
            x = np.zeros(len(system.A))
        rows.append(system.C @ x + system.D @ u)
        x = system.A @ x + system.B @ u
    return np.array(rows)


@pytest.mark.parametrize("n_samples", [1, 63, 64, 65, 200, 1000])
def test_a_response_is_that_of_dlsim(n_samples: int) -> None:
    system = random_system(0.95)
    inputs = np.random.default_rng(1).standard_normal((n_samples, 2))
    _, expected, _ = dlsim((system.A, system.B, system.C, system.D, 1.0), inputs)
    np.testing.assert_allclose(system.response(inputs, [0]), expected, atol=1e-11)


@pytest.mark.parametrize("starts", [(0, 1), (0, 64, 128), (0, 63, 65, 299), (0, 5, 6, 7, 200)])
def test_the_state_is_zero_again_at_each_start(starts: tuple[int, ...]) -> None:
    system = random_system(0.99)
    inputs = np.random.default_rng(2).standard_normal((300, 2))
    np.testing.assert_allclose(system.response(inputs, starts), looped(system, inputs, starts), atol=1e-11)


def test_an_unstable_recursion_grows_as_it_does_step_by_step() -> None:
    system = random_system(1.1)
    inputs = np.random.default_rng(3).standard_normal((400, 2))
    expected = looped(system, inputs, (0,))
    assert np.abs(expected).max() > 1e12
    found = system.response(inputs, [0])
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * np.abs(expected[:100]).max())


def test_the_free_response_is_that_of_powers_and_ends_where_it_is_forgotten() -> None:
    system = random_system(0.9)
    whole = system.free_response(150)
    for k in (0, 1, 77, 149):
        np.testing.assert_allclose(whole[k], system.C @ np.linalg.matrix_power(system.A, k), atol=1e-14)
    assert len(whole) == 150
    shorter = system.free_response(100_000, forgotten=1e-6)
    assert len(shorter) < 1000
    beyond = system.C @ np.linalg.matrix_power(system.A, len(shorter))
    assert np.abs(beyond).max() < 1e-5 * np.abs(shorter).max()


def test_other_outputs_of_the_same_recursion() -> None:
    system = random_system(0.9)
    inputs = np.random.default_rng(4).standard_normal((100, 2))
    states = system.observed(np.eye(3)).response(inputs, [0])
    expected = states @ system.C.T + inputs @ system.D.T
    np.testing.assert_allclose(system.response(inputs, [0]), expected, atol=1e-12)
