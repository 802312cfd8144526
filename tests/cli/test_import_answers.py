"""`symid import` with options and answers for what a file does not hold."""

import io
import json
import sys
from pathlib import Path

import numpy as np
import pytest
from command_line import run
from recorded_run import PERIOD, TRUE, table


def counted(recorded, folder: Path) -> str:
    """A trace in counts, with a torque in percent, for which a mapping needs three answers."""
    columns = {
        "Zeit": 1e3 * recorded.time,
        "Lage [Inkr]": np.round(5e6 * recorded["q"]),
        "Moment %": recorded["F"] / 4,
    }
    (folder / "trace.csv").write_text(table(columns, ";", comma=True), encoding="utf-8")
    return "trace.csv"


def test_options_say_what_a_file_does_not(recorded, folder: Path) -> None:
    file = counted(recorded, folder)
    given = ("--column", "q=Lage", "--unit", "q=5000 counts/mm", "--unit", "t=ms", "--rated", "400")
    assert run("import", file, "--axis", "rigid_1m", *given, "-o", "m.json") == 0
    mapping = json.loads(Path("m.json").read_text(encoding="utf-8"))
    assert mapping["missing"] == []
    assert mapping["units"] == {"t": "ms", "q": "5000 counts/mm", "F": "N"}
    assert not any(guess.startswith("q is") for guess in mapping["guesses"])
    assert run("identify", "rigid_1m", file, "--mapping", "m.json", "--held", "F", "--json", "f.json") == 0
    found = json.loads(Path("f.json").read_text(encoding="utf-8"))["physical"]
    assert found["M"]["value"] == pytest.approx(TRUE["M"], rel=0.02)


