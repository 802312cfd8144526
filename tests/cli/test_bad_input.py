"""What once ended in a traceback or did not end: one line, exit code 2, and nothing written."""

import json
import os
import shutil
from pathlib import Path

import polars as pl
import pytest
from command_line import run

from benchmarks.bad.outcome import good_folder
from symid.fleet.journal import read_journal

AXES = """from symid import Axis, Body, CoulombFriction, Drive, Position, ViscousFriction
a = Body("a", mass="M")
elements = (a, ViscousFriction(a, "Fv"), ViscousFriction(a, "Fv2"), CoulombFriction(a, "Fs"), CoulombFriction(a, "Fs2"))
axis = Axis("twice", elements=elements, drive=Drive("F", a), sensors=(Position("q", a),))
"""


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("good")
    good_folder(folder)
    return folder


@pytest.fixture
def folder(good: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Good files, and SYMID_TRACE so that a fault of symid is a traceback."""
    shutil.copytree(good, tmp_path, ignore=shutil.ignore_patterns("pipe"), dirs_exist_ok=True)
    os.mkfifo(tmp_path / "pipe")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SYMID_TRACE", "1")
    (tmp_path / "twice.py").write_text(AXES, encoding="utf-8")
    mapping = json.loads(Path("M.json").read_text(encoding="utf-8"))
    record = json.loads(Path("R.json").read_text(encoding="utf-8"))
    strange = {
        "value.json": {**record, "physical": {"M": {"std": 1}}},
        "long.json": {"M": 10**400, "Fv": 1, "Fs": 1},
        "covariance.json": {**record, "covariance": {"minimal": [[1, 2], [3]]}},
        "minimal.json": {**record, "minimal": ["X1"]},
        "hex.json": {**mapping, "layout": {**mapping["layout"], "encoding": "hex"}},
        "above.json": {**mapping, "layout": {**mapping["layout"], "above": 1.5}},
        "many.json": {**mapping, "layout": {**mapping["layout"], "above": 10**9}},
        "column.json": {**mapping, "columns": {"q": 5}},
        "null.json": None,
        "late.json": {**mapping, "late": {"F": float("nan")}},
        "nominal.json": {"M": 5.0, "Fv": 1.0, "Fv2": 1.0, "Fs": 1.0, "Fs2": 1.0},
    }
    for name, content in strange.items():
        Path(name).write_text(json.dumps(content), encoding="utf-8")
    Path("deep.json").write_text("[" * 100_000, encoding="utf-8")
    Path("bomb.csv").write_text("t,q [9**9**9**9],F\n0,1,2\n", encoding="utf-8")
    Path("quote.csv").write_text('t,"q,F\n' + "0,1,2\n" * 20, encoding="utf-8")
    Path("long.csv").write_text('"' + "x" * 200_000 + "\n" + "0,1,2\n" * 20, encoding="utf-8")
    return tmp_path


@pytest.mark.parametrize(
    "arguments",
    [
        "identify rigid_1m bomb.csv",
        "identify rigid_1m run.csv --unit q=9**9**9**9",
        "identify rigid_1m run.csv --unit q=m^9^9^9^9",
        "identify rigid_1m pipe",
        "identify rigid_1m /dev/zero",
        "identify rigid_1m run.csv --mapping pipe",
        "identify rigid_1m run.csv --mapping /dev/zero",
        "identify rigid_1m run.csv --nominal pipe",
        "export rigid_1m --parameters pipe --to json",
        "import pipe",
        "import quote.csv",
        "import long.csv",
        "fleet pipe",
        "export rigid_1m --parameters value.json --to json",
        "export rigid_1m --parameters long.json --to json",
        "export rigid_1m --parameters deep.json --to json",
        "export rigid_1m --parameters covariance.json --to json",
        "export rigid_1m --parameters P.json --to c -o axis.h",
        "identify rigid_1m foreign.csv --mapping hex.json",
        "identify rigid_1m foreign.csv --mapping above.json",
        "identify rigid_1m foreign.csv --mapping many.json",
        "identify rigid_1m foreign.csv --mapping column.json",
        "identify rigid_1m foreign.csv --mapping null.json",
        "identify rigid_1m foreign.csv --mapping late.json",
        "identify rigid_1m foreign.csv --mapping deep.json",
        "identify rigid_1m run.csv --trim ²",
        "identify rigid_1m run.csv --cutoff 1e-9",
        "identify rigid_1m run.csv --memory 1e300GB",
        "identify rigid_1m run.csv --late F=1e9",
        "identify rigid_1m run.csv --late F=1e9us",
        "identify rigid_1m run.csv --late q=-1e9us --method oe",
        "diagnose rigid_1m run.csv --late F=1e9us",
        "simulate rigid_1m --parameters P.json -o s.csv --delay q=1e9us",
        "identify rigid_1m run.csv --decimation 0",
        "identify rigid_1m run.csv --order -3",
        "simulate rigid_1m --parameters P.json -o s.csv --rate 0",
        "simulate rigid_1m --parameters P.json -o s.csv --rate nan",
        "simulate rigid_1m --parameters P.json -o s.csv --bandwidth 0",
        "simulate rigid_1m --parameters P.json -o s.csv --bandwidth 1e300",
        "simulate rigid_1m --parameters P.json -o s.csv --force-limit nan",
        "simulate rigid_1m --parameters P.json -o s.csv --log-rate 0",
        "simulate rigid_1m --parameters P.json -o s.csv --seed -1",
        "simulate rigid_1m --parameters P.json -o s.csv --delay q=1e9s",
        "simulate rigid_1m --parameters P.json -o s.csv --trajectory pipe.csv",
    ],
)
def test_one_line_and_nothing_written(
    arguments: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = sorted(path.name for path in folder.iterdir())
    assert run(*arguments.split()) == 2
    printed = capsys.readouterr()
    assert (printed.out, printed.err.count("\n"), printed.err[:7]) == ("", 1, "symid: ")
    assert sorted(path.name for path in folder.iterdir()) == before


def test_minimal_parameters_of_another_shape_are_left_out(folder: Path) -> None:
    assert run("export", "rigid_1m", "--parameters", "minimal.json", "--to", "json", "-o", "e.json") == 0
    assert json.loads(Path("e.json").read_text(encoding="utf-8"))["minimal"]["names"] == ["X1", "X2", "X3"]


def test_more_physical_than_minimal_parameters_have_no_solution(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("generate", "twice.py") == 0
    assert run("identify", "twice.py", "run.csv", "--nominal", "nominal.json") == 0
    assert "X1" in capsys.readouterr().out


def test_logs_of_one_moment_are_charted_in_their_order(folder: Path) -> None:
    for name in ("1.csv", "2.csv", "3.csv"):
        shutil.copy("run.csv", name)
        os.utime(name, (1.75e9, 1.75e9))
    assert (
        run(
            "batch",
            "rigid_1m",
            "1.csv",
            "2.csv",
            "3.csv",
            "-o",
            "r.parquet",
            "--report",
            "r.html",
            "--jobs",
            "1",
        )
        == 0
    )
    assert run("fleet", "r.parquet", "--report", "f.html") == 0


@pytest.mark.parametrize(
    ("column", "value", "code"),
    [
        ("status", 1, 2),
        ("M", 1e308, 0),
        ("factors", 1, 2),
        ("M", "text", 0),
        ("log", 5, 2),
        ("measured", 1, 2),
    ],
)
def test_tables_with_strange_columns(column: str, value: object, code: int, folder: Path) -> None:
    pl.read_parquet("results.parquet").with_columns(pl.lit(value).alias(column)).write_parquet("s.parquet")
    assert run("fleet", "s.parquet", "--report", "s.html") == code


@pytest.mark.parametrize(
    "line",
    [
        "[" * 100_000,
        json.dumps({"log": "run.csv", "status": "ok", "M": "text"}),
        json.dumps({"log": "run.csv", "M": 1}),
        json.dumps({"log": 1, "status": "ok"}),
        json.dumps({"log": "run.csv", "status": "ok", "samples": 10**400}),
    ],
)
def test_journals_with_strange_lines(line: str, folder: Path) -> None:
    journal = folder / "j.parquet.journal"
    journal.write_text(line + "\n", encoding="utf-8")
    assert [row for row in read_journal(journal) if "status" in row] == []
    assert run("batch", "rigid_1m", "run.csv", "-o", "j.parquet", "--jobs", "1") == 0
