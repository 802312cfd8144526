"""`symid import` of a current: its factor is per the unit of the column, and it is not one of a phase."""

import json
from pathlib import Path

import pytest
from command_line import run
from recorded_run import TRUE, table

KT = 12.5  # N/A


@pytest.mark.parametrize(
    ("factor", "said"),
    [(None, "give --gain F in N per mA"), ("0.0125", "F is 0.0125 N per mA")],
)
def test_the_factor_of_a_current_is_per_the_unit_of_its_column(
    recorded, folder: Path, capsys: pytest.CaptureFixture[str], factor: str | None, said: str
) -> None:
    columns = {
        "time_ms": 1e3 * recorded.time,
        "pos_mm": 1e3 * recorded["q"],
        "iq_mA": 1e3 * recorded["F"] / KT,
    }
    (folder / "a.csv").write_text(table(columns, ","), encoding="utf-8")
    given = () if factor is None else ("--gain", factor)
    assert run("import", "a.csv", "--axis", "rigid_1m", *given, "-o", "m.json") == 0
    assert said in capsys.readouterr().out
    if factor:
        identify = ("identify", "rigid_1m", "a.csv", "--mapping", "m.json", "--held", "F", "--json", "o.json")
        assert run(*identify) == 0
        found = json.loads((folder / "o.json").read_text())["physical"]
        assert found["M"]["value"] == pytest.approx(TRUE["M"], rel=0.01)


@pytest.mark.parametrize("name", ["iq_mA", "q_current [mA]", "Torque current [mA]"])
def test_the_current_that_makes_torque_comes_before_those_of_phases(
    recorded, folder: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    columns = {"time_ms": 1e3 * recorded.time, "ia_mA": 1e3 * recorded["q"], "id_mA": recorded["q"]}
    columns |= {name: 1e3 * recorded["F"] / KT, "pos_mm": 1e3 * recorded["q"]}
    (folder / "a.csv").write_text(table(columns, ","), encoding="utf-8")
    assert run("import", "a.csv", "--axis", "rigid_1m", "--gain", "0.0125", "-o", "m.json") == 0
    assert json.loads((folder / "m.json").read_text())["columns"]["F"] == name
    assert "may as well" not in capsys.readouterr().out
