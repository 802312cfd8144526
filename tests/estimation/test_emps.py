"""The published estimate of the EMPS axis (Janot, Gautier, Brunot: Data Set and Reference Models of EMPS)."""

import math
from pathlib import Path

import numpy as np
import pytest
import scipy.io
from scipy import signal

from symid.estimation.corrected_covariance import corrected_covariance
from symid.estimation.least_squares import estimate
from symid.estimation.triangular import triangular_factors

_LOG = Path(__file__).parents[2] / "data" / "emps" / "DATA_EMPS.mat"


def observation():
    """W and y as the data set's authors make them: 100 Hz low-pass, central differences, decimation by 10."""
    log = scipy.io.loadmat(_LOG)
    position, force = log["qm"].ravel(), 35.15065188248547 * log["vir"].ravel()
    q = signal.sosfiltfilt(signal.butter(4, 100 / 500, output="sos"), position, padtype="odd", padlen=12)
    v = np.gradient(q, 1e-3)
    columns = np.stack([np.gradient(v, 1e-3), v, np.sign(v), np.ones_like(v), force])[:, 49:]
    samples = columns.shape[1]
    first = 10 - (10 * math.ceil(samples / 10) - samples) - 1
    low_pass = signal.cheby1(8, 0.05, 0.8 / 10, output="sos")
    filtered = signal.sosfiltfilt(low_pass, columns, axis=1, padtype="odd", padlen=24)[:, first::10]
    return filtered[None, :4].transpose(0, 2, 1), filtered[None, 4]


def test_published_figures():
    factors = triangular_factors(*observation())
    fit = estimate(factors, method="ols", ddof=1)  # the authors divide by rows - 1
    assert fit.parameters == pytest.approx([95.1089, 203.5034, 20.3935, -3.1648], abs=1e-4)
    assert fit.standard_deviations == pytest.approx([0.1085, 1.1460, 0.1012, 0.0444], abs=1e-4)
    assert fit.sigma_rho == pytest.approx(2.1843, abs=1e-4)
    assert fit.condition_number == pytest.approx(25.9883, abs=1e-4)
    assert fit.condition_number_scaled == pytest.approx(4.3297, abs=1e-4)
    assert 100.0 * fit.relative_error == pytest.approx(4.0834, abs=1e-4)
    own = estimate(factors, method="ols").standard_deviations
    assert own == pytest.approx([0.10854594, 1.14672183, 0.10128888, 0.04439907], rel=1e-6)


def test_residual_of_the_real_axis_is_far_from_white():
    W, y = observation()
    fit = estimate(triangular_factors(W, y))
    corrected = corrected_covariance(W, y, fit)
    assert np.all(corrected.standard_deviations > 1.5 * fit.standard_deviations)
    assert corrected.effective_samples < 0.5 * y.size
