"""`symid import` of names above units and numbers of columns, and of columns without names."""

import json
from pathlib import Path

import pytest
from command_line import run
from recorded_run import TRUE


def table(recorded, above: str, separator: str = ",") -> str:
    columns = recorded.time, 1e3 * recorded["q"], recorded["F"]
    rows = [separator.join(f"{x:.9f}" for x in row) for row in zip(*columns, strict=True)]
    return "\n".join([*above.replace(",", separator).splitlines(), *rows, ""])


def check_identified(folder: Path) -> None:
    identify = ("identify", "rigid_1m", "a.csv", "--mapping", "m.json", "--held", "F", "--json", "o.json")
    assert run(*identify) == 0
    found = json.loads((folder / "o.json").read_text())["physical"]
    assert {name: found[name]["value"] for name in TRUE} == pytest.approx(TRUE, rel=0.02)


@pytest.mark.parametrize("separator", [",", ";", " "])
@pytest.mark.parametrize(
    "above",
    [
        "Time,Position,Force\ns,mm,N\n1,2,3",
        "Time,Position,Force\n1,2,3\ns,mm,N",
        "1,2,3\nTime,Position,Force\ns,mm,N",
        "Time,Position,Force\n\ns,mm,N\n",
        "% Time,Position,Force\n% s,mm,N",
        "Log\nTime,Position[mm],Force\n0,1,2",
    ],
)
def test_names_and_units_are_read_beside_lines_that_number_the_columns(
    recorded, folder: Path, above: str, separator: str
) -> None:
    (folder / "a.csv").write_text(table(recorded, above, separator))
    assert run("import", "a.csv", "--axis", "rigid_1m", "-o", "m.json") == 0
    mapping = json.loads((folder / "m.json").read_text())
    assert [name.partition("[")[0].strip() for name in mapping["columns"].values()] == [
        "Time",
        "Position",
        "Force",
    ]
    assert mapping["units"]["q"] == "mm"
    check_identified(folder)


@pytest.mark.parametrize("above", ["", "0,1,2"])
def test_columns_without_names_are_listed_with_the_options_to_give(
    recorded, folder: Path, capsys: pytest.CaptureFixture[str], above: str
) -> None:
    (folder / "a.csv").write_text(table(recorded, above))
    look = ("import", "a.csv", "--axis", "rigid_1m", "-o", "m.json")
    assert run(*look) == 0
    printed = " ".join(capsys.readouterr().out.split())
    low, high = 1e3 * recorded["q"].min(), 1e3 * recorded["q"].max()
    assert (
        f"such as --column 'q=column 2'; of unknown meaning are 'column 2' ({low:.4g} to {high:.4g})"
        in printed
    )
    named = ("--column", "q=column 2", "--column", "F=column 3")
    (folder / "m.json").unlink()
    assert run(*look, *named) == 0
    assert "are too far apart for SI: give it with --unit q=UNIT, such as mm" in capsys.readouterr().out
    (folder / "m.json").unlink()
    assert run(*look, *named, "--unit", "q=mm") == 0
    check_identified(folder)


def test_whole_numbers_from_one_may_be_the_first_sample(folder: Path) -> None:
    (folder / "a.csv").write_text("t,q,F\n" + "\n".join(f"{i},{i + 1},{i + 2}" for i in range(1, 60)))
    assert run("import", "a.csv", "--axis", "rigid_1m", "-o", "m.json") == 0
    assert json.loads((folder / "m.json").read_text())["layout"]["below"] == 0
