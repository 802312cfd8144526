"""The review of a table of results, and `symid fleet`."""

import json
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from command_line import run
from fleet_example import drawn_rows, fleet_example

from symid.errors import SettingError
from symid.fleet import review_fleet
from symid.fleet.results import read_results


@pytest.fixture(scope="module")
def table() -> pl.DataFrame:
    return fleet_example()


def by_name(table: pl.DataFrame, **options) -> dict:
    return {axis.name: axis for axis in review_fleet(table, **options).axes}


def test_each_axis_reports_what_was_drawn_into_it(table) -> None:
    axes = by_name(table)
    assert axes["rigid_1m"].verdict.parameters == ("Fs",)
    assert axes["emps"].verdict.parameters == ("Fc",)
    assert not axes["direct_2m1s"].verdict.differs
    changes = {
        (name, one.name, change.kind)
        for name, axis in axes.items()
        for one in axis.parameters
        for change in one.chart.changes
    }
    assert changes == {("rigid_1m", "Fs", "step"), ("emps", "Fc", "drift")}
    (step,) = next(one for one in axes["rigid_1m"].parameters if one.name == "Fs").chart.changes
    assert step.interval[0] < 9.0 < step.interval[1]
    assert step.when.isoformat() == "2026-01-25T06:00:00+00:00"


def test_an_outlying_log_is_named_and_no_spread_is_made_of_it(table) -> None:
    mass = next(one for one in by_name(table)["rigid_1m"].parameters if one.name == "M")
    (far,) = mass.outliers
    assert far.log.endswith("rigid_1m/run_0040.parquet")
    assert far.z > 5
    assert mass.spread.runs == len(mass.logs) - 1
    assert mass.spread.promised == pytest.approx(0.2, rel=0.1)


def test_logs_are_counted_by_status_and_only_good_ones_enter(table) -> None:
    found = review_fleet(table)
    assert sum(found.statuses.values()) == table.height
    assert found.statuses["ok"] == table.filter(pl.col("status") == "ok").height
    for axis in found.axes:
        assert axis.trusted == axis.statuses["ok"]
        assert all(len(one.logs) == axis.trusted for one in axis.parameters)
    assert sum(found.verdicts.values()) == table.height
    (effect,) = found.effects
    assert (effect.effect, effect.at, len(effect.axes)) == ("stribeck_friction", "motor", 3)
    assert effect.logs == table["effect"].count()


def test_other_statuses_enter_and_parameters_stay_out_if_asked_for(table) -> None:
    biased = table.with_columns(status=pl.lit("biased"))
    assert not any(axis.parameters for axis in review_fleet(biased).axes)
    axes = by_name(biased, statuses=("ok", "biased"), without=("Fs", "Fc"))
    assert {one.name for one in axes["rigid_1m"].parameters} == {"M", "Fv"}
    assert not axes["emps"].verdict.differs


def test_machines_of_one_axis_are_distinguished_by_folder_and_by_sensors() -> None:
    parts = []
    for seed, (folder, mass) in enumerate((("east", 20.0), ("west", 25.0))):
        rows = pl.DataFrame(drawn_rows("rigid_1m", 20, {"M": (mass, 0.1, 0.0)}, seed))
        parts.append(rows.with_columns(log=pl.format("{}/{}", pl.lit(folder), "content")))
    both = pl.concat(parts)
    assert by_name(both)["rigid_1m"].verdict.differs
    apart = by_name(both, by_folder=True)
    assert list(apart) == ["rigid_1m in east", "rigid_1m in west"]
    assert not any(axis.verdict.differs for axis in apart.values())
    sensors = both.with_columns(
        measured=pl.when(pl.col("M") > 22).then(pl.lit("q, ql")).otherwise(pl.lit("q"))
    )
    assert list(by_name(sensors)) == ["rigid_1m from q", "rigid_1m from q, ql"]


def test_rows_that_have_only_a_status_are_enough() -> None:
    bare = pl.DataFrame({"log": ["a", "b"], "axis": ["emps", None], "status": ["unreadable", "clock"]})
    found = review_fleet(bare)
    assert found.sentence == "2 logs of emps, 0 ok (1 unreadable, 1 clock)."
    assert review_fleet(bare.with_columns(axis=pl.lit(None, pl.String))).sentence.startswith(
        "2 logs of 0 axes"
    )
    assert all(axis.parameters == () for axis in found.axes)
    assert review_fleet(bare.head(0)).sentence == "No log."


def test_logs_that_failed_early_are_counted_with_the_only_axis_they_can_be_of(table) -> None:
    early = pl.col("status") != "ok"
    unknown = table.with_columns(
        axis=pl.when(early).then(None).otherwise(pl.col("axis")),
        measured=pl.when(early).then(None).otherwise(pl.col("measured")),
    )
    axes = by_name(unknown)
    assert len(axes) == 4
    assert axes["unknown axis"].statuses == {"unreadable": table.filter(early).height}
    axes = by_name(unknown, by_folder=True)
    assert len(axes) == 3
    assert all(axis.statuses["unreadable"] == 7 for axis in axes.values())


