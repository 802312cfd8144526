"""`symid import`: files without names, structs, numbered samples and archives."""

import json
import zipfile
from pathlib import Path

import pytest
import scipy
from command_line import run
from recorded_run import PERIOD, TRUE, table

from symid.data import Log, foreign_columns, open_table


def test_a_file_without_names_is_imported_by_its_clock(
    recorded, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = table({"t": recorded.time, "q": recorded["q"], "F": recorded["F"]}, ",")
    (folder / "bare.txt").write_text(text.partition("\n")[2], encoding="utf-8")
    assert run("import", "bare.txt", "--axis", "rigid_1m", "-o", "m.json") == 0
    mapping = json.loads(Path("m.json").read_text(encoding="utf-8"))
    assert mapping["columns"] == {"t": "column 1"}
    named = ("--column", "q=column 2", "--column", "F=column 3")
    assert run("identify", "rigid_1m", "bare.txt", "--mapping", "m.json", *named, "--json", "f.json") == 0
    found = json.loads(Path("f.json").read_text(encoding="utf-8"))["physical"]
    assert found["Fv"]["value"] == pytest.approx(TRUE["Fv"], rel=0.05)


def test_a_struct_and_a_json_log_are_no_empty_tables(
    recorded, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    columns = {"time": recorded.time, "position": recorded["q"], "force": recorded["F"]}
    scipy.io.savemat(folder / "s.mat", {"run": columns}, do_compression=True)
    (folder / "s.json").write_text(json.dumps({"run": {k: v.tolist() for k, v in columns.items()}}))
    for name in ("s.mat", "s.json"):
        assert run("import", name, "--axis", "rigid_1m", "-o", "m.json") == 0
        mapping = json.loads(Path("m.json").read_text(encoding="utf-8"))
        assert mapping["columns"] == {"t": "time", "q": "position", "F": "force"}
        assert mapping["missing"] == []
        assert run("identify", "rigid_1m", name, "--mapping", "m.json") == 0


def test_numbers_of_samples_are_no_times(recorded: Log, folder: Path) -> None:
    rows = table({"sample": recorded.time / PERIOD, "q": recorded["q"], "F": recorded["F"]}, ",")
    (folder / "numbered.csv").write_text(rows)
    (first, *_) = foreign_columns(open_table(folder / "numbered.csv"))
    assert (first.quantity, first.reason) == (None, "it numbers the samples")
    assert run("import", "numbered.csv", "--axis", "rigid_1m", "--no-ask", "-o", "m.json") == 0
    assert "--rate" in json.loads((folder / "m.json").read_text())["missing"][0]


def test_an_archive_is_to_be_unpacked(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with zipfile.ZipFile(folder / "run.zip", "w") as archive:
        for name in ("run.csv", "run2.csv"):
            archive.writestr(name, "t,q,F\n")
    for command in (("identify", "rigid_1m", "run.zip"), ("import", "run.zip")):
        assert run(*command) == 2
        assert "run.zip: is an archive of 2 files: unpack it, and give one of them" in capsys.readouterr().err


@pytest.mark.usefixtures("folder")
def test_a_column_that_is_left_out_is_named_with_its_reason(capsys: pytest.CaptureFixture[str]) -> None:
    lines = ["Zeit [ms];Weg [mm];Kraft [N]", *(f"{i}9{i},5;0,{i};{i}" for i in range(1, 9))]
    lines.append("1.00,5;0,9;9")
    Path("a.csv").write_text("\n".join(lines) + "\n")
    assert run("import", "a.csv") == 0
    printed = capsys.readouterr().out
    reason = "'Zeit [ms]' has '1.00,5' in row 9 where a number is required"
    assert f"left out: {reason}" in printed
    assert run("import", "a.csv", "--axis", "rigid_1m") == 0
    assert f"or the column of t; column {reason}" in capsys.readouterr().out.replace("\n", " ")
