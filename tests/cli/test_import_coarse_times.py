"""`symid import` of times that several samples share: the numbers of the rows take their place where they are even."""

import json
from pathlib import Path

import numpy as np
import pytest
from command_line import run
from recorded_run import PERIOD, TRUE, table


def rounded(kind: str, time: np.ndarray) -> np.ndarray:
    return {
        "rounded": np.round(time, 2),
        "cut": np.floor(100 * time + 1e-6) / 100,
        "tick": 0.016 * np.floor(time / 0.016 + 1e-6),
        "moments": 1.7e9 + np.round(time, 2),
    }[kind]


@pytest.mark.parametrize("header", ["t", "time", "t [s]", "Zeit_s"])
@pytest.mark.parametrize("kind", ["rounded", "cut", "tick", "moments"])
def test_rows_give_the_time_where_coarse_times_rise_evenly(
    recorded, folder: Path, capsys: pytest.CaptureFixture[str], kind: str, header: str
) -> None:
    columns = {header: rounded(kind, recorded.time), "pos_mm": 1e3 * recorded["q"], "F [N]": recorded["F"]}
    text = "\n".join(",".join(f"{x:.15g}" for x in row) for row in zip(*columns.values(), strict=True))
    (folder / "a.csv").write_text(",".join(columns) + "\n" + text, encoding="utf-8")
    assert run("import", "a.csv", "--axis", "rigid_1m", "-o", "m.json") == 0
    assert "by the numbers of the rows" in " ".join(capsys.readouterr().out.split())
    assert json.loads((folder / "m.json").read_text())["sampling_period"] == pytest.approx(PERIOD, rel=1e-9)
    identify = ("identify", "rigid_1m", "a.csv", "--mapping", "m.json", "--held", "F", "--json", "o.json")
    assert run(*identify) == 0
    found = json.loads((folder / "o.json").read_text())["physical"]
    assert {name: found[name]["value"] for name in TRUE} == pytest.approx(TRUE, rel=0.02)


def test_coarse_times_with_lost_samples_are_asked_about(
    recorded, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    kept = np.delete(np.arange(recorded.time.size), [100, 101, 102, 350, 351])
    columns = {
        "t [s]": np.round(recorded.time, 2)[kept],
        "q": recorded["q"][kept],
        "F": recorded["F"][kept],
    }
    (folder / "a.csv").write_text(table(columns, ","))
    assert run("import", "a.csv", "--axis", "rigid_1m", "-o", "m.json") == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "do not rise evenly, as where samples are lost" in printed
    assert "give --rate" in printed
    assert run("identify", "rigid_1m", "a.csv", "--mapping", "m.json") == 2


def test_repeated_rows_are_no_coarse_times(
    recorded, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = np.repeat(np.arange(0, recorded.time.size, 3), 3)
    columns = {"t [s]": recorded.time[rows], "q": recorded["q"][rows], "F": recorded["F"][rows]}
    (folder / "a.csv").write_text(table(columns, ","))
    assert run("import", "a.csv", "--axis", "rigid_1m", "-o", "m.json") == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "remove the repeated rows" in printed
    assert json.loads((folder / "m.json").read_text())["sampling_period"] is None
    assert run("identify", "rigid_1m", "a.csv", "--mapping", "m.json") == 2
    assert "remove repeated rows" in capsys.readouterr().err


def test_a_time_that_does_not_rise_is_said_so(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = "\n".join(f"0,{i % 7},{i % 5}" for i in range(60))
    (folder / "a.csv").write_text(f"time,q,F\n{rows}\n")
    assert run("import", "a.csv", "--axis", "rigid_1m", "-o", "m.json") == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "it does not rise from row to row" in printed
    assert "steps of 0" not in printed