def test_a_minimal_parameter_that_is_a_physical_one_counts_once(table) -> None:
    twice = table.with_columns(X1=pl.col("M"), X1_std=pl.col("M_std")).select(
        "X1", "X1_std", pl.exclude("X1", "X1_std")
    )
    for name, axis in by_name(twice).items():
        assert [one.name for one in axis.parameters] == [one.name for one in by_name(table)[name].parameters]


def test_minimal_parameters_are_shown_only_where_they_say_more() -> None:
    rows = pl.DataFrame(drawn_rows("emps", 6, {"X1": (3.0, 0.1, 0.0), "M": (10.0, 0.1, 0.0)}))
    assert [one.name for one in review_fleet(rows).axes[0].parameters] == ["M"]
    units = {"emps": {"q": {"X1": "kg", "M": "kg", "K": "N/m"}}}  # no log determines K
    whole = review_fleet(rows.with_columns(measured=pl.lit("q")), units=units)
    assert [one.name for one in whole.axes[0].parameters] == ["X1", "M"]
    assert [one.name for one in review_fleet(rows.drop("M")).axes[0].parameters] == ["X1"]


def test_logs_without_a_time_come_in_their_order() -> None:
    rows = pl.DataFrame(drawn_rows("emps", 30, {"M": (10.0, 0.1, 0.0)}))
    rows = rows.with_columns(recorded=pl.lit(None, pl.String), M=pl.col("M") + (pl.int_range(30) >= 20) * 2.0)
    (axis,) = review_fleet(rows).axes
    assert [change.when for change in axis.parameters[0].chart.changes] == [20.0]


def test_names_give_the_order_where_copying_has_lost_the_times() -> None:
    rows = pl.DataFrame(drawn_rows("emps", 30, {"M": (10.0, 0.1, 0.0)}))
    rows = rows.with_columns(M=pl.col("M") + (pl.int_range(30) >= 20) * 2.0).sample(30, shuffle=True, seed=1)
    copied = rows.with_columns(recorded=pl.Series(drawn_rows("emps", 30, {})["recorded"]))
    (axis,) = review_fleet(copied, by_name=True).axes
    (change,) = axis.parameters[0].chart.changes
    assert axis.parameters[0].logs[change.log].endswith("run_0020.parquet")


def test_the_command_prints_and_writes_what_the_review_found(table, folder, monkeypatch, capsys) -> None:
    table.write_parquet("results.parquet")
    assert run("fleet", "results.parquet", "--json", "fleet.json", "--report", "fleet.html") == 0
    printed = capsys.readouterr().out
    record = json.loads(Path("fleet.json").read_text())
    assert record["sentence"] in printed
    for axis in record["axes"]:
        assert axis["verdict"] in printed
        for name, one in axis["parameters"].items():
            for change in one["changes"]:
                assert f"{name} {change['sentence']}" in printed
    (rail,) = (axis for axis in record["axes"] if axis["name"] == "rigid_1m")
    values = table.filter((pl.col("axis") == "rigid_1m") & (pl.col("status") == "ok"))["Fv"].to_numpy()
    assert rail["parameters"]["Fv"]["median"] == pytest.approx(np.median(values))
    assert Path("fleet.html").stat().st_size > 10_000


def test_csv_gives_the_same_review(table, tmp_path) -> None:
    table.write_csv(tmp_path / "results.csv")
    assert review_fleet(read_results(tmp_path / "results.csv")).sentence == review_fleet(table).sentence


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("results.txt", "", "unknown kind"),
        ("missing.parquet", None, "no such file"),
        ("broken.parquet", "no parquet", "cannot be read"),
        ("other.csv", "a,b\n1,2\n", "without column log, axis, status"),
    ],
)
def test_a_file_that_is_no_result_is_refused_in_one_line(name, content, message, tmp_path, capsys) -> None:
    file = tmp_path / name
    if content is not None:
        file.write_text(content)
    with pytest.raises(SettingError, match=message):
        read_results(file)
    assert run("fleet", str(file)) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_a_step_is_one_finding_and_not_an_outlier_for_each_log_behind_it() -> None:
    noise = np.random.default_rng(8).standard_normal(14)
    friction = np.where(np.arange(14) < 8, 60.0, 66.0) + 0.05 * noise
    friction[3] = 62.0  # one log that does stand off
    rows = {"Fs": friction, "Fs_std": np.full(14, 0.05)}
    logs = [f"{place:02}.parquet" for place in range(14)]
    (axis,) = review_fleet(pl.DataFrame({"log": logs, "axis": "rigid_1m", "status": "ok", **rows})).axes
    (found,) = axis.parameters
    assert [change.kind for change in found.chart.changes] == ["step"]
    (far,) = found.outliers
    assert (far.log, far.level) == ("03.parquet", pytest.approx(60.0, abs=0.1))
