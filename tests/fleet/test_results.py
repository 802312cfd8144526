"""The table of a batch: each log once, alone as `identify` has it, bad ones with a status, the same in every form."""

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import polars as pl
import pytest
from command_line import run
from fleet_logs import write_log

import symid
from symid.errors import SettingError
from symid.fleet import BatchSettings, identify_batch, summary_of
from symid.fleet.plan import log_files
from symid.fleet.result_table import read_rows
from symid.fleet.results import UNITS_KEY

VOLATILE = ("seconds", "finished")  # columns that tell of the run, not of the log


def test_rows_are_those_of_each_log_alone(logs: Path) -> None:
    batch = identify_batch("rigid_1m", logs, jobs=1)
    assert [row["log"] for row in batch.rows] == sorted(str(path) for path in logs.iterdir())
    axis, model = symid.load_axis("rigid_1m"), symid.load_generated("rigid_1m")
    for row in batch.rows:
        log = symid.read_axis_log(axis, str(row["log"]))
        found = symid.identify(model, log)
        assert (row["status"], row["message"]) == (found.status, found.message)
        assert row["samples"] == 2000
        for name, value in found.physical_parameters.items():
            assert row[name] == value
        assert row["M_std"] == found.physical_deviations[0]
        assert row["notes"] == ("; ".join(found.notes) or None)
        assert found.timing is None or row["late_s"] == found.timing.late
        assert row["residual_rms"] == found.residuals[0].rms
        assert math.isclose(float(row["M"] or 0), 5.0, rel_tol=0.01)


def test_processes_give_the_rows_of_one_process(logs: Path) -> None:
    alone, together = (identify_batch("rigid_1m", logs, jobs=jobs).table.drop(VOLATILE) for jobs in (1, 2))
    assert alone.equals(together)


def test_csv_holds_what_parquet_holds(logs: Path) -> None:
    (logs / "bad, with comma.csv").write_text('t,q\n"x",1\n')
    batch = identify_batch("rigid_1m", logs, output=["r.csv", "r.parquet"], jobs=1)
    parquet, text = (read_rows(Path(name)) for name in ("r.parquet", "r.csv"))
    assert parquet == text
    assert len(parquet) == 7
    assert pl.read_parquet("r.parquet").equals(batch.table)
    assert not any(frame.is_nan().any() for frame in batch.table.iter_columns() if frame.dtype == pl.Float64)
    units = json.loads(pl.read_parquet_metadata("r.parquet")[UNITS_KEY])
    assert units["rigid_1m"]["q"]["M"] == "kg"
    assert sorted(path.name for path in Path().iterdir()) == ["logs", "r.csv", "r.parquet"]


def test_bad_logs_are_rows_with_a_status(logs: Path) -> None:
    (logs / "empty.csv").write_text("")
    (logs / "text.csv").write_text("t,q,F\n0,hello,1\n1,2,3\n")
    (logs / "torn.parquet").write_bytes((logs / "0.parquet").read_bytes()[:3000])
    (logs / "short.csv").write_text("t,q,F\n0,0,1\n0.1,1,2\n0.2,4,3\n")
    (logs / "nothing.mat").symlink_to("gone.mat")
    (logs / "a folder.csv").mkdir()
    write_log(logs / "a folder.csv" / "inside.csv", 9)
    settings = BatchSettings(preparation=symid.Preparation(cutoff_hz=50.0))
    batch = identify_batch(
        "rigid_1m",
        [logs, logs / "0.parquet", logs / "a folder.csv" / ".." / "0.parquet"],
        jobs=2,
        settings=settings,
    )
    status = {Path(str(row["log"])).name: row["status"] for row in batch.rows}
    assert len(batch.rows) == len(status) == 12
    assert status["nothing.mat"] == "unreadable"
    assert all(status[name] == "bad_log" for name in ("empty.csv", "text.csv", "torn.parquet", "short.csv"))
    assert [status[name] for name in ("inside.csv", "0.parquet")] == ["ok", "ok"]
    for row in batch.rows:
        assert row["status"] == "ok" or (row["message"] and "\n" not in str(row["message"]))
        assert (row["status"] == "ok") == (row.get("M") is not None)


