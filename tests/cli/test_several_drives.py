"""An axis with two drives on the command line: simulated, identified, in a batch; what takes one drive says so."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from axes.gantry import AXIS, TRUE
from command_line import run

from symid import read_axis_log, write_axis


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the axis, its true values and references of its own for each drive."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "models").mkdir()
    drives = tuple(replace(drive, held=True, noise=0.3) for drive in AXIS.drives)
    write_axis(replace(AXIS, drive=drives), "models/gantry.py")
    (tmp_path / "P.json").write_text(json.dumps(TRUE))
    t = np.arange(12000) / 4000
    stroke = 0.05 * np.sin(6 * t) + 1e-3 * np.sin(2 * np.pi * (5 * t + 12 * t**2))
    turn = 2e-4 * np.sin(2 * np.pi * (3 * t + 14 * t**2))
    paths = {"t": t, "reference": stroke, "reference_F1": stroke + turn, "reference_F2": stroke - turn}
    pd.DataFrame(paths).to_csv("paths.csv", index=False)
    return tmp_path


def simulated(*more: str) -> int:
    return run("simulate", "gantry", "--parameters", "P.json", "-o", "run.csv", "--rate", "4000", *more)


@pytest.mark.usefixtures("plain_pages")
def test_two_drives_from_simulation_to_a_page_and_a_batch(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert simulated("--trajectory", "paths.csv", "--bandwidth", "40") == 0
    written = pd.read_csv("run.csv")
    assert list(written) == ["t", "q1", "q2", "qb", "F1", "F2", "reference", "reference_F2"]
    assert run("identify", "gantry", "run.csv", "--json", "found.json", "--report", "found.html") == 0
    found = json.loads(Path("found.json").read_text())
    assert found["status"] == "ok"
    log = read_axis_log(AXIS, "run.csv")
    assert log["reference_F2"] == pytest.approx(written["reference_F2"].to_numpy())
    assert list(found["residual"]) == ["F1", "F2", "F1 (equation 3)"]
    for name, value in found["physical"].items():
        assert value["value"] == pytest.approx(TRUE[name], rel=0.05), name
    assert run("generate", "gantry") == 0
    assert sorted(path.name for path in Path("generated").glob("*.py")) == [
        "gantry__q1_q2.py",
        "gantry__q1_q2_qb.py",
    ]
    assert run("batch", "gantry", "run.csv", "-o", "rows.parquet", "--held", "F2") == 0
    (row,) = pd.read_parquet("rows.parquet").to_dict("records")
    assert row["status"] == "ok"
    assert row["M2"] == pytest.approx(TRUE["M2"], rel=0.05)
    open_loop = "simulate gantry --parameters P.json --open-loop run.csv -o again.csv --rate 4000"
    assert run(*open_loop.split()) == 0
    again = pd.read_csv("again.csv")
    assert np.abs(again["F2"] - written["F2"]).max() < 6 * 0.3  # its noise is drawn anew
    capsys.readouterr()


def test_tuning_takes_a_reference_of_each_drive(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = "--trajectory paths.csv --measured q1,q2 --rate 4000 --max-lowpass-error 0.1"
    assert run("tune", "gantry", "--parameters", "P.json", *options.split(), "--json", "tuned.json") == 0
    found = json.loads(Path("tuned.json").read_text())
    assert found["sampling"]["errors_percent"].keys() == TRUE.keys() - {"Fs1", "Fs2"}
    assert found["cutoff"]["largest_error_percent"] == pytest.approx(0.1, rel=0.03)
    assert found["status"] == "ok", found["message"]


def test_held_names_a_force_of_the_axis(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert simulated("--seconds", "1", "--trajectory", "chirp") == 0
    assert run("identify", "gantry", "run.csv", "--held", "F3") == 2
    assert "give F1 or F2" in capsys.readouterr().err
