"""Covariance under a correlated residual: against its definition, in blocks, and by its coverage."""

import numpy as np
import pytest
from scipy import signal, stats

from symid.errors import SettingError
from symid.estimation.corrected_covariance import (
    ObservationBlock,
    corrected_covariance,
    corrected_covariance_of_blocks,
)
from symid.estimation.correlation import ResidualCovariance, correlation_length, flat_top
from symid.estimation.least_squares import estimate, residuals
from symid.estimation.triangular import triangular_factors


def coloured(seed, rows=400, moving=(1.0, 0.8, 0.4)):
    """Two equations with noise that is correlated over time and between them; smooth columns; a mask."""
    rng = np.random.default_rng(seed)
    W = 0.1 * rng.standard_normal((2, rows, 3)).cumsum(axis=1)
    W[1, :, 0] = 0.0
    e = signal.lfilter(moving, [1.0], rng.standard_normal((2, rows)))
    y = W @ np.array([1.0, 2.0, 3.0]) + np.stack([e[0], 3.0 * e[1] + e[0]])
    return W, y, rng.random((2, rows)) > 0.1


def test_lagged_covariances_are_means_over_valid_pairs():
    W, y, valid = coloured(0, rows=60)
    rho = residuals(W, y, estimate(triangular_factors(W, y, valid)))
    gamma = ResidualCovariance.empty(2, 10).update(np.where(valid, rho, np.nan), valid).covariance()
    for i, j, k in np.ndindex(2, 2, 21):
        pairs = [(t, t + k - 10) for t in range(60) if 0 <= t + k - 10 < 60]
        products = [rho[i, t] * rho[j, s] for t, s in pairs if valid[i, t] and valid[j, s]]
        assert gamma[i, j, k] == pytest.approx(np.mean(products), abs=1e-12)


@pytest.mark.parametrize("moving", [(1.0, 0.8, 0.4), (1.0,), (1.0, -2.0, 1.0)])
def test_equals_its_definition(moving):
    W, y, valid = coloured(1, rows=250, moving=moving)
    fit = estimate(triangular_factors(W, y, valid))
    corrected = corrected_covariance(W, y, fit, valid, max_lag=40)
    gamma = ResidualCovariance.empty(2, 40).update(residuals(W, y, fit), valid).covariance()
    taper = flat_top(40, correlation_length(gamma, max(fit.rows)))
    S = fit.weights[:, None, None] * np.where(valid[..., None], W, 0.0)
    lag = np.arange(250)[None, :] - np.arange(250)[:, None]
    Gamma = np.where(np.abs(lag) <= 40, (gamma * taper)[:, :, np.clip(lag + 40, 0, 80)], 0.0)
    Gamma *= np.outer(fit.weights, fit.weights)[:, :, None, None]
    big = Gamma.transpose(0, 2, 1, 3).reshape(500, 500)
    rows = S.reshape(500, 3)
    inverse = np.linalg.inv(rows.T @ rows)
    expected = inverse @ rows.T @ big @ rows @ inverse
    ratio = np.diag(corrected.covariance) / np.diag(expected)
    # corrected for what the fit absorbs; larger where the spectrum had to be clipped
    assert np.all(ratio > 0.99)
    assert np.all(ratio < (1.15 if len(moving) < 3 or moving[1] > 0 else 4.0))
    assert corrected.status == "ok"


@pytest.mark.parametrize("cuts", [(200,), (1, 2, 3, 50, 51, 300), tuple(range(7, 400, 7))])
def test_blocks_give_the_same_as_memory(cuts):
    W, y, valid = coloured(2)
    fit = estimate(triangular_factors(W, y, valid))
    parts = [slice(a, b) for a, b in zip((0, *cuts), (*cuts, 400), strict=True)]
    blocks = [ObservationBlock(W[:, part], y[:, part], valid[:, part]) for part in parts]
    one, many = corrected_covariance(W, y, fit, valid), corrected_covariance_of_blocks(lambda: blocks, fit)
    assert many.bandwidth == one.bandwidth
    assert np.allclose(many.covariance, one.covariance, rtol=1e-10)


