"""The minimiser on problems with known answers, beside scipy's."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from symid.estimation.levenberg_marquardt import central_slope, levenberg_marquardt

MISRA1A_Y = [10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.40, 75.47, 81.78]
MISRA1A_X = [77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1, 689.1, 760.0]


def rosenbrock(x):
    return np.array([10 * (x[1] - x[0] ** 2), 1 - x[0]])


def misra1a(b):
    return np.array(MISRA1A_Y) - b[0] * (1 - np.exp(-b[1] * np.array(MISRA1A_X)))


def powell(x):
    return np.array(
        [
            x[0] + 10 * x[1],
            np.sqrt(5) * (x[2] - x[3]),
            (x[1] - 2 * x[2]) ** 2,
            np.sqrt(10) * (x[0] - x[3]) ** 2,
        ]
    )


def test_the_valley_of_rosenbrock() -> None:
    found = levenberg_marquardt(rosenbrock, np.array([-1.2, 1.0]), np.full(2, 1e-6))
    assert found.converged
    np.testing.assert_allclose(found.x, [1.0, 1.0], atol=1e-7)


@pytest.mark.parametrize("start", [(500.0, 1e-4), (250.0, 5e-4)])
def test_the_certified_values_of_nist(start: tuple[float, float]) -> None:
    found = levenberg_marquardt(
        misra1a, np.array(start), np.array([1e-4, 1e-10]), tolerance=1e-14, iterations=200
    )
    np.testing.assert_allclose(found.x, [2.3894212918e2, 5.5015643181e-4], rtol=1e-6)
    assert found.cost == pytest.approx(1.2455138894e-1, rel=1e-9)


def test_a_singular_minimum_is_that_of_scipy() -> None:
    start = np.array([3.0, -1.0, 0.0, 1.0])
    found = levenberg_marquardt(powell, start, np.full(4, 1e-6), tolerance=1e-12, iterations=200)
    peer = least_squares(powell, start, xtol=1e-15, ftol=1e-15, gtol=1e-15)
    assert found.cost < 1e-10
    np.testing.assert_allclose(found.x, peer.x, atol=1e-2)


def test_steps_into_where_the_residual_is_undefined_are_shortened() -> None:
    def residual(x):
        if x[0] < 0:
            raise ValueError("no root of a negative number")
        return np.array([np.sqrt(x[0]) - 0.1])

    found = levenberg_marquardt(residual, np.array([4.0]), np.array([1e-7]))
    assert found.x.item() == pytest.approx(0.01, rel=1e-4)


def test_the_slope_at_an_edge_is_one_sided() -> None:
    def residual(x):
        if x[0] > 1.0:
            raise ValueError("beyond the edge")
        return np.array([x[0] - 2.0, 3 * x[0] - 6.0])

    found = levenberg_marquardt(residual, np.array([0.5]), np.array([1e-6]), iterations=100)
    assert found.x.item() == pytest.approx(1.0, abs=1e-5)
    slope = central_slope(residual, found.x, np.array([1e-6]))
    np.testing.assert_allclose(slope, [[1.0], [3.0]], rtol=1e-6)


def test_no_argument_moves_further_than_it_may() -> None:
    seen: list[float] = []

    def residual(x):
        seen.append(float(x[0]))
        return np.array([x[0] - 100.0])

    found = levenberg_marquardt(
        residual, np.zeros(1), np.array([1e-6]), longest=np.array([2.0]), iterations=3
    )
    assert not found.converged
    assert found.x.item() == pytest.approx(6.0)
    assert max(seen) < 6.001


def test_the_slope_is_the_derivative() -> None:
    found = levenberg_marquardt(misra1a, np.array([240.0, 5.5e-4]), np.array([1e-3, 1e-9]))
    b, x = found.x, np.array(MISRA1A_X)
    expected = np.stack([-(1 - np.exp(-b[1] * x)), -b[0] * x * np.exp(-b[1] * x)], axis=1)
    slope = central_slope(misra1a, b, np.array([1e-3, 1e-9]))
    np.testing.assert_allclose(slope, expected, rtol=1e-6)


def test_an_argument_that_hardly_matters_does_not_slow_the_others() -> None:
    def residual(x):
        return np.array([x[0] - 1.0, 1e-3 * (x[1] - 1e6)])

    found = levenberg_marquardt(
        residual, np.zeros(2), np.full(2, 1e-6), longest=np.full(2, 2.0), iterations=3
    )
    assert found.x[0] == pytest.approx(1.0, abs=1e-3)
    assert found.x[1] == pytest.approx(6.0)
