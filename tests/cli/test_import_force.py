"""The force of a foreign file: measured, or commanded where nothing else is recorded."""

import json
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from command_line import run


@pytest.mark.parametrize(
    ("header", "gain", "words"),
    [
        ("Set torque [N]", [], "F is a command: no column seems to be a measured force"),
        ("TCMD[%]", ["--gain", "F=0.1"], "F is a command"),
        ("IL.FB (Arms)", ["--gain", "F=10"], "its unit is written, Arms"),
    ],
)
def test_the_only_force_is_taken_though_it_is_a_command(
    header: str,
    gain: list[str],
    words: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    t = np.arange(1000) / 1000
    columns = {"t [ms]": 1e3 * t, "PosF[mm]": 100 * np.sin(9 * t), header: 40 * np.sin(9 * t)}
    pl.DataFrame(columns).write_csv("c.csv")
    assert run("import", "c.csv", "--axis", "rigid_1m", "-o", "m.json", *gain) == 0
    assert words in capsys.readouterr().out
    assert json.loads(Path("m.json").read_text(encoding="utf-8"))["columns"]["F"] == header


@pytest.mark.parametrize(
    ("header", "options", "said"),
    [
        ("duty", [], "F has no factor: give --gain F in N per unit of 'duty'"),
        ("u", ["--gain", "F=40"], ""),
        ("out [digits]", [], "F has no factor: give --gain F in N per unit of 'out [digits]'"),
        ("cmd", [], "name it with --column F=NAME; 'cmd' may be it"),
        ("setpoint", ["--column", "F=setpoint"], ""),
        ("Analog out [V]", [], "name it with --column F=NAME; 'Analog out [V]' may be it"),
        ("Torque [0.1 %]", [], "F has no factor: give --gain F in N per 0.1 % (rated value / 1000)"),
    ],
)
def test_a_command_of_unknown_size_is_asked_about(
    header: str,
    options: list[str],
    said: str,
    folder: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    t = np.arange(1000) / 1000
    columns = {"t [ms]": 1e3 * t, "PosF[mm]": 100 * np.sin(9 * t), header: np.sin(9 * t)}
    pl.DataFrame(columns).write_csv(folder / "c.csv")
    assert run("import", "c.csv", "--axis", "rigid_1m", "-o", "m.json", *options) == 0
    assert said in capsys.readouterr().out
    record = json.loads(Path("m.json").read_text(encoding="utf-8"))
    assert len(record["missing"]) == bool(said)
    if not said:
        assert record["columns"]["F"] == header


@pytest.mark.parametrize(("unit", "factor"), [("%", 4.0), ("‰", 0.4), ("0,1%", 0.4), ("0.01 %", 0.04)])
def test_shares_of_a_rated_force_have_their_own_size(unit: str, factor: float, folder: Path) -> None:
    t = np.arange(1000) / 1000
    columns = {"t [ms]": 1e3 * t, "pos [mm]": 100 * np.sin(9 * t), f"Torque [{unit}]": 40 * np.sin(9 * t)}
    pl.DataFrame(columns).write_csv(folder / "c.csv")
    assert run("import", "c.csv", "--axis", "rigid_1m", "-o", "m.json", "--rated", "400") == 0
    assert json.loads(Path("m.json").read_text(encoding="utf-8"))["gains"]["F"] == pytest.approx(factor)


def test_a_rated_value_makes_a_torque_without_a_unit_per_cent(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    t = np.arange(1000) / 1000
    columns = {"t [ms]": 1e3 * t, "pos [mm]": 100 * np.sin(9 * t), "TorqueReference": 40 * np.sin(9 * t)}
    pl.DataFrame(columns).write_csv(folder / "c.csv")
    assert run("import", "c.csv", "--axis", "rigid_1m", "-o", "m.json", "--rated", "400") == 0
    assert "no unit, so per cent is assumed of the rated value that is given" in capsys.readouterr().out
    assert json.loads(Path("m.json").read_text(encoding="utf-8"))["gains"]["F"] == pytest.approx(4.0)


@pytest.mark.parametrize(
    ("position", "given", "unit", "said"),
    [
        (
            "Pos [cnt]",
            ["--unit", "q=5000 counts/mm"],
            "5000 counts/mm",
            "its counts are taken for those of the position",
        ),
        ("Pos [mm]", [], None, "reference is not taken: 'Pos Command [cnt]' has no unit"),
    ],
)
def test_a_reference_in_counts_does_not_keep_a_mapping_incomplete(
    position: str,
    given: list[str],
    unit: str | None,
    said: str,
    folder: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    t = np.arange(1000) / 1000
    q = np.round(5e3 * np.sin(9 * t))
    columns = {"t [ms]": 1e3 * t, position: q, "Pos Command [cnt]": q, "force [N]": 40 * np.sin(9 * t)}
    pl.DataFrame(columns).write_csv(folder / "c.csv")
    assert run("import", "c.csv", "--axis", "rigid_1m", "-o", "m.json", *given) == 0
    assert said in " ".join(capsys.readouterr().out.split())
    record = json.loads(Path("m.json").read_text(encoding="utf-8"))
    assert record["missing"] == []
    assert record["units"].get("reference") == unit


def test_forces_of_other_axes_in_the_file_are_named(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    t = np.arange(1000) / 1000
    forces = {f"Torque {axis} [N]": (k + 1) * np.sin(9 * t) for k, axis in enumerate("YXZ")}
    columns = {
        "t [ms]": 1e3 * t,
        "Pos X [mm]": 100 * np.sin(9 * t),
        **forces,
        "Set torque [N]": np.cos(9 * t),
    }
    pl.DataFrame(columns).write_csv(folder / "c.csv")
    assert run("import", "c.csv", "--axis", "rigid_1m", "-o", "m.json") == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "F may as well be column 'Torque X [N]' or 'Torque Z [N]'" in out
    assert run("import", "c.csv", "--axis", "rigid_1m", "--column", "F=Torque X [N]") == 0
    assert "may as well" not in capsys.readouterr().out


def test_a_velocity_is_named_where_a_position_is_sought(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    t = np.arange(1000) / 1000
    pl.DataFrame({"t [ms]": 1e3 * t, "v [mm/s]": np.cos(9 * t), "F [N]": t}).write_csv(folder / "c.csv")
    assert run("import", "c.csv", "--axis", "rigid_1m") == 0
    assert "'v [mm/s]' is a velocity, which an axis may declare" in " ".join(capsys.readouterr().out.split())