def test_a_setting_that_a_log_cannot_meet_and_a_fault_of_ours_are_rows(
    logs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    too_high = BatchSettings(preparation=symid.Preparation(cutoff_hz=600.0))
    assert identify_batch("rigid_1m", logs, settings=too_high, jobs=1).statuses == {"bad_setting": 6}

    def broken(*_: object, **__: object) -> None:
        raise ZeroDivisionError("of all things")

    monkeypatch.setattr("symid.fleet.work.identify_with_steps", broken)
    batch = identify_batch("rigid_1m", logs, jobs=1)
    assert batch.statuses == {"failed": 6}
    assert batch.rows[0]["message"] == "ZeroDivisionError: of all things"
    assert batch.table["message"].null_count() == 0

    def greedy(*_: object, **__: object) -> None:
        raise MemoryError

    monkeypatch.setattr("symid.fleet.work.identify_with_steps", greedy)
    batch = identify_batch("rigid_1m", logs, jobs=1)
    assert batch.statuses == {"failed": 6}
    assert batch.table["key"].null_count() == 6  # tried again on another night


def test_each_log_is_of_the_first_axis_whose_signals_it_has(logs: Path) -> None:
    frame = pl.read_parquet(logs / "1.parquet")
    frame.rename({"q": "q2", "F": "Fm"}).write_parquet(logs / "6.parquet")
    frame.select("t", "q").write_parquet(logs / "7.parquet")
    batch = identify_batch(["direct_2m1s", "rigid_1m"], logs, output="r.parquet", jobs=1)
    axes = [row.get("axis") for row in batch.rows]
    assert axes == ["rigid_1m"] * 6 + ["direct_2m1s", None]
    assert batch.rows[7]["status"] == "bad_log"
    assert set(batch.units) == {"direct_2m1s", "rigid_1m"}
    assert batch.table["Ks"].null_count() >= 7


def test_diagnosis_names_the_effect_of_each_log(tmp_path: Path) -> None:
    logs = [write_log(tmp_path / f"{offset}.parquet", 1, offset=offset) for offset in (0.0, 3.0)]
    batch = identify_batch("rigid_1m", logs, settings=BatchSettings(diagnose=True), jobs=1)
    plain, hung = batch.rows
    assert plain.get("effect") is None
    assert (hung["verdict"], hung["effect"], hung["at"]) == ("effect", "offset_force", "motor")
    assert float(hung["gap_explained"] or 0) < 0.1 * float(hung["gap_reidentified"] or 0)
    record = summary_of(batch)
    assert record["effects"] == [
        {"effect": "offset_force", "at": "motor", "logs": 1, "axes": {"rigid_1m": 1}}
    ]
    assert record["verdicts"] == {row["verdict"]: 1 for row in batch.rows}


def test_a_diagnosis_that_fails_leaves_the_identification(
    logs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object, **__: object) -> None:
        raise ArithmeticError("no way")

    monkeypatch.setattr("symid.diagnosis.diagnose", broken)
    batch = identify_batch("rigid_1m", logs, settings=BatchSettings(diagnose=True), jobs=1)
    assert batch.statuses == {"ok": 6}
    assert batch.rows[0]["message"] == "no diagnosis: ArithmeticError: no way"
    assert batch.table["verdict"].null_count() == 6


@pytest.mark.parametrize("held", [True, "F"])
def test_forces_that_are_held_are_given_by_their_signals(held: Any) -> None:
    with pytest.raises(SettingError, match=r"as a tuple, such as \('F',\)"):
        BatchSettings(held=held)


def test_a_hold_that_the_axis_declares_counts_as_in_python_and_the_command(logs: Path) -> None:
    axis = symid.load_axis("rigid_1m")
    symid.write_axis(replace(axis, name="holding", drive=replace(axis.drive, held=True)), "holding.py")
    assert run("generate", "holding.py") == 0
    log = symid.read_axis_log(axis, logs / "0.parquet")
    (row,) = identify_batch("holding.py", logs / "0.parquet", jobs=1).rows
    (given,) = identify_batch(
        "rigid_1m", logs / "0.parquet", settings=BatchSettings(held=("F",)), jobs=1
    ).rows
    assert run("identify", "holding.py", "logs/0.parquet", "--json", "found.json") == 0
    command = json.loads(Path("found.json").read_text())["physical"]["Fv"]["value"]
    python = symid.identify(symid.load_generated("holding.py"), log).physical_parameters["Fv"]
    assert row["Fv"] == given["Fv"] == command == python
    assert python != symid.identify(symid.load_generated("rigid_1m"), log).physical_parameters["Fv"]


@pytest.mark.parametrize("method", ["ols", "oe"])
def test_other_methods_fill_the_same_columns(logs: Path, method: str) -> None:
    batch = identify_batch("rigid_1m", logs / "0.parquet", settings=BatchSettings(method=method), jobs=1)
    (row,) = batch.rows
    assert row["method"] == method
    assert row["status"] == "ok"
    assert math.isclose(float(row["M"] or 0), 5.0, rel_tol=0.02)
    assert float(row["M_std"] or 0) > 0
    assert set(batch.table.columns) == set(identify_batch("rigid_1m", logs, jobs=1).table.columns)


def test_folders_patterns_and_files_name_each_log_once(logs: Path) -> None:
    (logs / "deeper").mkdir()
    write = (logs / "0.parquet").read_bytes()
    (logs / "deeper" / "x.PARQUET").write_bytes(write)
    (logs / "notes.txt").write_text("no log")
    names = [f"logs/{i}.parquet" for i in range(6)]
    assert log_files(logs) == (*names, "logs/deeper/x.PARQUET")
    assert log_files("logs/*.parquet") == tuple(names)
    assert log_files("logs/d*r") == ("logs/deeper/x.PARQUET",)
    assert log_files(["logs/[01].parquet", logs / "1.parquet", "./logs/2.parquet"]) == (
        *names[:2],
        "./logs/2.parquet",
    )
    assert log_files(logs, exclude=["logs/3.parquet"])[3] == "logs/4.parquet"
    identify_batch("rigid_1m", "logs/0.parquet", output="logs/r.csv", jobs=1)
    identify_batch("rigid_1m", "logs/0.parquet", output="logs/r.parquet", jobs=1)
    assert log_files(logs) == (*names, "logs/deeper/x.PARQUET")
    assert log_files(["logs/r.csv", "logs/1.parquet"]) == ("logs/1.parquet",)
    for nothing in ("none*.csv", "logs/deeper/../deeper/y*", [], "logs/r.csv"):
        with pytest.raises(SettingError, match="no log"):
            log_files(nothing)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["rigid_1m", "logs", "-o", "r.txt"], "end the name with .parquet or .csv"),
        (["rigid_1m", "logs", "-o", "gone/r.csv"], "folder that exists"),
        (["rigid_1m", "logs", "-o", "a.csv", "-o", "b.csv"], "one .csv"),
        (["rigid_1m", "logs", "-o", "r.csv", "--jobs", "0"], "1 or more"),
        (["rigid_1m", "empty", "-o", "r.csv"], "there is no log"),
        (["rigid_1m", "logs", "-o", "r.csv", "--column", "zz=q"], "signal 'zz' is not known"),
        (["rigid_1m", "logs", "-o", "r.csv", "--also", "rigid_1m"], "each axis once"),
        (["no_axis", "logs", "-o", "r.csv"], "no axis 'no_axis'"),
        (["rigid_1m", "logs", "-o", "logs/0.parquet"], "holds no results"),
        (
            ["rigid_1m", "logs", "-o", "r.csv", "--scheduler", "tls://127.0.0.1:1"],
            "no Dask scheduler answers",
        ),
        (
            ["rigid_1m", "logs", "-o", "r.csv", "--scheduler", "tcp://127.0.0.1:1"],
            "no Dask scheduler answers",
        ),
        (["rigid_1m", "logs"], "--output"),
    ],
)
def test_a_mistake_is_one_line(
    logs: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    arguments: list[str],
    says: str,
) -> None:
    monkeypatch.setattr("symid.fleet.schedulers._PATIENCE", 0.5)
    Path("empty").mkdir()
    assert run("batch", *arguments) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert says in error


