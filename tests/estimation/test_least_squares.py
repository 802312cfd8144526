"""Least squares against hand calculation and scipy, and under changes that must not matter."""

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given, settings, strategies as st

from symid.errors import SettingError
from symid.estimation.corrected_covariance import ObservationBlock
from symid.estimation.least_squares import estimate, relative_standard_deviation, residuals
from symid.estimation.refinement import refine_blocks
from symid.estimation.triangular import TriangularFactor, triangular_factors


def noisy(seed, equations=1, rows=200, columns=3):
    rng = np.random.default_rng(seed)
    W = rng.standard_normal((equations, rows, columns))
    return W, W @ np.arange(1.0, columns + 1) + 0.3 * rng.standard_normal((equations, rows))


def test_line_through_three_points_by_hand():
    # y = 0, 1, 5 at 0, 1, 2: residuals 1/2, -1, 1/2; sigma^2 = 3/2 with 1 row to spare
    W = np.array([[[1.0, 0.0], [1.0, 1.0], [1.0, 2.0]]])
    fit = estimate(triangular_factors(W, np.array([[0.0, 1.0, 5.0]])), method="ols")
    assert fit.status == "ok"
    assert np.allclose(fit.parameters, [-0.5, 2.5])
    assert np.allclose(fit.covariance, [[1.25, -0.75], [-0.75, 0.75]])
    assert np.isclose(fit.sigma_rho, np.sqrt(1.5))
    assert np.allclose(fit.residual_norm, [np.sqrt(1.5)])
    assert np.isclose(fit.relative_error, np.sqrt(1.5 / 26.0))
    assert np.allclose(fit.relative_standard_deviations, 100 * np.sqrt([1.25, 0.75]) / [0.5, 2.5])


def test_divisor_of_the_callers_choice():
    W, y = noisy(0)
    factors = triangular_factors(W, y)
    default, other = estimate(factors), estimate(factors, ddof=1)
    assert np.allclose(other.standard_deviations, default.standard_deviations * np.sqrt(197 / 199))


def test_agrees_with_scipy():
    W, y = noisy(1)
    expected, *_ = scipy.linalg.lstsq(W[0], y[0])
    fit = estimate(triangular_factors(W, y))
    assert np.allclose(fit.parameters, expected, rtol=1e-13)
    assert np.isclose(fit.condition_number, np.linalg.cond(W[0]))
    assert np.isclose(fit.condition_number_scaled, np.linalg.cond(W[0] / np.linalg.norm(W[0], axis=0)))
    assert np.isclose(np.linalg.norm(residuals(W, y, fit)), fit.residual_norm[0])


def test_weighted_least_squares_is_least_squares_of_weighted_rows():
    W, y = noisy(2, equations=2)
    y[1] += 5.0 * np.random.default_rng(3).standard_normal(200)
    sigmas = [np.linalg.norm(y[j] - W[j] @ np.linalg.lstsq(W[j], y[j])[0]) / np.sqrt(197) for j in (0, 1)]
    stacked, output = (
        np.vstack([W[j] / sigmas[j] for j in (0, 1)]),
        np.hstack([y[j] / sigmas[j] for j in (0, 1)]),
    )
    fit = estimate(triangular_factors(W, y))
    expected = np.linalg.lstsq(stacked, output)[0]
    variance = np.sum((output - stacked @ expected) ** 2) / (400 - 3)
    assert np.allclose(fit.parameters, expected)
    assert np.allclose(fit.weights, 1.0 / np.array(sigmas))
    assert np.allclose(fit.covariance, variance * np.linalg.inv(stacked.T @ stacked))


def test_own_fit_counts_only_the_columns_that_are_not_zero():
    W, y = noisy(4, equations=2)
    W[0, :, 2] = 0.0
    own = np.linalg.lstsq(W[0, :, :2], y[0])[0]
    sigma = np.linalg.norm(y[0] - W[0, :, :2] @ own) / np.sqrt(198)
    assert np.isclose(estimate(triangular_factors(W, y)).sigma_rho_equation[0], sigma)


def test_homogeneous_equation_takes_its_deviation_from_the_joint_solution():
    rng = np.random.default_rng(5)
    a, b = rng.standard_normal((2, 500))
    noise = 0.01 * rng.standard_normal(500)
    W = np.stack([np.column_stack([a, 0 * a]), np.column_stack([2.0 * b, -b + noise])])  # 2 x0 = x1
    y = np.stack([3.0 * a + 0.1 * rng.standard_normal(500), 0 * a])
    factors = triangular_factors(W, y)
    joint, weighted = estimate(factors, method="ols"), estimate(factors)
    assert np.isclose(weighted.sigma_rho_equation[1], joint.residual_norm[1] / np.sqrt(498))
    assert np.all(np.isfinite(weighted.weights))
    assert np.allclose(weighted.parameters, [3.0, 6.0], rtol=0.01)