def test_answers_say_what_a_file_does_not(
    recorded, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = counted(recorded, folder)
    (folder / "taken.json").write_text("{}")
    answers = ["", "ms", "Leistung", "2", "5000", "5000 counts/mm", "", "4e2x", "400", "taken.json", ""]
    monkeypatch.setattr(sys, "stdin", io.StringIO("\n".join(answers) + "\n"))
    assert run("import", file, "--axis", "rigid_1m", "--ask") == 0
    out = capsys.readouterr().out
    for words in (
        "there is no column 'Leistung'",
        "unit '5000'",
        "'4e2x'",
        "taken.json exists",
        "q, the position",
    ):
        assert words in out
    mapping = json.loads((folder / f"{file}.mapping.json").read_text(encoding="utf-8"))
    assert (mapping["units"], mapping["gains"]) == ({"t": "ms", "q": "5000 counts/mm", "F": "N"}, {"F": 4.0})
    assert (folder / "taken.json").read_text() == "{}"


def test_the_unit_of_an_angle_and_the_factor_of_whole_numbers_are_asked_for(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    t = 1e-3 * np.arange(400)
    columns = {"t [s]": t, "position": 30 * np.sin(9 * t), "current": np.round(900 * np.cos(9 * t))}
    (folder / "a.csv").write_text(table(columns, ","), encoding="utf-8")
    assert run("new", "servo.py", "--rotary", "--bodies", "1") == 0
    monkeypatch.setattr(sys, "stdin", io.StringIO("\n\nrad\n\n\n0.004\n"))
    assert run("import", "a.csv", "--axis", "servo.py", "--ask", "-o", "m.json") == 0
    assert "(deg or 4096 counts/rev)" in capsys.readouterr().out
    mapping = json.loads((folder / "m.json").read_text())
    assert (list(mapping["gains"].values()), mapping["missing"]) == ([0.004], [])
    assert "rad" in mapping["units"].values()


def test_the_factor_of_a_torque_without_a_unit_is_asked_for(
    recorded, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    columns = {"t [s]": recorded.time, "pos [m]": recorded["q"], "TorqueReference": recorded["F"] / 8}
    (folder / "a.csv").write_text(table(columns, ","), encoding="utf-8")
    monkeypatch.setattr(sys, "stdin", io.StringIO("\n\n\n\n8\n"))
    assert run("import", "a.csv", "--axis", "rigid_1m", "--ask", "-o", "m.json") == 0
    mapping = json.loads((folder / "m.json").read_text())
    assert (mapping["gains"], mapping["missing"]) == ({"F": 8.0}, [])


def test_a_rate_is_asked_for_where_there_is_no_time(
    recorded, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (folder / "a.csv").write_text(table({"Lage [m]": recorded["q"], "Kraft [N]": recorded["F"]}, ";"))
    monkeypatch.setattr(sys, "stdin", io.StringIO("\n\n\n1000\n"))
    assert run("import", "a.csv", "--axis", "rigid_1m", "--ask", "-o", "m.json") == 0
    assert json.loads((folder / "m.json").read_text())["sampling_period"] == PERIOD


def test_answers_that_end_early_write_nothing(
    recorded, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "stdin", io.StringIO("\n"))
    assert run("import", counted(recorded, folder), "--axis", "rigid_1m", "--ask", "-o", "m.json") == 2
    assert "the input ended before the last answer" in capsys.readouterr().err.splitlines()[-1]
    assert not (folder / "m.json").exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("--column q=Weg", "no column of numbers 'Weg' for q"),
        ("--column w=Lage", "names 'w', which axis 'rigid_1m' does not have"),
        ("--unit q=Inkr", "Inkr"),
        ("--unit q=kg", "is not a unit of any signal"),
    ],
)
def test_what_is_given_wrong_is_one_line(
    arguments: str, words: str, recorded, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "a.csv").write_text(
        table({"t [s]": recorded.time, "Lage [m]": recorded["q"], "F": recorded["F"]}, ";")
    )
    assert run("import", "a.csv", "--axis", "rigid_1m", *arguments.split()) == 2
    err = capsys.readouterr().err
    assert words in err
    assert err.count("\n") == 1


def test_a_column_that_is_named_is_the_force_whatever_its_name_suggests(recorded, folder: Path) -> None:
    text = table({"t": recorded.time, "x": recorded["q"], "v": recorded["F"]}, ",")
    (folder / "a.csv").write_text(text)
    assert run("import", "a.csv", "--axis", "rigid_1m", "--column", "F=v", "-o", "map.json") == 0
    mapping = json.loads((folder / "map.json").read_text())
    assert (mapping["columns"]["F"], mapping["missing"]) == ("v", [])


def test_columns_called_as_signals_and_an_angle_without_a_unit(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    t = np.arange(200) * 0.02
    columns = {"t": t, "u": 3 * np.sign(np.sin(2 * t)), "y": 140 * (1 - np.cos(2 * t))}
    (folder / "lab.csv").write_text(table(columns, ","), encoding="utf-8")
    (folder / "motor.py").write_text(
        "from symid import Axis, Body, Drive, Position, ViscousFriction\n"
        'rotor = Body("rotor", inertia="J")\n'
        'drive = Drive("u", rotor, unit="V")\n'
        'axis = Axis("motor", (rotor, ViscousFriction(rotor, "Fv")), drive, (Position("q", rotor),))\n'
    )
    assert run("import", "lab.csv", "--axis", "motor.py", "-o", "m.json", "--no-ask") == 0
    mapping = json.loads(Path("m.json").read_text(encoding="utf-8"))
    assert mapping["columns"] == {"t": "t", "q": "y", "u": "u"}
    assert "it may be in rad, deg or turn" in mapping["missing"][0]  # 280 deg, or 280 rad of a motor
    assert sum("name is that of the signal" in guess for guess in mapping["guesses"]) == 1
    capsys.readouterr()
    run("import", "lab.csv", "--axis", "motor.py", "-o", "m.json", "--no-ask", "--unit", "q=deg")
    mapping = json.loads(Path("m.json").read_text(encoding="utf-8"))
    assert (mapping["units"]["q"], mapping["missing"]) == ("deg", [])
    capsys.readouterr()
    run("identify", "motor.py", "lab.csv", "lab.csv", "--mapping", "m.json")
    assert capsys.readouterr().err.count("m.json guesses: ") == 1  # of two logs


def test_counts_are_never_taken_for_millimetres(
    recorded, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = counted(recorded, folder)
    given = ("--unit", "t=ms", "--rated", "400")
    assert run("import", file, "--axis", "rigid_1m", *given, "-o", "m.json") == 0
    mapping = json.loads(Path("m.json").read_text(encoding="utf-8"))
    assert "q" not in mapping["units"]
    assert [line.partition(",")[0] for line in mapping["missing"]] == ["q has no unit"]
    capsys.readouterr()
    mapped = ("rigid_1m", file, "--mapping", "m.json", "--held", "F")
    assert run("identify", *mapped, "--column", "q=Lage [Inkr]") == 2
    assert "--unit q=UNIT" in capsys.readouterr().err
    assert run("identify", *mapped, "--unit", "q=5000 counts/mm", "--json", "f.json") == 0
    found = json.loads(Path("f.json").read_text(encoding="utf-8"))["physical"]
    assert found["M"]["value"] == pytest.approx(TRUE["M"], rel=0.02)
