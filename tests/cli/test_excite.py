"""`symid excite`: a reference that a drive can play, what is expected of it, and mistakes."""

import json
from pathlib import Path

import polars as pl
import pytest
from command_line import run

COMMON = "excite rigid_1m --parameters rigid_1m.json --rate 500 --seconds 2 --seeds 0 --runs 4 --bandwidth 5"
LIMITS = "--limits travel=200mm,speed=0.5m/s,acceleration=5m/s^2"
NOISE = "--noise q=1e-7 --noise F=2"


pytestmark = pytest.mark.usefixtures("parameters")


def test_a_reference_is_written_and_followed(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(*f"{COMMON} {LIMITS},force=1kN {NOISE} -o r.csv --json r.json".split()) == 0
    printed = capsys.readouterr().out
    assert "default trapezoids" in printed
    record = json.loads((folder / "r.json").read_text())
    designed = record["expected"]["designed"]
    assert record["limits"]["force"] == 1000.0
    assert all(designed["reached"][name] <= record["limits"][name] for name in ("travel", "speed", "force"))
    reference = pl.read_csv(folder / "r.csv")
    assert reference.columns == ["t", "reference"]
    assert reference["t"][-1] == pytest.approx(2.0)
    played = "simulate rigid_1m --parameters rigid_1m.json --trajectory r.csv --bandwidth 5 -o run.csv"
    assert run(*played.split()) == 0
    q = pl.read_csv(folder / "run.csv")["q"]
    assert q.max() - q.min() == pytest.approx(designed["reached"]["travel"], rel=0.02)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (f"{NOISE} --limits travel=0.2,speed=1", "lacks acceleration"),
        (f"{NOISE} {LIMITS},power=3", "choose from travel"),
        (f"{NOISE} {LIMITS},force=-1", "force is -1"),
        (f"{NOISE} --limits travel=2s,speed=1,acceleration=1", "converts to m"),
        (f"--noise z=1 {LIMITS}", "no signal 'z'"),
        (f"{NOISE} {LIMITS} -o r.txt", ".parquet"),
        (f"--noise F=2 {LIMITS}", "no sensor of axis 'rigid_1m' has noise: give --noise q=STD"),
    ],
)
def test_a_mistake_is_one_line(
    folder: Path, arguments: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(*f"{COMMON} -o r.csv {arguments}".split()) == 2
    shown = capsys.readouterr()
    assert (shown.out, shown.err.count("\n")) == ("", 1)
    assert words in shown.err
