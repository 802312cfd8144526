"""What a batch keeps beside the parameters: factors to join, units for the page; and logs longer than its memory."""

import json
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from command_line import run

import symid
from symid.codegen import GeneratedModel
from symid.data import LongLog
from symid.errors import SettingError
from symid.fleet import BatchSettings, identify_batch, join_results, read_results, units_in
from symid.fleet.kept_factors import FACTORS
from symid.identification import open_axis_log


def model_of(axis: str, sensors: tuple[str, ...]) -> GeneratedModel:
    return symid.load_generated(axis, sensors)


@pytest.mark.parametrize("name", ["r.parquet", "r.csv"])
def test_logs_are_joined_from_the_table_as_from_their_rows(logs: Path, name: str) -> None:
    identify_batch("rigid_1m", logs, output=name, settings=BatchSettings(joint=True), jobs=1)
    for file in logs.iterdir():
        file.unlink()  # nothing is read again
    joined = join_results(read_results(name), model_of)["rigid_1m"]
    assert len(joined.logs) == 6
    assert joined.status == "ok"
    assert joined.physical_parameters["M"] == pytest.approx(5.0, rel=0.01)


def test_joined_parameters_are_those_of_all_logs_together(logs: Path) -> None:
    batch = identify_batch("rigid_1m", logs, settings=BatchSettings(joint=True), jobs=1)
    joined = join_results(batch.table, model_of)["rigid_1m"]
    axis, every = symid.load_axis("rigid_1m"), sorted(logs.iterdir())
    read = [symid.read_axis_log(axis, file) for file in every]
    together = symid.identify(symid.load_generated("rigid_1m"), read)
    assert joined.fit.parameters == pytest.approx(together.fit.parameters, rel=1e-9)
    assert joined.fit.weights == pytest.approx(together.fit.weights, rel=1e-9)


def test_results_without_factors_say_how_to_get_them(logs: Path) -> None:
    plain = identify_batch("rigid_1m", logs / "0.parquet", jobs=1)
    assert FACTORS not in plain.table.columns
    with pytest.raises(SettingError, match="make the batch with `joint`"):
        join_results(plain.table, model_of)
    damaged = plain.table.with_columns(pl.lit("no factors").alias(FACTORS))
    with pytest.raises(SettingError, match="factors are damaged"):
        join_results(damaged, model_of)
    with pytest.raises(SettingError, match="leaves no factors"):
        BatchSettings(method="oe", joint=True)


def test_units_reach_the_review_and_its_page(logs: Path) -> None:
    assert (
        run("batch", "rigid_1m", "logs", "-o", "r.parquet", "--jobs", "1", "--joint", "--report", "b.html")
        == 0
    )
    assert units_in("r.parquet")["rigid_1m"]["q"]["Fv"] == "N*s/m"
    arguments = ("r.parquet", "--joint", "--axis", "rigid_1m", "--report", "f.html", "--json", "f.json")
    assert run("fleet", *arguments) == 0
    (axis,) = json.loads(Path("f.json").read_text())["axes"]
    assert axis["parameters"]["M"]["unit"] == axis["joint"]["parameters"]["M"]["unit"] == "kg"
    for page in ("b.html", "f.html"):
        assert '<span class="unit">N*s/m</span>' in Path(page).read_text()
    assert "Joined from 6 logs" in Path("f.html").read_text()


def test_logs_longer_than_memory_are_identified_in_blocks(
    logs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = identify_batch("rigid_1m", logs, output="r.parquet", jobs=1)
    opened = []
    original = open_axis_log

    def opening(*given: object, **named: object) -> object:
        opened.append(original(*given, **named))
        return opened[-1]

    monkeypatch.setattr("symid.fleet.work.open_axis_log", opening)
    blocks = identify_batch("rigid_1m", logs, settings=BatchSettings(memory=50_000), jobs=1)
    assert {type(log) for log in opened} == {LongLog}
    names = ["M", "Fv", "Fs", "M_std"]
    np.testing.assert_allclose(
        blocks.table.select(names).to_numpy(), whole.table.select(names).to_numpy(), rtol=1e-7
    )
    again = identify_batch("rigid_1m", logs, output="r.parquet", settings=BatchSettings(memory=10**8), jobs=1)
    assert again.reused == 6  # memory is no matter of the result
