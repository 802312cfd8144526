"""References of two drives: their distance is a limit of the simulated axis, and what it makes known is found."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from command_line import run

from symid import Axis, Between, Body, CoulombFriction, Drive, Position, Spring, ViscousFriction, write_axis
from symid.excitation import best_reference

LEFT, RIGHT = Body("left", mass="M1"), Body("right", mass="M2")
PAIR = Axis(
    "pair",
    (
        LEFT,
        ViscousFriction(LEFT, "Fv1"),
        CoulombFriction(LEFT, "Fs1"),
        RIGHT,
        ViscousFriction(RIGHT, "Fv2"),
        Spring("belt", Between(first=LEFT, second=RIGHT), stiffness="K", damping="C"),
    ),
    (Drive("F1", LEFT, held=True), Drive("F2", RIGHT, held=True)),
    (Position("q1", LEFT), Position("q2", RIGHT)),
)
TRUE = {"M1": 30.0, "Fv1": 150.0, "Fs1": 12.0, "M2": 50.0, "Fv2": 260.0, "K": 2e5, "C": 600.0}
NOISE = "--noise F1=1 --noise F2=1 --noise q1=1e-7 --noise q2=1e-7"
COMMON = "travel=0.2m,speed=0.5,acceleration=5"
RUN = "--seconds 2.5 --rate 1000 --seeds 0 --runs 4 --bandwidth 40"
OUTPUT = "-o r.csv --overwrite --json r.json"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the axis and its values."""
    monkeypatch.chdir(tmp_path)
    write_axis(PAIR, "pair.py")
    (tmp_path / "P.json").write_text(json.dumps(TRUE))
    return tmp_path


def excited(limits: str) -> int:
    return run(*f"excite pair.py --parameters P.json {NOISE} --limits {limits} {RUN} {OUTPUT}".split())


def test_drives_that_may_differ_determine_what_is_between_them(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of the references that are the same for both drives, every third is tried."""
    every = best_reference.references
    monkeypatch.setattr(best_reference, "references", lambda *given: every(*given)[::3])
    assert excited(COMMON) == 0
    common = json.loads(Path("r.json").read_text())["expected"]["designed"]
    assert list(pd.read_csv("r.csv")) == ["t", "reference"]
    assert excited(f"{COMMON},apart=2mm") == 0
    record = json.loads(Path("r.json").read_text())
    designed = record["expected"]["designed"]
    assert max(designed["relative"].values()) < 0.5 * max(common["relative"].values())
    assert designed["reached"]["apart"] <= record["limits"]["apart"] == 0.002
    written = pd.read_csv("r.csv")
    assert list(written) == ["t", "reference", "reference_F2"]
    assert 1e-4 < np.abs(written["reference"] - written["reference_F2"]).max() < 0.002
    follow = f"--trajectory r.csv --rate 1000 --bandwidth 40 {NOISE} --seed 9 -o run.csv"
    assert run("simulate", "pair.py", "--parameters", "P.json", *follow.split()) == 0
    log = pd.read_csv("run.csv")
    assert np.abs(log["q1"] - log["q2"]).max() < 0.002 + 1e-6
    assert max(np.ptp(log[name]) for name in ("q1", "q2")) < 0.2
    assert run("identify", "pair.py", "run.csv", "--held", "F1", "--json", "found.json") == 0
    found = json.loads(Path("found.json").read_text())["physical"]
    for name, value in TRUE.items():
        assert abs(found[name]["value"] - value) < 5 * designed["relative"][name] * value, name


def test_limits_of_one_drive_have_no_distance(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("M.json").write_text('{"M": 5, "Fv": 3, "Fs": 2}')
    command = f"excite rigid_1m --parameters M.json --noise q=1e-7 --limits {COMMON},apart=1mm -o r.csv"
    assert run(*command.split()) == 2
    assert "--limits apart is not known" in capsys.readouterr().err