@pytest.mark.parametrize("method", ["ols", "wls"])
def test_exact_fits_do_not_divide_by_zero(method):
    W = np.random.default_rng(6).standard_normal((2, 30, 2))
    fit = estimate(triangular_factors(W, W @ np.array([2.0, -3.0])), method=method)
    assert fit.status == "ok"
    assert np.allclose(fit.parameters, [2.0, -3.0], rtol=1e-13)
    assert np.all(fit.standard_deviations < 1e-12)
    nothing = estimate(triangular_factors(W, np.zeros((2, 30))), method=method)
    assert np.array_equal(nothing.parameters, [0.0, 0.0])


def test_one_exact_equation_among_noisy_ones():
    W, y = noisy(7, equations=2)
    y[0] = W[0] @ np.array([1.0, 2.0, 3.0])
    fit = estimate(triangular_factors(W, y))
    assert np.allclose(fit.parameters, [1.0, 2.0, 3.0], rtol=1e-12)
    assert np.all(np.isfinite(fit.covariance))


@pytest.mark.parametrize("rows", [0, 1, 2, 3])
def test_too_few_rows_is_a_status(rows):
    W, y = noisy(8, rows=3)
    fit = estimate(triangular_factors(W[:, :rows], y[:, :rows]))
    assert fit.status == "too_few_rows"
    assert np.all(np.isnan(fit.standard_deviations))
    assert np.all(np.isnan(fit.parameters)) == (rows < 3)
    assert estimate(triangular_factors(*noisy(8, rows=4))).status == "ok"


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 2**32), st.lists(st.integers(-40, 40), min_size=3, max_size=3))
def test_units_scale_parameters_and_deviations_inversely(seed, exponents):
    W, y = noisy(seed, equations=2, rows=50)
    scales = 2.0 ** np.array(exponents)
    plain, scaled = estimate(triangular_factors(W, y)), estimate(triangular_factors(W * scales, y))
    assert np.allclose(scaled.parameters * scales, plain.parameters, rtol=1e-12)
    assert np.allclose(scaled.standard_deviations * scales, plain.standard_deviations, rtol=1e-10)
    assert np.isclose(scaled.condition_number_scaled, plain.condition_number_scaled)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32), st.integers(-30, 30))
def test_unit_of_an_equation_does_not_matter_to_weighted_least_squares(seed, exponent):
    W, y = noisy(seed, equations=2, rows=50)
    units = np.array([1.0, 2.0**exponent])
    plain = estimate(triangular_factors(W, y))
    scaled = estimate(triangular_factors(W * units[:, None, None], y * units[:, None]))
    assert np.allclose(scaled.parameters, plain.parameters, rtol=1e-11)
    assert np.allclose(scaled.covariance, plain.covariance, rtol=1e-9, atol=1e-14)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32), st.randoms(use_true_random=False))
def test_order_of_rows_does_not_matter(seed, random):
    W, y = noisy(seed, rows=40)
    order = list(range(40))
    random.shuffle(order)
    plain, shuffled = (
        estimate(triangular_factors(W, y)),
        estimate(triangular_factors(W[:, order], y[:, order])),
    )
    assert np.allclose(shuffled.parameters, plain.parameters, rtol=1e-12)
    assert np.allclose(shuffled.covariance, plain.covariance, rtol=1e-10)


def test_refinement_leaves_a_good_fit_and_mends_a_poor_one():
    W, y = noisy(9, equations=2)
    valid = np.random.default_rng(1).random(200) > 0.2
    fit = estimate(triangular_factors(W, y, valid))
    assert np.allclose(
        refine_blocks([ObservationBlock(W, y, valid)], fit).parameters, fit.parameters, rtol=1e-13
    )
    t = np.linspace(0.0, 1.0, 300)
    hard = np.stack([t**k for k in range(7)], axis=1)[None]
    fit = estimate(triangular_factors(hard, hard.sum(axis=2)))
    refined = refine_blocks([ObservationBlock(hard, hard.sum(axis=2))], fit)
    errors = [np.max(np.abs(f.parameters - 1.0)) for f in (fit, refined)]
    assert errors[1] <= errors[0]


def test_relative_standard_deviation_of_a_parameter_that_is_zero():
    assert relative_standard_deviation(np.array([0.0, -2.0]), np.array([1.0, 1.0])).tolist() == [np.inf, 50.0]


def test_results_are_read_only():
    fit = estimate(triangular_factors(*noisy(10)))
    with pytest.raises(ValueError, match="read-only"):
        fit.parameters[0] = 0.0


def test_wrong_settings_are_refused():
    factor = TriangularFactor.empty(1)
    with pytest.raises(SettingError, match="no equation"):
        estimate([])
    with pytest.raises(SettingError, match="a column for each parameter"):
        estimate([factor, TriangularFactor.empty(2)])
    with pytest.raises(SettingError, match="unknown"):
        estimate([factor], method="lasso")
    with pytest.raises(SettingError, match="ddof"):
        estimate([factor], ddof=-1)
