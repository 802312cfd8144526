"""The quick part of the benchmarks: the paper's tables, and one cell of the grid of tuned settings."""

from dataclasses import replace

import pytest

from benchmarks import paper_tables as tables, tuning_grid as grid

SHORT = replace(tables.DEFAULT, seconds=3.0, rate=10_000.0)


@pytest.mark.parametrize(
    ("source", "printed"), [(3, tables.TABLE_4), (7, tables.TABLE_8), (9, tables.TABLE_10)]
)
def test_inverse_map_gives_the_physical_parameters_to_the_digits_printed(source, printed):
    for name, (value, _) in printed.items():
        _, low, high = tables.inverse_intervals(source)[name]
        assert low <= value * (1 + 1e-5), name
        assert high >= value * (1 - 1e-5), name


def test_errors_of_the_low_pass_are_within_the_bound_of_table_2_and_equal_as_there():
    errors = tables.low_pass_errors(SHORT).errors(tables.CUTOFF)
    assert max(map(abs, errors.values())) < 0.01
    assert errors["Ms"] == pytest.approx(errors["Mm"], rel=1e-3)
    assert errors["Ks"] == pytest.approx(errors["Fvs"], rel=1e-3)


@pytest.mark.parametrize("method", [2, 3])
def test_tuned_rate_keeps_the_errors_of_tables_5_and_6_at_one_percent(method):
    rate = tables.tuned_rate(method, SHORT)
    found = tables.identified(
        method, tables.chirp_run(SHORT).log(rate, tables.METHODS[method]), tables.CUTOFF
    )
    assert tables.worst(found, tables.PHYSICAL) == pytest.approx(1.0, abs=0.02)
    assert 2500 < rate < 3500


def test_trapezoids_at_8_khz_give_table_7_and_at_250_hz_lose_the_flexible_mode():
    run = tables.trapezoid_run(SHORT)
    fast = tables.identified(1, run.log(8000.0, ("q2",)), tables.CUTOFF)
    slow = tables.identified(1, run.log(250.0, ("q2",)), SHORT.slow_cutoff_hz)
    assert tables.worst(fast, tables.TABLE_7) < 2.0
    assert abs(tables.error("X4", slow["X4"])) < 0.2
    assert all(abs(tables.error(name, slow[name])) > 100 for name in ("X1", "X5", "X6"))
    assert abs(tables.error("Ks", slow["Ks"])) > 80


def test_rigid_model_is_within_the_errors_of_table_11():
    assert tables.worst(tables.rigid_estimate(SHORT), tables.TABLE_11) < 1.6


def test_tuned_setting_of_a_cell_is_near_the_best_with_hindsight(monkeypatch):
    monkeypatch.setattr(grid, "CUTOFFS", grid.CUTOFFS[::3])
    monkeypatch.setattr(grid, "FINALISTS", 4)
    monkeypatch.setattr(grid, "FINAL", (12, 6000))
    monkeypatch.setattr(grid, "JUDGE", (24, 9000))
    outcome = grid.evaluated(grid.cells(quick=True)[0])
    assert outcome.ratio < 1.1
    assert outcome.tuned < min(outcome.default, outcome.fixed)