def test_command_prints_a_summary_and_writes_it_as_json(
    logs: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (logs / "bad.csv").write_text("")
    assert run("batch", "rigid_1m", str(logs), "-o", "r.parquet", "--jobs", "1", "--json", "s.json") == 0
    shown = capsys.readouterr()
    assert "bad.csv: bad_log: is empty" in shown.out
    assert shown.err == ""
    record = json.loads(Path("s.json").read_text())
    assert record["status"] == {"ok": 6, "bad_log": 1}
    (mass,) = [p for p in record["parameters"]["rigid_1m"] if p["name"] == "M"]
    assert (mass["logs"], mass["unit"]) == (6, "kg")
    assert mass["median"] == pytest.approx(pl.read_parquet("r.parquet")["M"].median())
    assert mass["spread"] < 10 * mass["std"]


def test_a_mapping_reads_foreign_logs_of_a_batch(logs: Path) -> None:
    own = pl.read_parquet(logs / "0.parquet")
    foreign = Path("foreign")
    foreign.mkdir()
    frame = own.select(
        (1e3 * pl.col("t")).alias("Zeit"), (1e3 * pl.col("q")).alias("s_ist"), (pl.col("F") / 50).alias("I")
    )
    (foreign / "0.csv").write_text("Achse X\n" + frame.write_csv(separator=";", decimal_comma=True))
    Path("mapping.json").write_text(
        json.dumps(
            {
                "columns": {"t": "Zeit", "q": "s_ist", "F": "I"},
                "units": {"t": "ms", "q": "mm"},
                "gains": {"F": 50.0},
                "layout": {"separator": ";", "decimal": ",", "above": 1},
            }
        )
    )
    for folder, more in (("foreign", ["--mapping", "mapping.json"]), (str(logs / "0.parquet"), [])):
        assert (
            run("batch", "rigid_1m", folder, "-o", f"{Path(folder).stem}.parquet", "--jobs", "1", *more) == 0
        )
    (mapped,), (plain,) = (pl.read_parquet(f"{name}.parquet").rows(named=True) for name in ("foreign", "0"))
    assert mapped["status"] == plain["status"] == "ok"
    assert mapped["M"] == pytest.approx(plain["M"], rel=1e-9)
