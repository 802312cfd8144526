"""Joint identification from triangular factors: equal to stacking all rows, weights and intervals as they promise."""

from dataclasses import replace

import numpy as np
import pytest

from symid import Log, Preparation, identify, load_generated
from symid.data import LongLog
from symid.errors import SettingError
from symid.estimation import TriangularFactor
from symid.fleet import identify_jointly, log_factors
from symid.fleet.factors import LogFactors

MODEL = load_generated("rigid_1m")
TRUTH = np.array([5.0, 1.0, 2.0])
PREPARATION = Preparation(cutoff_hz=60.0, decimation=4)


def run(seed: int, noise: float, mass: float = 5.0) -> Log:
    """A run of a rigid axis with noise of the force only."""
    draw = np.random.default_rng(seed)
    t, (a, b) = np.arange(2500) / 1000, draw.uniform(0, 2 * np.pi, 2)
    q = np.sin(9 * t + a) + 0.3 * np.sin(23 * t + b)
    v = 9 * np.cos(9 * t + a) + 6.9 * np.cos(23 * t + b)
    acceleration = -81 * np.sin(9 * t + a) - 158.7 * np.sin(23 * t + b)
    force = mass * acceleration + v + 2 * np.sign(v) + noise * draw.standard_normal(t.size)
    return Log.from_arrays({"q": q, "F": force}, sampling_period=1e-3)


def alone(log: Log):
    return identify(MODEL, log, preparation=PREPARATION, examine=False)


def test_factors_alone_give_what_stacked_weighted_rows_give() -> None:
    found = [alone(run(1, 0.3)), alone(run(2, 3.0)), alone(run(3, 12.0))]
    joined = identify_jointly(MODEL, [log_factors(one) for one in found])
    rows, outputs = [], []
    for one in found:
        (seen,) = one.observations
        W, y = seen.W[0][seen.valid[0]], seen.y[0][seen.valid[0]]
        own = np.linalg.lstsq(W, y, rcond=None)[0]
        sigma = np.sqrt(np.sum((y - W @ own) ** 2) / (len(y) - 3))
        rows.append(W / sigma)
        outputs.append(y / sigma)
    expected = np.linalg.lstsq(np.vstack(rows), np.concatenate(outputs), rcond=None)[0]
    assert joined.fit.parameters == pytest.approx(expected, rel=1e-9)


def test_the_command_for_several_logs_gives_the_same() -> None:
    logs = [run(4, 0.5), run(5, 5.0)]
    together = identify(MODEL, logs, preparation=PREPARATION, examine=False)
    joined = identify_jointly(MODEL, [log_factors(alone(log)) for log in logs])
    assert joined.fit.parameters == pytest.approx(together.fit.parameters, rel=1e-9)
    assert joined.fit.weights == pytest.approx(together.fit.weights, rel=1e-9)
    assert joined.standard_deviations == pytest.approx(together.standard_deviations, rel=0.25)


def test_weights_are_each_logs_own_noise() -> None:
    levels = (0.5, 2.0, 8.0)
    found = [alone(run(10 + i, level)) for i, level in enumerate(levels)]
    joined = identify_jointly(MODEL, [log_factors(one) for one in found])
    sigmas = joined.fit.sigma_rho_equation
    assert sigmas == pytest.approx([one.fit.sigma_rho_equation[0] for one in found], rel=1e-9)
    assert joined.fit.weights == pytest.approx(1 / sigmas)


def test_intervals_hold_the_truth_as_often_as_they_promise() -> None:
    """Noise that the filter has made dependent; 25 draws of three logs, two standard deviations."""
    inside, disagreements = [], []
    names = list(MODEL.minimal_units)
    truth = identify(MODEL, run(0, 0.0), preparation=PREPARATION, examine=False)
    for draw in range(25):
        found = [alone(run(1000 + 3 * draw + k, 10.0 * 2**k)) for k in range(3)]
        joined = identify_jointly(MODEL, [log_factors(one) for one in found])
        error = joined.fit.parameters - truth.fit.parameters
        inside.append(np.abs(error) < 2 * joined.standard_deviations)
        disagreements.append(joined.disagreement_probability)
    coverage = np.mean(inside, axis=0)
    assert np.all((coverage > 0.8) & (coverage <= 1.0)), dict(zip(names, coverage, strict=True))
    assert np.mean(np.array(disagreements) < 0.05) < 0.2


