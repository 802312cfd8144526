"""The density of a signal against scipy's."""

import numpy as np
import pytest
import scipy.signal

from symid.diagnosis.prediction.density import power_density


@pytest.mark.parametrize(("n", "segment"), [(4000, 512), (4001, 501), (1024, 1024), (700, 333)])
def test_density_is_that_of_scipy(n: int, segment: int) -> None:
    x = np.random.default_rng(3).normal(size=n).cumsum()
    frequency, density = power_density(x, 250.0, segment)
    expected, own = scipy.signal.welch(x, 250.0, nperseg=segment)
    np.testing.assert_allclose(frequency, expected, rtol=1e-12)
    np.testing.assert_allclose(density, own, rtol=1e-9, atol=1e-12 * own.max())
