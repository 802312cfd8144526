"""Control charts of drawn series: false alarms, steps and drifts found, where, and with which interval."""

from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

from symid.errors import SettingError
from symid.fleet import ControlChart
from symid.fleet.control_chart import control_chart
from symid.fleet.segments import LEAST_LEVEL, Series, cut


def series(runs: int, between: float, seed: int) -> tuple[np.ndarray, np.ndarray, float]:
    """Values about 100, promised deviations, and the standard deviation of one run in all."""
    draw = np.random.default_rng(seed)
    s = draw.uniform(0.5, 1.5, runs)
    return 100 + draw.normal(0, np.hypot(s, between)), s, float(np.hypot(1.0, between))


def kinds(chart: ControlChart) -> list[str]:
    return [change.kind for change in chart.changes]


@pytest.mark.parametrize("runs", [8, 60, 200])
@pytest.mark.parametrize("between", [0.0, 3.0])
def test_a_series_without_change_seldom_shows_one(runs: int, between: float) -> None:
    draws = 60 if runs == 200 else 150
    alarms = sum(bool(control_chart(*series(runs, between, seed)[:2]).changes) for seed in range(draws))
    assert alarms / draws <= 0.06


def test_runs_beyond_the_limits_are_three_in_a_thousand() -> None:
    charts = [control_chart(*series(200, 2.0, seed)[:2]) for seed in range(50)]
    assert 0.001 < np.mean([chart.outside.mean() for chart in charts]) < 0.006


@pytest.mark.parametrize(("runs", "size"), [(20, 4.0), (60, 3.0), (200, 1.5)])
def test_a_step_is_found_where_it_is_and_as_large_as_it_is(runs: int, size: float) -> None:
    """In standard deviations of one run, two thirds into the series."""
    at, found, near, placed, sized = 2 * runs // 3, 0, 0, 0, 0
    draws = 40 if runs == 200 else 80
    for seed in range(draws):
        x, s, sigma = series(runs, 2.0, seed)
        chart = control_chart(x + size * sigma * (np.arange(runs) >= at), s)
        if kinds(chart) == ["step"]:
            (change,) = chart.changes
            found += 1
            near += abs(change.log - at) <= 3
            placed += change.earliest < at <= change.latest
            sized += change.interval[0] < size * sigma < change.interval[1]
    assert found >= 0.85 * draws
    assert near >= 0.85 * found
    assert placed >= 0.9 * found
    assert sized >= 0.87 * found


@pytest.mark.parametrize(("runs", "total"), [(40, 6.0), (200, 4.0)])
def test_wear_is_a_drift_and_not_a_stair(runs: int, total: float) -> None:
    found, sized = 0, 0
    draws = 50
    for seed in range(draws):
        x, s, sigma = series(runs, 2.0, seed)
        chart = control_chart(x + total * sigma * np.linspace(0, 1, runs), s)
        if kinds(chart) == ["drift"]:
            (change,) = chart.changes
            found += 1
            sized += change.interval[0] < total * sigma < change.interval[1]
    assert found >= 0.85 * draws
    assert sized >= 0.85 * found


def test_one_or_two_outliers_are_no_step_and_three_are() -> None:
    x, s, sigma = series(40, 1.0, 5)
    for count, expected in ((1, []), (2, []), (4, ["step"])):
        y = x.copy()
        y[-count:] += 12 * sigma
        assert kinds(control_chart(y, s)) == expected
        assert kinds(control_chart(np.roll(y, -15), s)) == expected * 2
    y = x.copy()
    y[20] += 12 * sigma
    chart = control_chart(y, s)
    assert chart.isolated[20]
    assert chart.outside[20]
    assert chart.between == pytest.approx(control_chart(x, s).between, rel=0.15)


