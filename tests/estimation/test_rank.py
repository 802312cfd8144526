"""What is determined, what only in combination; decisions that do not depend on units."""

import numpy as np
from hypothesis import given, settings, strategies as st

from symid.estimation.least_squares import estimate
from symid.estimation.triangular import triangular_factors


def fit_of(W, y):
    return estimate(triangular_factors(W[None], y[None]))


def columns(seed, rows, count):
    return np.random.default_rng(seed).standard_normal((rows, count))


def test_tied_columns_leave_one_combination_and_the_rest_untouched():
    free = columns(0, 200, 3)
    W = np.column_stack([free[:, 0], free[:, 1], 2.0 * free[:, 0], free[:, 2]])  # x0 + 2 x2 is determined
    fit = fit_of(W, W @ np.array([3.0, -1.0, 5.0, 7.0]))
    assert fit.status == "rank_deficient"
    assert fit.undetermined == (0, 2)
    assert np.allclose(fit.parameters, [np.nan, -1.0, np.nan, 7.0], equal_nan=True)
    assert np.array_equal(np.isnan(fit.standard_deviations), [True, False, True, False])
    assert np.allclose(fit.combinations, [[1.0, 0.0, 2.0, 0.0]])
    assert np.allclose(fit.combinations @ fit.solution, [13.0])
    assert np.allclose(fit.rank.null_space.T, [[-2.0, 0.0, 1.0, 0.0]])


def test_independent_ties_stay_apart():
    a, b = columns(1, 100, 2).T
    fit = fit_of(np.column_stack([a, b, -a, 3.0 * b]), a + b)
    assert fit.rank.rank == 2
    assert np.allclose(fit.combinations, [[1.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 3.0]])
    assert np.array_equal(fit.combinations == 0.0, np.isclose(fit.combinations, 0.0))


def test_column_of_zeros_is_undetermined_by_itself():
    W = columns(2, 50, 2)
    W[:, 0] = 0.0
    fit = fit_of(W, 4.0 * W[:, 1])
    assert fit.undetermined == (0,)
    assert fit.combinations.shape == (0, 2)
    assert np.isclose(fit.parameters[1], 4.0)
    assert fit.condition_number == np.inf


def test_independent_columns_leave_no_combination():
    fit = fit_of(columns(3, 50, 2), np.arange(50.0))
    assert fit.rank.null_space.shape == (2, 0)
    assert fit.combinations.shape == (0, 2)


def test_nothing_at_all_is_a_status():
    fit = fit_of(np.zeros((20, 2)), np.zeros(20))
    assert (fit.status, fit.rank.rank, fit.undetermined) == ("rank_deficient", 0, (0, 1))
    assert np.all(np.isnan(fit.parameters))


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32), st.lists(st.integers(-12, 12), min_size=4, max_size=4))
def test_rank_decisions_do_not_depend_on_units(seed, decades):
    W = columns(seed, 40, 4)
    W[:, 2] = W[:, 0] + 0.5 * W[:, 1]
    scales = 10.0 ** np.array(decades)
    plain, scaled = fit_of(W, W.sum(axis=1)), fit_of(W * scales, W.sum(axis=1))
    assert plain.undetermined == scaled.undetermined == (0, 1, 2)
    assert np.isclose(scaled.parameters[3] * scales[3], 1.0)
    assert np.allclose(plain.combinations, [[1.0, 0.0, 1.0, 0.0], [0.0, 1.0, 0.5, 0.0]], atol=1e-9)
    in_plain_units = scaled.combinations / scales * scales[[0, 1], None]
    assert np.allclose(in_plain_units, plain.combinations, atol=1e-9)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32))
def test_null_space_and_combinations_are_what_they_say(seed):
    rng = np.random.default_rng(seed)
    W = rng.standard_normal((60, 3)) @ rng.standard_normal((3, 5))
    fit = fit_of(W, rng.standard_normal(60))
    assert fit.rank.rank == 3
    assert np.allclose(W @ fit.rank.null_space, 0.0, atol=1e-8 * np.abs(fit.rank.null_space).max())
    assert np.allclose(
        fit.combinations @ fit.rank.null_space, 0.0, atol=1e-7 * np.abs(fit.combinations).max()
    )
    assert len(fit.combinations) == len(fit.undetermined) - 2
    minimum = np.linalg.norm(fit_of(W @ np.eye(5)[:, :3], np.zeros(60)).residual_norm)  # any subset: no worse
    assert minimum <= fit.y_norm[0]


def test_combination_is_the_grouped_parameter_and_leaves_the_deviation_of_others():
    a, b = columns(3, 80, 2).T
    y = a + 2 * b + columns(4, 80, 1)[:, 0]
    tied, grouped = fit_of(np.column_stack([a, b, a]), y), fit_of(np.column_stack([a, b]), y)
    assert np.allclose(tied.combinations @ tied.solution, grouped.parameters[0])
    assert np.isclose(tied.standard_deviations[1], grouped.standard_deviations[1])


def test_a_direction_at_the_limit_of_rounding_leaves_no_rank_without_undetermined_parameters():
    """Beside a singular value just above the tolerance the null space is known to nothing; that is not "ok"."""
    U, _, V = np.linalg.svd(columns(5, 90, 4), full_matrices=False)
    for least in np.geomspace(1e-13, 3e-14, 8):
        fit = fit_of(U * [1.0, 0.5, least, 1e-17] @ V, columns(6, 90, 1)[:, 0])
        assert (fit.status == "ok") == (fit.rank.rank == 4)
        assert len(fit.undetermined) >= 4 - fit.rank.rank
