"""Two batches do not share a table, former tables stay, folders that are closed are named, names do not collide."""

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import polars as pl
import pytest
from fleet_logs import write_log

import symid
from symid.errors import SettingError
from symid.fleet import BatchSettings, identify_batch, read_results
from symid.fleet.journal import locked
from symid.fleet.plan import fleet_axes, log_files

QUICK = BatchSettings(examine=False)


def test_a_second_batch_to_one_table_is_refused(logs: Path) -> None:
    with locked([Path("r.parquet")]):
        for output in ("r.parquet", ["r.csv", "r.parquet"]):
            with pytest.raises(SettingError, match="another batch is writing these results"):
                identify_batch("rigid_1m", logs, output=output, jobs=1)
    assert identify_batch("rigid_1m", logs / "1.parquet", output="r.parquet", jobs=1, settings=QUICK).rows
    assert sorted(path.name for path in Path().iterdir()) == ["logs", "r.parquet"]


def test_each_former_table_is_kept(logs: Path) -> None:
    tables = []
    for name in ("0", "1", "2", "3"):
        identify_batch("rigid_1m", logs / f"{name}.parquet", output="r.csv", jobs=1, settings=QUICK)
        tables.append(Path("r.csv").read_bytes())
    kept = [Path(f"r.csv.before{count}").read_bytes() for count in ("", "2", "3")]
    assert kept == tables[:3]


def test_a_recording_is_no_second_table(logs: Path) -> None:
    write_log(Path("recording.csv"), 5)
    before = Path("recording.csv").read_bytes()
    with pytest.raises(SettingError, match=r"recording\.csv: exists but holds no results"):
        identify_batch("rigid_1m", logs, output=["r.parquet", "recording.csv"], jobs=1)
    assert Path("recording.csv").read_bytes() == before


def test_a_closed_folder_is_a_row_that_says_so(logs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    closed = logs / "closed"
    closed.mkdir()
    scan, listed = os.scandir, os.listdir

    def refused(path: Any) -> None:
        if Path(path).name == "closed":
            raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(os, "scandir", lambda path: refused(path) or scan(path))
    monkeypatch.setattr(os, "listdir", lambda path: refused(path) or listed(path))
    assert "logs/closed" in log_files(logs)
    rows = identify_batch("rigid_1m", logs, jobs=1, settings=QUICK).rows
    assert {row["log"]: (row["status"], row["message"]) for row in rows if row["status"] != "ok"} == {
        "logs/closed": ("unreadable", "Permission denied: check the file")
    }


def test_pipes_and_devices_among_the_logs_are_rows(logs: Path) -> None:
    os.mkfifo(logs / "pipe.csv")
    (logs / "zero.parquet").symlink_to("/dev/zero")
    found = identify_batch("rigid_1m", logs, jobs=1, settings=QUICK)
    assert {row["log"]: row["message"] for row in found.rows if row["status"] == "bad_log"} == {
        "logs/pipe.csv": "is a pipe: give a regular file",
        "logs/zero.parquet": "is a device: give a regular file",
    }


@pytest.mark.parametrize("name", ["log", "status", "key", "samples", "Fv_std", "verdict", "factors"])
def test_a_parameter_is_no_column_of_the_results(name: str, logs: Path) -> None:
    body = symid.Body("body", mass=name)
    axis = symid.Axis(
        "named",
        (body, symid.ViscousFriction(body, "Fv")),
        symid.Drive("F", body),
        (symid.Position("q", body),),
    )
    with pytest.raises(SettingError, match=f"parameter '{name}', which is a column of the results"):
        fleet_axes(axis, QUICK)


def test_texts_that_spreadsheets_would_run_are_texts(logs: Path) -> None:
    for place, name in enumerate(("=cmd|' .csv", "+1+1.csv", "@SUM(1).csv", "'-1.csv")):
        write_log(Path(name), place)
    names = ["=cmd|' .csv", "+1+1.csv", "@SUM(1).csv", "'-1.csv"]
    batch = identify_batch("rigid_1m", names, output="r.csv", jobs=1, settings=QUICK)
    cells = pl.read_csv("r.csv")["log"].to_list()
    assert cells == ["'=cmd|' .csv", "'+1+1.csv", "'@SUM(1).csv", "''-1.csv"]
    assert read_results("r.csv")["log"].to_list() == names == batch.table["log"].to_list()
    assert identify_batch("rigid_1m", names, output="r.csv", jobs=1, settings=QUICK).reused == 4


def test_rows_of_another_module_are_made_again(logs: Path) -> None:
    (axis,) = fleet_axes("rigid_1m", QUICK)
    (signals, module), *_ = axis.modules
    other = replace(axis, modules=((signals, replace(module, text=module.text + "\n")),))
    assert other.fingerprint != axis.fingerprint
