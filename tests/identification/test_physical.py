"""Physical parameters: branches, fitted overdetermined maps, propagated deviations against Monte Carlo."""

import numpy as np
import pytest

from symid import load_generated
from symid.identification import physical_estimates
from symid.identification.physical import jacobian

DIRECT = np.array([3899.0, 3949.17, 1e9, 362.58, 88.6, 146.0])  # the paper's Table 1
BALLSCREW = np.array([80.0, 120.0, 50.0, 6e6, 700.0, 200.0, 150.0])
LOAD_ON_MOTOR = np.array([3899.0, 3949.17, 1e9, 362.58, 88.6, 146.0, 4e7, 900.0, 60.0])


@pytest.mark.parametrize(
    ("axis", "measured", "truth"),
    [
        ("direct_2m1s", ("q2",), DIRECT),
        ("direct_2m1s", ("q2", "ddq1"), DIRECT),
        ("ballscrew_2m1s", ("qm",), BALLSCREW),
        ("direct_3m2s", ("q2", "ddq1"), LOAD_ON_MOTOR),
        ("direct_3m2s", ("q2", "ddql"), LOAD_ON_MOTOR),
    ],
)
def test_propagated_deviations_are_those_of_monte_carlo(
    axis: str, measured: tuple[str, ...], truth: np.ndarray
) -> None:
    """Draws of minimal parameters, each mapped back by itself, spread as the propagated covariance says."""
    model = load_generated(axis, measured)
    exact = model.minimal_parameters(*truth)
    rng = np.random.default_rng(3)
    mix = rng.standard_normal((exact.size, exact.size))
    correlation = mix @ mix.T + exact.size * np.eye(exact.size)
    correlation /= np.sqrt(np.outer(np.diag(correlation), np.diag(correlation)))
    size = 1e-5 * np.abs(exact)
    covariance = correlation * np.outer(size, size)
    propagated = physical_estimates(model, exact, covariance)[0].standard_deviations
    draws = exact + rng.multivariate_normal(np.zeros(exact.size), correlation, size=400) * size
    spread = np.std([_nearest(model, draw, covariance, truth) for draw in draws], axis=0, ddof=1)
    assert spread == pytest.approx(propagated, rel=0.15)


def _nearest(model: object, minimal: np.ndarray, covariance: np.ndarray, truth: np.ndarray) -> np.ndarray:
    branches = physical_estimates(model, minimal, covariance)
    return min((b.parameters for b in branches), key=lambda p: float(np.linalg.norm(p / truth - 1)))


def test_the_jacobian_is_that_of_central_differences() -> None:
    model = load_generated("direct_3m2s", ("q2",))
    exact = jacobian(model, LOAD_ON_MOTOR)
    for i, value in enumerate(LOAD_ON_MOTOR):
        step = np.zeros_like(LOAD_ON_MOTOR)
        step[i] = 1e-5 * value
        above, below = (model.minimal_parameters(*(LOAD_ON_MOTOR + s)) for s in (step, -step))
        assert exact[:, i] == pytest.approx(
            (above - below) / (2 * step[i]), rel=1e-5, abs=1e-12 * np.abs(exact[:, i]).max()
        )


def test_both_branches_of_a_map_give_the_same_minimal_parameters() -> None:
    model = load_generated("ballscrew_2m1s", ("qm",))
    exact = model.minimal_parameters(*BALLSCREW)
    branches = physical_estimates(model, exact, np.diag((1e-4 * exact) ** 2))
    assert len(branches) == 2
    for branch in branches:
        assert model.minimal_parameters(*branch.parameters) == pytest.approx(exact, rel=1e-9)
    assert any(branch.parameters == pytest.approx(BALLSCREW, rel=1e-6) for branch in branches)


def test_the_disagreement_of_an_overdetermined_map_follows_chi_square() -> None:
    """direct_2m1s from q2 has 7 minimal and 6 physical parameters: one relation."""
    model = load_generated("direct_2m1s", ("q2",))
    exact = model.minimal_parameters(*DIRECT)
    covariance = np.diag((1e-4 * exact) ** 2)
    rng = np.random.default_rng(11)
    draws = exact * (1 + 1e-4 * rng.standard_normal((300, exact.size)))
    found = [physical_estimates(model, draw, covariance)[0] for draw in draws]
    assert {estimate.relations for estimate in found} == {1}
    assert np.mean([estimate.disagreement for estimate in found]) == pytest.approx(1.0, abs=0.25)
    probabilities = np.array([estimate.disagreement_probability for estimate in found])
    assert np.mean(probabilities < 0.05) < 0.1
    wrong = exact * np.where(np.arange(exact.size) == 5, 1.01, 1.0)
    assert physical_estimates(model, wrong, covariance)[0].disagreement_probability < 1e-6


def test_without_closed_form_a_start_is_needed_and_enough() -> None:
    model = load_generated("direct_3m2s", ("q2",))
    exact = model.minimal_parameters(*LOAD_ON_MOTOR)
    covariance = np.diag((1e-5 * exact) ** 2)
    assert physical_estimates(model, exact, covariance) == ()
    start = dict(zip(model.physical_units, 1.1 * LOAD_ON_MOTOR, strict=True))
    (found,) = physical_estimates(model, exact, covariance, start)
    assert found.parameters == pytest.approx(LOAD_ON_MOTOR, rel=1e-6)


def test_a_covariance_that_is_singular_to_rounding_is_no_obstacle() -> None:
    model = load_generated("direct_2m1s", ("q2", "ddq1"))
    exact = model.minimal_parameters(*DIRECT)
    direction = 1e-9 * exact
    (found,) = physical_estimates(model, exact, np.outer(direction, direction))
    assert found.parameters == pytest.approx(DIRECT, rel=1e-9)
