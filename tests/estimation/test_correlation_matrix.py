"""Correlations of covariances that a file may hold."""

import numpy as np

from symid.estimation.correlation import correlation_matrix


def test_what_is_beyond_all_numbers_has_no_correlation() -> None:
    found = correlation_matrix(np.array([[np.inf, 1.0], [1.0, 4.0]]))
    np.testing.assert_array_equal(found, [[np.nan, 0.0], [0.0, 1.0]])
