"""Densities against scipy's."""

import numpy as np
import pytest
import scipy.signal

from symid.signal_processing.density import incoherent_density, power_density


@pytest.mark.parametrize(("n", "segment"), [(4000, 512), (4001, 501), (1024, 1024), (700, 333)])
def test_density_is_that_of_scipy(n: int, segment: int) -> None:
    x = np.random.default_rng(3).normal(size=n).cumsum()
    frequency, density = power_density(x, 250.0, segment)
    expected, own = scipy.signal.welch(x, 250.0, nperseg=segment)
    np.testing.assert_allclose(frequency, expected, rtol=1e-12)
    np.testing.assert_allclose(density, own, rtol=1e-9, atol=1e-12 * own.max())


def test_a_signal_may_be_a_row_of_a_table_of_columns() -> None:
    columns = np.random.default_rng(2).standard_normal((500, 3))
    of_column, of_copy = (power_density(x, 1.0, 64)[1] for x in (columns[:, 1], columns[:, 1].copy()))
    np.testing.assert_array_equal(of_column, of_copy)


def test_incoherent_density_of_one_signal_is_that_of_scipy() -> None:
    y, noise = np.random.default_rng(3).normal(size=(2, 4000))
    x = np.convolve(y, [1.0, -0.5], "same") + noise
    _, own = incoherent_density(x, y[None], 250.0, 200)
    coherence = scipy.signal.coherence(x, y, 250.0, nperseg=200)[1]
    expected = (1 - coherence) * scipy.signal.welch(x, 250.0, nperseg=200)[1] * 39 / 38  # of 39 segments
    np.testing.assert_allclose(own, expected, rtol=1e-9)


def test_what_two_signals_explain_together_is_left_out() -> None:
    y = np.random.default_rng(3).normal(size=(3, 50_000))
    x = 3.0 * y[0] - 2.0 * y[1] + 0.1 * y[2]
    _, by_both = incoherent_density(x, y[:2], 1.0, 200)
    _, by_one = incoherent_density(x, y[:1], 1.0, 200)
    assert by_both[1:-1].mean() / 2 == pytest.approx(0.01, rel=0.05)
    assert by_one[1:-1].mean() / 2 == pytest.approx(4.01, rel=0.05)
