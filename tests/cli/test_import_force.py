"""The force of a foreign file: measured, or commanded where nothing else is recorded."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest
from command_line import run

T = np.arange(1000) / 1000
SINE = np.sin(9 * T)


def imported(columns: Mapping[str, np.ndarray], *options: str) -> dict[str, Any]:
    """Record of a foreign file of rigid_1m in the working folder."""
    pl.DataFrame({"t [ms]": 1e3 * T, **columns}).write_csv("c.csv")
    assert run("import", "c.csv", "--axis", "rigid_1m", "-o", "m.json", *options) == 0
    record: dict[str, Any] = json.loads(Path("m.json").read_text(encoding="utf-8"))
    return record


@pytest.mark.parametrize(
    ("header", "gain", "words"),
    [
        ("Set torque [N]", [], "F is a command: no column seems to be a measured force"),
        ("TCMD[%]", ["--gain", "F=0.1"], "F is a command"),
        ("IL.FB (Arms)", ["--gain", "F=10"], "its unit is stated: Arms"),
    ],
)
def test_the_only_force_is_taken_though_it_is_a_command(
    header: str,
    gain: list[str],
    words: str,
    folder: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    record = imported({"PosF[mm]": 100 * SINE, header: 40 * SINE}, *gain)
    assert words in capsys.readouterr().out
    assert record["columns"]["F"] == header


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
    record = imported({"PosF[mm]": 100 * SINE, header: SINE}, *options)
    assert said in capsys.readouterr().out
    assert len(record["missing"]) == bool(said)
    if not said:
        assert record["columns"]["F"] == header


@pytest.mark.parametrize(("unit", "factor"), [("%", 4.0), ("‰", 0.4), ("0,1%", 0.4), ("0.01 %", 0.04)])
def test_shares_of_a_rated_force_have_their_own_size(unit: str, factor: float, folder: Path) -> None:
    record = imported({"pos [mm]": 100 * SINE, f"Torque [{unit}]": 40 * SINE}, "--rated", "400")
    assert record["gains"]["F"] == pytest.approx(factor)


def test_a_rated_value_makes_a_torque_without_a_unit_per_cent(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    record = imported({"pos [mm]": 100 * SINE, "TorqueReference": 40 * SINE}, "--rated", "400")
    assert "no unit, so per cent is assumed of the rated value that is given" in capsys.readouterr().out
    assert record["gains"]["F"] == pytest.approx(4.0)


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
    q = np.round(5e3 * SINE)
    record = imported({position: q, "Pos Command [cnt]": q, "force [N]": 40 * SINE}, *given)
    assert said in " ".join(capsys.readouterr().out.split())
    assert record["missing"] == []
    assert record["units"].get("reference") == unit


def test_forces_of_other_axes_in_the_file_are_named(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    forces = {f"Torque {axis} [N]": (k + 1) * SINE for k, axis in enumerate("YXZ")}
    imported({"Pos X [mm]": 100 * SINE, **forces, "Set torque [N]": np.cos(9 * T)})
    out = " ".join(capsys.readouterr().out.split())
    assert "F may as well be column 'Torque X [N]' or 'Torque Z [N]'" in out
    assert run("import", "c.csv", "--axis", "rigid_1m", "--column", "F=Torque X [N]") == 0
    assert "may as well" not in capsys.readouterr().out


def test_a_velocity_is_named_where_a_position_is_sought(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    imported({"v [mm/s]": np.cos(9 * T), "F [N]": T})
    assert "'v [mm/s]' is a velocity, which an axis may declare" in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize(
    ("kind", "options", "gain", "unit"),
    [
        ("--linear", [], None, "N"),
        ("--rotary", [], None, "N*m"),
        ("--rotary", ["--unit", "tau=Nm"], None, "N*m"),
        ("--linear", ["--gain", "7"], 7.0, "N"),
        ("--linear", ["--unit", "F=%", "--rated", "400"], 4.0, "N"),
    ],
)
def test_a_torque_without_a_unit_is_asked_about(
    kind: str,
    options: list[str],
    gain: float | None,
    unit: str,
    folder: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run("new", "own.py", "--bodies", "1", "--springs", "0", kind) == 0
    signal = "tau" if kind == "--rotary" else "F"
    pl.DataFrame({"t [ms]": 1e3 * T, "q [mm]": SINE, "AXIS_01.TorqueReference": 40 * SINE}).write_csv("c.csv")
    position = ["--unit", "q=deg"] if kind == "--rotary" else []
    assert run("import", "c.csv", "--axis", "own.py", "-o", "m.json", *position, *options) == 0
    record = json.loads(Path("m.json").read_text(encoding="utf-8"))
    asked = f"Missing: {signal} has no factor: give --gain {signal} in {unit} per unit of 'AXIS_01.TorqueReference'"
    assert (asked in " ".join(capsys.readouterr().out.split())) is (not options)
    assert record["gains"].get(signal) == gain
    assert record["units"][signal] == unit
