"""Physical parameters: branches, fitted overdetermined maps, propagated deviations against Monte Carlo."""

import numpy as np
import pytest

from symid import load_generated
from symid.estimation import estimate, triangular_factors
from symid.identification import physical_estimates
from symid.identification.parameters.physical import jacobian
from symid.identification.results.status import identification_status

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


@pytest.mark.parametrize("factor", [1.0, 0.2, 6.0])
def test_a_map_without_closed_form_is_inverted_without_a_start(factor: float) -> None:
    """The load on the motor seen from q2 alone: 11 minimal and 9 physical parameters, several solutions."""
    model = load_generated("direct_3m2s", ("q2",))
    assert model.physical_parameters is None
    names = ["Ms", "Fvs", "Ks", "Mm", "Fvm", "Fsm", "Kl", "Fl", "Ml"]
    true = np.array([3899.0, 5000.0, 3.2e8, 362.6, 1500.0, 40.0, factor * 5e7, 2000.0, factor * 120.0])
    assert list(model.physical_units) == names
    exact = model.minimal_parameters(*true)
    branches = physical_estimates(model, exact, np.diag((1e-5 * exact) ** 2))
    assert any(branch.parameters == pytest.approx(true, rel=1e-4) for branch in branches)
    for branch in branches:
        assert not branch.negative(model)
        assert model.minimal_parameters(*branch.parameters) == pytest.approx(exact, rel=1e-4)


def test_two_sets_of_possible_values_are_no_ok_without_nominal_values() -> None:
    """The log of a load on the motor allows two machines; the likelier one may be the wrong one."""
    model = load_generated("direct_3m2s", ("q2",))
    exact = model.minimal_parameters(*LOAD_ON_MOTOR)
    branches = physical_estimates(model, exact, np.diag((1e-5 * exact) ** 2))
    assert len(branches) == 2
    rng = np.random.default_rng(0)
    W = rng.standard_normal((300, exact.size)) / exact
    fit = estimate(triangular_factors(W[None], (W @ exact + 1e-4 * rng.standard_normal(300))[None]))
    status, message = identification_status(model, fit, branches)
    assert status == "undetermined"
    assert message.startswith("2 sets of values fit the log alike (Ms ")
    assert identification_status(model, fit, branches, has_start=True)[0] == "ok"
    assert identification_status(model, fit, branches[:1])[0] == "ok"


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


def test_without_closed_form_a_start_chooses_among_the_solutions() -> None:
    model = load_generated("direct_3m2s", ("q2",))
    exact = model.minimal_parameters(*LOAD_ON_MOTOR)
    covariance = np.diag((1e-5 * exact) ** 2)
    searched = physical_estimates(model, exact, covariance)
    assert any(one.parameters == pytest.approx(LOAD_ON_MOTOR, rel=1e-4) for one in searched)
    start = dict(zip(model.physical_units, 1.1 * LOAD_ON_MOTOR, strict=True))
    (found,) = physical_estimates(model, exact, covariance, start)
    assert found.parameters == pytest.approx(LOAD_ON_MOTOR, rel=1e-6)


def test_a_covariance_that_is_singular_to_rounding_is_no_obstacle() -> None:
    model = load_generated("direct_2m1s", ("q2", "ddq1"))
    exact = model.minimal_parameters(*DIRECT)
    direction = 1e-9 * exact
    (found,) = physical_estimates(model, exact, np.outer(direction, direction))
    assert found.parameters == pytest.approx(DIRECT, rel=1e-9)


@pytest.mark.parametrize(
    "measured", [("q2",), ("q2", "ddq1"), ("q2", "ddql"), ("q2", "ddq1", "ddql")], ids=",".join
)
def test_proportional_damping_of_two_structures_is_no_obstacle(measured: tuple[str, ...]) -> None:
    """Fvs / Ks = Fl / Kl: no basis and no inverse map may divide by their difference."""
    model = load_generated("direct_3m2s", measured)
    values = {"Ms": 900.0, "Fvs": 3000.0, "Ks": 4e7, "Mm": 200.0, "Fvm": 150.0, "Fsm": 20.0}
    truth = np.array([{**values, "Kl": 6e7, "Fl": 4500.0, "Ml": 60.0}[name] for name in model.physical_units])
    minimal = model.minimal_parameters(*truth)
    first = physical_estimates(model, minimal, np.diag((1e-6 * minimal) ** 2))[0]
    assert first.parameters == pytest.approx(truth, rel=1e-9)
    assert np.all(first.standard_deviations < 1e-4 * truth)


def test_a_map_without_finite_values_names_what_noise_decides() -> None:
    """Not the structure is at fault where a minimal parameter in a denominator is nothing but noise."""
    model, random = load_generated("direct_2m1s", ("q2",)), np.random.default_rng(2)
    W = random.standard_normal((200, 7))
    for X2, cause in ((0.0, "noise decides on X2: move at other speeds"), (1.0, "the model, the filter,")):
        y = W @ [1.0, X2, 1.0, 1.0, 1.0, 1.0, 1.0] + 0.1 * random.standard_normal(200)
        status, message = identification_status(model, estimate(triangular_factors(W[None], y[None])), ())
        assert status == "no_physical_parameters"
        assert message.startswith(f"the inverse map gives no finite values: {cause}")