def test_an_axis_that_differs_from_run_to_run_disagrees_and_the_mean_says_by_how_much() -> None:
    masses = 5 + 0.2 * np.random.default_rng(3).standard_normal(16)
    each = [alone(run(k, 1.0, mass)) for k, mass in enumerate(masses)]
    joined = identify_jointly(MODEL, [log_factors(one) for one in each])
    assert joined.disagreement_probability < 1e-6
    wanted = np.std(masses, ddof=1) / np.sqrt(masses.size)  # of a mean
    assert wanted > 20 * max(one.physical_deviations[0] for one in each) / np.sqrt(masses.size)
    assert joined.physical_deviations[0] == pytest.approx(wanted, rel=0.2)
    assert joined.to_frame()["std"].to_list()[3] == joined.physical_deviations[0]


def test_more_logs_average_noise_out_but_no_systematic_error() -> None:
    error = np.array([0.02, -0.3, 0.1])
    kept = [log_factors(alone(run(k, 1.0))) for k in range(40)]
    biased = [replace(one, systematic=np.outer(error, error)) for one in kept]
    noise, whole = (identify_jointly(MODEL, logs).standard_deviations for logs in (kept, biased))
    assert whole**2 == pytest.approx(noise**2 + error**2)


def test_a_log_keeps_the_deviations_that_its_identification_prints() -> None:
    """With a friction that the model lacks, what it may change is most of that of the mass."""
    log = run(1, 0.05)
    force = log["F"] + 1.5 * np.sign(log["q"]) * np.abs(log["q"])
    found = identify(MODEL, replace(log, signals={**log.signals, "F": force}), preparation=PREPARATION)
    kept = log_factors(found)
    assert found.standard_deviations[0] > 2 * found.sampling_deviations[0]
    assert np.sqrt(np.diag(kept.covariance + kept.systematic)) == pytest.approx(
        found.standard_deviations, rel=1e-6
    )


def test_a_log_that_is_read_in_blocks_brings_all_its_rows() -> None:
    log = run(6, 1.0)
    whole, blocks = (log_factors(alone(one)) for one in (log, LongLog.of(log, block=500)))
    assert blocks.factors[0].rows == whole.factors[0].rows
    joined, expected = (identify_jointly(MODEL, [one]) for one in (blocks, whole))
    assert joined.fit.parameters == pytest.approx(expected.fit.parameters, rel=1e-9)


def test_a_log_that_cannot_stand_alone_adds_what_it_knows() -> None:
    draw = np.random.default_rng(7)
    W = draw.standard_normal((500, 3))
    still = W.copy()
    still[:, 2] = still[:, 1]
    logs = []
    for name, rows in (("full", W), ("dependent", still)):
        y = rows @ TRUTH + 0.1 * draw.standard_normal(500)
        covariance = np.full((3, 3), np.nan)
        kept = (TriangularFactor.empty(3).update(rows, y),)
        logs.append(LogFactors(name, kept, covariance, np.zeros((3, 3))))
    only, both = identify_jointly(MODEL, logs[:1]), identify_jointly(MODEL, logs)
    assert both.status == "ok"
    assert np.all(both.standard_deviations < only.standard_deviations)
    assert both.degrees_of_freedom == 0


def test_mistakes_are_reported() -> None:
    with pytest.raises(SettingError, match="no log"):
        identify_jointly(MODEL, [])
    factor = TriangularFactor.empty(2)
    with pytest.raises(SettingError, match="1 equations of 3 parameters"):
        identify_jointly(MODEL, [LogFactors("other", (factor,), np.eye(2), np.eye(2))])
    with pytest.raises(SettingError, match="identify each log alone"):
        log_factors(identify(MODEL, [run(1, 1.0), run(2, 1.0)], examine=False))


@pytest.mark.parametrize(("mass", "status"), [(5.0, "ok"), (5.6, "poor_fit")])
def test_a_precise_log_of_another_mass_is_told_from_right_ones(mass: float, status: str) -> None:
    logs = [run(40, 0.02, mass), run(41, 2.0), run(42, 2.0)]
    each = [identify(MODEL, log) for log in logs]
    together, joined = identify(MODEL, logs), identify_jointly(MODEL, [log_factors(one) for one in each])
    assert {one.status for one in each} == {"ok"}
    assert (together.status, joined.status) == (status, status)
    assert all("M is " in one.message for one in (together, joined) if status != "ok")
