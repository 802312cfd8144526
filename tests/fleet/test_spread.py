"""Spread between runs against a published meta-analysis, by hand, and by drawn runs."""

import numpy as np
import pytest

from symid.errors import SettingError
from symid.fleet.spread import judge_spread, spread_between

# Thirteen trials of BCG vaccine (Colditz et al. 1994): cases and others, vaccinated; cases and others, control.
BCG = np.array(
    [
        [4, 119, 11, 128],
        [6, 300, 29, 274],
        [3, 228, 11, 209],
        [62, 13536, 248, 12619],
        [33, 5036, 47, 5761],
        [180, 1361, 372, 1079],
        [8, 2537, 10, 619],
        [505, 87886, 499, 87892],
        [29, 7470, 45, 7232],
        [17, 1699, 65, 1600],
        [186, 50448, 141, 27197],
        [5, 2493, 3, 2338],
        [27, 16886, 29, 17825],
    ],
    dtype=float,
)


def test_bcg_log_relative_risks_as_published() -> None:
    """Q and the Q-profile interval of tau^2 as in metafor's own tests (test_misc_confint.r); tau^2 solves Q = K - 1."""
    a, b, c, d = BCG.T
    effect = np.log(a / (a + b)) - np.log(c / (c + d))
    variance = 1 / a - 1 / (a + b) + 1 / c - 1 / (c + d)
    found = spread_between(effect, np.sqrt(variance))
    assert found.statistic == pytest.approx(152.233, abs=1e-3)
    weight = 1 / (variance + found.between**2)
    assert weight @ (effect - np.average(effect, weights=weight)) ** 2 == pytest.approx(12.0)
    assert np.square(found.between_interval) == pytest.approx([0.1197, 1.1115], abs=1e-4)
    assert found.mean == pytest.approx(-0.715, abs=1e-3)
    assert found.mean_std == pytest.approx(0.181, abs=1e-3)


def test_bcg_log_odds_ratios_as_published() -> None:
    """The Q-profile interval is 0.130 to 1.181 in metafor's tests (test_analysis_example_vanhouwelingen2002.r)."""
    a, b, c, d = BCG.T
    found = spread_between(np.log(a * d / b / c), np.sqrt(1 / a + 1 / b + 1 / c + 1 / d))
    assert found.statistic == pytest.approx(163.165, abs=1e-3)
    assert np.square(found.between_interval) == pytest.approx([0.130, 1.181], abs=5e-4)


def test_equal_intervals_by_hand() -> None:
    """Values 1, 2, 6 with deviation 1: variance 7, so Q = 14 and tau^2 = 7 - 1; I^2 = 6/7."""
    found = spread_between([1.0, 2.0, 6.0], [1.0, 1.0, 1.0])
    assert (found.mean, found.statistic, found.between**2) == pytest.approx((3.0, 14.0, 6.0))
    assert found.probability == pytest.approx(np.exp(-7.0))  # chi-square with two degrees of freedom
    assert found.share == pytest.approx(6 / 7)
    assert found.mean_std == pytest.approx(np.sqrt(7 / 3))


def test_units_do_not_matter() -> None:
    draw = np.random.default_rng(0)
    x, s = 4 + 0.5 * draw.standard_normal(20), draw.uniform(0.1, 0.2, 20)
    plain = spread_between(x, s)
    for factor in (1e-160, 1e9, 1e140):
        scaled = spread_between(factor * x, factor * s)
        assert scaled.between / factor == pytest.approx(plain.between)
        assert scaled.statistic == pytest.approx(plain.statistic)


@pytest.mark.parametrize("runs", [5, 20, 200])
def test_false_alarms_are_as_rare_as_promised(runs: int) -> None:
    """Seven parameters that are always the same: 1 % of axes, with 99.9 % certainty at most 10 of 400."""
    draw = np.random.default_rng(runs)
    alarms = 0
    for _ in range(400):
        s = draw.uniform(0.5, 2.0, (7, runs))
        x = 50 + s * draw.standard_normal((7, runs))
        alarms += judge_spread({str(i): spread_between(x[i], s[i]) for i in range(7)}).differs
    assert alarms <= 10


@pytest.mark.parametrize("between", [1.0, 3.0])
def test_the_variance_between_runs_is_recovered_and_its_interval_holds_it(between: float) -> None:
    draw = np.random.default_rng(11)
    found = []
    for _ in range(300):
        s = draw.uniform(0.5, 2.0, 25)
        found.append(spread_between(draw.normal(10, np.hypot(s, between)), s))
    assert np.mean([one.between**2 for one in found]) == pytest.approx(between**2, rel=0.08)
    held = [one.between_interval[0] < between < one.between_interval[1] for one in found]
    assert 0.91 < np.mean(held) < 0.985
    means = [abs(one.mean - 10) < 2.06 * one.mean_std for one in found]
    assert 0.91 < np.mean(means) < 0.985


def test_the_verdict_names_the_parameter_that_differs() -> None:
    draw = np.random.default_rng(2)
    loose = spread_between(30 + 3 * draw.standard_normal(40), np.full(40, 0.3))
    steady = spread_between(5 + 0.1 * draw.standard_normal(40), np.full(40, 0.1))
    verdict = judge_spread({"M": steady, "Fs": loose})
    assert verdict.parameters == ("Fs",)
    assert "M" not in verdict.sentence.split("in ", 1)[1].split(":")[0]
    assert verdict.probabilities["Fs"] < 1e-10 < verdict.probabilities["M"]


def test_intervals_that_are_four_percent_too_narrow_are_no_difference() -> None:
    draw = np.random.default_rng(3)
    found = spread_between(1.04 * draw.standard_normal(20_000), np.ones(20_000))
    assert found.probability < 1e-4
    assert not judge_spread({"M": found}).differs


def test_too_few_runs_and_missing_values_are_no_errors() -> None:
    found = spread_between([1.0, 2.0, np.nan, 4.0], [0.1, 0.1, 0.1, np.nan])
    assert found.runs == 2
    assert found.mean == pytest.approx(1.5)
    assert judge_spread({"M": found}).sentence.startswith("not known: 2 runs")
    assert spread_between([], []).runs == 0
    assert judge_spread({}).sentence.startswith("not known")
    with pytest.raises(SettingError, match="one of each"):
        spread_between([1.0], [1.0, 2.0])
