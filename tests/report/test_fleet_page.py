"""The page of a fleet as a file: complete, self-contained, safe against hostile names."""

import json
import re

import polars as pl
import pytest
from fleet_example import fleet_example

from symid.fleet import review_fleet
from symid.report.pages.fleet_page import write_fleet_html

HOSTILE = "</script><script>window.hostile = 1</script><img src=x onerror='window.hostile = 1'>\"&"


@pytest.fixture(scope="module")
def table() -> pl.DataFrame:
    return fleet_example(60)


def written(table: pl.DataFrame, folder) -> str:
    file = folder / "fleet.html"
    write_fleet_html(review_fleet(table), file)
    return file.read_text(encoding="utf-8")


def embedded(page: str) -> dict:
    (text,) = re.findall(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)
    return json.loads(text)


def test_the_summary_comes_first_and_each_axis_has_its_charts(table, tmp_path) -> None:
    page, found = written(table, tmp_path), review_fleet(table)
    assert page.index(found.sentence) < page.index("<section")
    for axis in found.axes:
        assert axis.verdict.sentence[1:] in page
    assert page.count('class="chart"') == sum(len(axis.parameters) for axis in found.axes)
    assert page.count('class="step"') + page.count('class="drift"') == 2


def test_every_log_and_parameter_is_in_the_table(table, tmp_path) -> None:
    data = embedded(written(table, tmp_path))
    columns = {column["name"]: column for column in data["columns"]}
    assert data["count"] == table.height
    assert columns["log"]["values"] == table["log"].to_list()
    for name in ("M", "Ks", "Fc"):
        expected = [None if v is None else pytest.approx(v, rel=1e-6) for v in table[name]]
        assert columns[name]["values"] == expected
    assert columns["M"]["deviations"][0] == pytest.approx(table["M_std"][0], rel=1e-6)


def test_a_page_loads_nothing(table, tmp_path) -> None:
    page = written(table, tmp_path)
    assert not re.findall(r"<(?:link|img|iframe|object|embed|base|form)\b|\bsrc=|url\(|@import", page)


def test_hostile_names_stay_text(table, tmp_path) -> None:
    attacked = table.rename({"Fs": HOSTILE, "Fs_std": f"{HOSTILE}_std"}).with_columns(
        log=pl.lit(HOSTILE) + pl.col("log"),
        axis=pl.lit(HOSTILE) + pl.col("axis"),
        status=pl.when(pl.col("status") == "ok").then(pl.lit("ok")).otherwise(pl.lit(HOSTILE)),
        effect=pl.lit(HOSTILE),
        at=pl.lit(HOSTILE),
        verdict=pl.lit(HOSTILE),
    )
    page, benign = written(attacked, tmp_path), written(table, tmp_path)
    assert page.count("<script") == benign.count("<script")
    assert "<img" not in page
    assert embedded(page)["columns"][0]["values"][0].startswith(HOSTILE)


def test_rows_that_have_only_a_status_make_a_page(tmp_path) -> None:
    bare = pl.DataFrame({"log": ["a", "b"], "axis": ["emps", None], "status": ["unreadable", "clock"]})
    page = written(bare, tmp_path)
    assert "No log has parameters to compare" in page
    assert "nan" not in re.sub(r"<script.*?</script>", "", page, flags=re.DOTALL).lower()
    assert "There is no log." in written(bare.head(0), tmp_path)


def test_values_without_intervals_are_reported(table, tmp_path) -> None:
    bare = table.with_columns(pl.lit(None, pl.Float64).alias(n) for n in table.columns if n.endswith("_std"))
    assert "none with an interval" in written(bare, tmp_path)