def test_a_quiet_log_weighs_more_than_a_loud_one() -> None:
    values, deviations = np.array([10.0, 12.0] * 6), np.array([0.1, 10.0] * 6)
    chart = control_chart(values, deviations)
    assert chart.centre[0] == pytest.approx(10.0, abs=0.01)
    assert chart.limit[1] > 20 * chart.limit[0]
    assert not chart.outside.any()


def test_times_put_runs_in_order_and_date_the_step() -> None:
    x, s, sigma = series(40, 0.0, 9)
    x += np.where(np.arange(40) >= 25, 6 * sigma, 0.0)
    begin = datetime(2026, 3, 1, tzinfo=UTC)
    times = [begin + timedelta(days=i) for i in range(40)]
    shuffled = np.random.default_rng(1).permutation(40)
    chart = control_chart(x[shuffled], s[shuffled], [times[i] for i in shuffled])
    (change,) = chart.changes
    assert change.when == times[25]
    assert change.earliest <= times[24] < times[25] <= change.latest
    assert np.array_equal(shuffled[chart.order], np.arange(40))
    assert np.array_equal(chart.values, x)


def test_the_cut_is_the_best_of_all_cuts() -> None:
    """Every cut of a short series into levels, one by one."""
    draw = np.random.default_rng(4)
    for _ in range(20):
        x = draw.normal(0, 1, 12) + np.where(np.arange(12) >= draw.integers(3, 10), draw.normal(0, 4), 0)
        found = cut(Series(np.arange(12.0), x, np.ones(12)), slope_penalty=1e9)
        assert cost([s.first for s in found], x) == pytest.approx(min(cost(c, x) for c in every_cut(12)))


def every_cut(count: int) -> list[list[int]]:
    """Starts of segments of at least three points."""
    cuts = [[0]]
    for start in range(LEAST_LEVEL, count - LEAST_LEVEL + 1):
        cuts += [[*c, start] for c in cuts if start - c[-1] >= LEAST_LEVEL]
    return cuts


def cost(starts: list[int], x: np.ndarray) -> float:
    parts = np.split(x, starts[1:])
    step = 3 * np.log(len(x)) * (1 + 5 / len(x))
    return sum(p.var() * p.size + np.log(p.size / len(x)) for p in parts) + step * (len(parts) - 1)


def test_a_long_series_is_cut_to_the_run() -> None:
    x, s, sigma = series(4000, 0.0, 2)
    (change,) = control_chart(x + np.where(np.arange(4000) >= 2503, 8 * sigma, 0.0), s).changes
    assert change.log == 2503


def test_units_do_not_matter() -> None:
    x, s, _ = series(30, 2.0, 3)
    x[18:] += 12
    plain = control_chart(x, s)
    for factor in (1e-150, 1e12):
        scaled = control_chart(factor * x, factor * s)
        assert [c.log for c in scaled.changes] == [c.log for c in plain.changes]
        assert scaled.limit / factor == pytest.approx(plain.limit)
        assert scaled.changes[0].size / factor == pytest.approx(plain.changes[0].size)


def test_few_runs_equal_runs_and_equal_times_are_no_errors() -> None:
    assert control_chart([], []).changes == ()
    assert control_chart([1.0, np.nan], [0.1, 0.1]).values.tolist() == [1.0]
    assert control_chart([1.0] * 20, [0.1] * 20).between == 0.0
    at = [datetime(2026, 1, 1, tzinfo=UTC)] * 20
    assert control_chart(np.arange(20.0), np.ones(20), at).values.size == 20
    with pytest.raises(SettingError, match="3 times"):
        control_chart([1.0], [1.0], [datetime(2026, 1, 1, tzinfo=UTC)] * 3)


def test_a_deviation_that_is_none_leaves_its_run_out() -> None:
    x, s, _ = series(30, 2.0, 3)
    s[4] = 1e-320
    chart = control_chart(x, s)
    assert 4 not in chart.order
    assert np.isfinite(chart.centre).all()
    assert control_chart(x, np.full(30, 1e-320)).order.size == 0