def test_long_records_are_cut_into_windows_without_loss():
    rng = np.random.default_rng(3)
    e = signal.lfilter([1.0, 1.0, 1.0], [1.0], rng.standard_normal(150_000))
    W = np.stack([np.ones(150_000), np.sin(np.arange(150_000) / 3000.0)], axis=1)[None]
    y = e[None] + W @ np.array([1.0, 2.0])
    fit = estimate(triangular_factors(W, y))
    corrected = corrected_covariance(W, y, fit)
    assert np.allclose(corrected.standard_deviations / fit.standard_deviations, np.sqrt(3.0), rtol=0.05)
    assert corrected.effective_samples == pytest.approx(150_000 / (1 + 2 * (4 / 9 + 1 / 9)), rel=0.03)


def test_logs_are_not_correlated_across_their_joint():
    W, y, _ = coloured(4, rows=300)
    fit = estimate(triangular_factors(np.tile(W, (1, 2, 1)), np.tile(y, (1, 2))))
    twice = corrected_covariance_of_blocks(
        lambda: [ObservationBlock(W, y, continues=False), ObservationBlock(W, y, continues=False)],
        fit,
        max_lag=50,
    )
    apart = (
        np.concatenate([np.zeros((2, 150, 3)), W], axis=1),
        np.concatenate([np.zeros((2, 150)), y], axis=1),
    )
    gap = np.arange(450) >= 150
    spaced = corrected_covariance(
        np.concatenate([W, apart[0]], axis=1),
        np.concatenate([y, apart[1]], axis=1),
        fit,
        np.concatenate([np.ones(300, dtype=bool), gap]),
        max_lag=50,
    )
    assert np.allclose(twice.covariance, spaced.covariance, rtol=1e-10)


def test_white_residual_changes_little_and_units_nothing():
    rng = np.random.default_rng(5)
    W = rng.standard_normal((1, 5000, 2))
    y = W @ np.ones(2) + rng.standard_normal((1, 5000))
    fit = estimate(triangular_factors(W, y))
    corrected = corrected_covariance(W, y, fit)
    assert np.allclose(corrected.standard_deviations, fit.standard_deviations, rtol=0.02)
    assert corrected.bandwidth == 1
    assert corrected.effective_samples == pytest.approx(5000.0)
    scaled = corrected_covariance(W * [1e6, 1e-6], y, estimate(triangular_factors(W * [1e6, 1e-6], y)))
    assert np.allclose(scaled.standard_deviations * [1e6, 1e-6], corrected.standard_deviations)


def test_the_unit_of_the_output_does_not_matter_to_a_correlated_residual():
    y = np.repeat(np.random.default_rng(7).standard_normal(2000), 2)[None]
    W = np.ones((1, 4000, 1))
    plain, small = (
        corrected_covariance(W, unit * y, estimate(triangular_factors(W, unit * y))) for unit in (1.0, 1e-6)
    )
    assert small.bandwidth == plain.bandwidth > 1
    assert small.standard_deviations == pytest.approx(1e-6 * plain.standard_deviations)


@pytest.mark.parametrize("samples", [400, 10_000])  # the widened bound is 0.63 and 0.16
def test_a_correlation_that_does_not_fall_has_no_length(samples):
    gamma = np.full((1, 1, 41), 0.6)
    gamma[0, 0, 20] = 1.0
    assert correlation_length(gamma, samples) is None


def test_statuses():
    rng = np.random.default_rng(6)
    t = np.arange(3000) / 1000.0
    W = np.stack([np.ones(3000), t], axis=1)[None]
    y = np.sin(40.0 * t)[None] + 0.01 * rng.standard_normal((1, 3000))
    fit = estimate(triangular_factors(W, y))
    assert corrected_covariance(W, y, fit).status == "correlation_persists"
    short = slice(0, 12)
    W, y = rng.standard_normal((1, 12, 8)), rng.standard_normal((1, 12))
    few = corrected_covariance(W[:, short], y[:, short], estimate(triangular_factors(W, y)))
    assert few.status == "too_few_samples"
    assert np.all(np.isnan(few.covariance))


