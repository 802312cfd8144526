"""Triangular factors: any splitting, order and layout of the rows gives the same least squares."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from symid.errors import SettingError
from symid.estimation.triangular import TriangularFactor, triangular_factors


def observation(seed, rows, columns):
    rng = np.random.default_rng(seed)
    return rng.standard_normal((rows, columns)), rng.standard_normal(rows)


def gram(factor):
    """[W y]'[W y], which does not depend on signs of rows of R."""
    return factor.R.T @ factor.R


def test_factor_has_the_normal_matrix_of_the_rows():
    W, y = observation(0, 100, 3)
    both = np.column_stack([W, y])
    assert np.allclose(gram(TriangularFactor.empty(3).update(W, y)), both.T @ both, rtol=1e-13, atol=1e-12)


def test_many_chunks_and_both_layouts_agree_with_numpy():
    W, y = observation(1, 150_000, 4)
    both = np.column_stack([W, y])
    expected = np.abs(np.linalg.qr(both, mode="r"))
    for layout in (np.ascontiguousarray(W), np.asfortranarray(W)):
        factor = TriangularFactor.empty(4).update(layout, y)
        assert np.allclose(np.abs(factor.R), expected, rtol=1e-12, atol=1e-10)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32), st.lists(st.integers(0, 60), max_size=3))
def test_splitting_into_blocks_does_not_matter(seed, cuts):
    W, y = observation(seed, 60, 3)
    parts = np.split(np.arange(60), sorted(cuts))
    blockwise = TriangularFactor.empty(3)
    for part in parts:
        blockwise = blockwise.update(W[part], y[part])
    assert blockwise.rows == 60
    whole = np.linalg.qr(np.column_stack([W, y]), mode="r")
    assert np.allclose(np.abs(blockwise.R), np.abs(whole), atol=1e-12)


@given(st.lists(st.integers(-60, 60), min_size=3, max_size=3))
@settings(max_examples=30, deadline=None)
def test_powers_of_two_scale_the_factor_digit_for_digit(exponents):
    W, y = observation(3, 50, 3)
    scales = 2.0 ** np.array(exponents)
    plain, scaled = TriangularFactor.empty(3).update(W, y), TriangularFactor.empty(3).update(W * scales, y)
    assert np.array_equal(scaled.R, plain.R * np.append(scales, 1.0))


def test_masked_rows_do_not_enter_whatever_they_hold():
    W, y = observation(4, 2 * 50_000, 3)
    valid = np.random.default_rng(5).random(len(y)) > 0.3
    expected = TriangularFactor.empty(3).update(W[valid], y[valid])
    W[~valid], y[~valid] = np.nan, np.inf
    masked = TriangularFactor.empty(3).update(W, y, valid)
    assert masked.rows == expected.rows
    assert np.allclose(masked.R, expected.R, atol=1e-10)


def test_one_factor_for_each_equation_with_a_common_or_separate_mask():
    W, y = np.ones((2, 5, 1)), np.ones((2, 5))
    common = np.array([True, True, False, False, False])
    assert [f.rows for f in triangular_factors(W, y, common)] == [2, 2]
    assert [f.rows for f in triangular_factors(W, y, np.stack([common, ~common]))] == [2, 3]


def test_factors_are_immutable():
    factor = TriangularFactor.empty(1)
    with pytest.raises(ValueError, match="read-only"):
        factor.R[0, 0] = 1.0
    factor.update(np.ones((3, 1)), np.ones(3))
    assert factor.rows == 0


@pytest.mark.parametrize(
    ("W", "y", "valid"),
    [
        (np.ones((3, 2)), np.ones(2), None),
        (np.ones((3, 1)), np.ones(3), None),
        (np.ones(3), np.ones(3), None),
        (np.ones((3, 2)), np.ones(3), np.ones(2, dtype=bool)),
        (np.full((3, 2), np.nan), np.ones(3), None),
        (np.ones((3, 2)), np.array([1.0, np.inf, 1.0]), None),
    ],
)
def test_wrong_blocks_are_refused(W, y, valid):
    with pytest.raises(SettingError):
        TriangularFactor.empty(2).update(W, y, valid)


def test_wrong_observations_are_refused():
    with pytest.raises(SettingError, match="n_equations"):
        triangular_factors(np.ones((3, 2)), np.ones(3))
    with pytest.raises(SettingError, match="bool"):
        triangular_factors(np.ones((1, 3, 2)), np.ones((1, 3)), np.ones(3))
    with pytest.raises(SettingError, match="square"):
        TriangularFactor(np.ones((2, 3)), 1)
    with pytest.raises(SettingError, match="at least one column"):
        TriangularFactor.empty(0)
