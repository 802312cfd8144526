"""`symid diagnose` from outside: JSON, exit codes, one line for every mistake."""

import json
from pathlib import Path

import polars as pl
import pytest
from command_line import run
from hand_made import RIGID, rigid_log

from symid import load_axis


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Working folder with a log of an axis with drag, one that is too short, and one without position."""
    monkeypatch.chdir(tmp_path)
    log = rigid_log(lambda t, q, v, a, path: 300 * v * abs(v), seconds=5.0)
    table = pl.DataFrame({"t": log.time, "q": log["q"], "F": log["F"]})
    table.write_csv("run.csv")
    table.head(150).write_csv("short.csv")
    table.drop("q").write_csv("blind.csv")
    Path("nominal.json").write_text(json.dumps(RIGID))
    Path("lacking.json").write_text('{"M": 1}')
    return tmp_path


def test_one_run_prints_a_table_and_writes_json_page_and_axis(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files = ("--json", "gap.json", "--report", "gap.html", "--write-axis", "drag.py")
    assert run("diagnose", "rigid_1m", "run.csv", "--nominal", "nominal.json", *files) == 0
    shown = capsys.readouterr()
    assert shown.out.startswith("The model lacks quadratic drag at motor")
    assert shown.err == "wrote drag.py, and its values to drag.json\n"
    assert "quadratic drag" in (folder / "gap.html").read_text(encoding="utf-8")
    record = json.loads(Path("gap.json").read_text(), parse_constant=pytest.fail)
    assert set(record) >= {
        "axis", "measured", "verdict", "gap", "location", "effects", "alternatives", "probabilities", "next_experiment"
    }  # fmt: skip
    assert (record["axis"], record["measured"], record["verdict"]) == ("rigid_1m", ["q"], "effect")
    gap = record["gap"]
    assert (gap["signal"], gap["unit"]) == ("F", "N")
    assert gap["nominal"]["rms"] > gap["reidentified"]["rms"] > gap["explained"]["rms"]
    assert 0.8 < gap["closed_fraction"] <= 1
    first = record["effects"][0]
    assert (first["effect"], first["at"]) == ("quadratic_drag", "motor")
    assert set(first["parameters"]["c"]) == {"value", "std", "unit"}
    assert set(record["probabilities"]) == {"no_gap", "parameters", "unexplained"}
    assert sum(place["share"] for place in record["location"]) == pytest.approx(1.0, abs=0.02)
    values = json.loads(Path("drag.json").read_text())
    assert values["motor_c"] == pytest.approx(300, rel=0.05)
    assert set(load_axis("drag.py").physical_parameters) == set(values)
    assert run("generate", "drag.py", "--measured", "q") == 0
    capsys.readouterr()
    assert run("identify", "drag.py", "run.csv", "--json", "-") == 0
    identified = json.loads(capsys.readouterr().out)["physical"]
    assert identified["motor_c"]["value"] == pytest.approx(300, rel=0.05)


@pytest.mark.parametrize(
    ("arguments", "statement"),
    [
        (("rigid_1m", "short.csv"), "independent rows of motion"),
        (("rigid_1m", "blind.csv"), "q"),
        (("rigid_1m", "nothing.csv"), "nothing.csv"),
        (("no_axis", "run.csv"), "no_axis"),
        (("rigid_1m", "run.csv", "--nominal", "lacking.json"), "lacks Fv, Fs"),
        (("rigid_1m", "run.csv", "--nominal", "run.csv"), "is not JSON"),
        (("rigid_1m", "run.csv", "--validation", "short.csv"), "short.csv"),
        (("rigid_1m", "run.csv", "--report", "gap.pdf"), ".html"),
        (("rigid_1m", "run.csv", "--late", "F=soon"), "soon"),
        (("rigid_1m", "run.csv", "--late", "Fm=1us"), "no signal 'Fm'"),
        (("rigid_1m", "run.csv", "--held", "q"), "--held q is not the force"),
        (("rigid_1m", "run.csv", "--nonsense"), "--nonsense"),
    ],
)
def test_mistakes_are_one_line(
    folder: Path, capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...], statement: str
) -> None:
    assert run("diagnose", *arguments) == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    assert statement in shown.err
    assert len(shown.err.strip().splitlines()) == 1
