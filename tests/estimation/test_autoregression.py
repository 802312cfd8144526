"""Whitening of the errors of several signals by an autoregressive model."""

import numpy as np

from symid.estimation.autoregression import autoregression


def test_whitening_leaves_white_noise_of_unit_deviation() -> None:
    random = np.random.default_rng(2)
    noise = random.standard_normal((20_000, 2)) @ np.array([[2.0, 0.5], [0.0, 1e-6]])
    errors = noise.copy()
    for k in range(2, len(errors)):
        errors[k] += 1.2 * errors[k - 1] - 0.5 * errors[k - 2]
    errors /= errors.std(axis=0)
    model = autoregression(errors.T, np.ones(len(errors), dtype=bool), order=4)
    white = model.by_sample(errors.ravel()).reshape(-1, 2)
    assert np.array_equal(white.T.ravel(), model.apply(errors.T))
    np.testing.assert_allclose(np.cov(white.T), np.eye(2), atol=0.03)
    for lag in (1, 2, 5):
        assert np.abs(white[lag:].T @ white[:-lag] / len(white)).max() < 0.03