def test_rank_deficiency_and_exact_fits_pass_through():
    a, b = np.random.default_rng(7).standard_normal((2, 300))
    W = np.column_stack([a, b, a])[None]
    y = (a + b)[None] + signal.lfilter([1.0, 1.0], [1.0], np.random.default_rng(8).standard_normal((1, 300)))
    corrected = corrected_covariance(W, y, estimate(triangular_factors(W, y)))
    assert np.array_equal(np.isnan(corrected.standard_deviations), [True, False, True])
    exact = estimate(triangular_factors(W[:, :, :2], (a + b)[None]))
    assert np.all(corrected_covariance(W[:, :, :2], (a + b)[None], exact).standard_deviations < 1e-12)


def test_an_observation_that_was_not_fitted_is_refused():
    W, y, valid = coloured(9)
    fit = estimate(triangular_factors(W, y, valid))
    with pytest.raises(SettingError, match="rows"):
        corrected_covariance(W, y, fit)
    with pytest.raises(SettingError, match="equations"):
        corrected_covariance(W[:1], y[:1], fit)


def test_intervals_hold_the_truth_as_often_as_they_say():
    """Low-passed force noise on a mass with friction: classical intervals are far too short."""
    rng = np.random.default_rng(20261121)
    t = np.arange(4000) / 1000.0
    v = 0.2 * np.cos(2 * np.pi * 0.5 * t) + 0.1 * np.cos(2 * np.pi * 1.7 * t + 1.0)
    low_pass = signal.butter(4, 40.0, fs=1000.0, output="sos")
    columns = np.stack([np.gradient(v, 0.001), v, np.sign(v)])
    W = signal.sosfiltfilt(low_pass, columns).T[None]
    true = np.array([95.0, 200.0, 20.0])
    hits = {"classical": np.zeros(3), "corrected": np.zeros(3)}
    for _ in range(150):
        noise = signal.sosfiltfilt(low_pass, 5.0 * rng.standard_normal(4000))
        y = (W[0] @ true + noise)[None]
        fit = estimate(triangular_factors(W, y))
        corrected = corrected_covariance(W, y, fit)
        error = np.abs(fit.parameters - true)
        t95 = stats.t.ppf(0.975, corrected.degrees_of_freedom)
        hits["classical"] += error <= 1.96 * fit.standard_deviations
        hits["corrected"] += error <= t95 * corrected.standard_deviations
    assert np.all(hits["classical"] < 0.6 * 150)
    assert np.all(hits["corrected"] >= 0.87 * 150)
    assert np.mean(hits["corrected"]) <= 0.99 * 150


def test_equations_of_each_log_are_those_of_all_with_the_others_left_empty():
    logs = [coloured(seed, rows=300 + 40 * seed) for seed in (3, 4, 5)]
    fit = estimate([factor for log in logs for factor in triangular_factors(*log)])
    own = [ObservationBlock(*log, continues=False, equation=2 * k) for k, log in enumerate(logs)]
    padded = []
    for k, arrays in enumerate(logs):
        whole = [np.zeros((6, *array.shape[1:]), dtype=array.dtype) for array in arrays]
        for array, among in zip(arrays, whole, strict=True):
            among[2 * k : 2 * k + 2] = array
        padded.append(ObservationBlock(*whole, continues=False))
    found, expected = (corrected_covariance_of_blocks(lambda rows=rows: rows, fit) for rows in (own, padded))
    np.testing.assert_allclose(found.covariance, expected.covariance, rtol=1e-9)
    assert found.effective_samples == pytest.approx(expected.effective_samples, rel=1e-9)
    assert (found.status, found.bandwidth) == (expected.status, expected.bandwidth)
