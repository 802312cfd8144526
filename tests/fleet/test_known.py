"""What is known of parameters, in a batch: rows are those of each log alone with the same knowledge."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from command_line import run
from fleet_logs import TRUE

import symid
from symid.cli.simulate_command import write_log
from symid.errors import EliminationError, SettingError
from symid.fleet import BatchSettings, identify_batch
from symid.fleet.result_table import read_rows
from symid.simulation import Cascade, simulate, trapezoids


def test_a_fixed_mass_is_no_column_and_the_others_are_those_of_identify(logs: Path) -> None:
    assert run("batch", "rigid_1m", str(logs), "-o", "r.parquet", "--fix", "M=5kg", "--jobs", "1") == 0
    rows = read_rows(Path("r.parquet"))
    axis = symid.load_axis("rigid_1m")
    for row in rows:
        assert "M" not in row
        found = symid.identify(axis.with_known({"M": 5.0}), symid.read_axis_log(axis, str(row["log"])))
        assert row["Fv"] == found.physical_parameters["Fv"]
        assert row["Fv"] == pytest.approx(TRUE["Fv"], rel=0.05)


def test_bounds_and_priors_reach_every_log(logs: Path) -> None:
    Path("prior.json").write_text(json.dumps({"Fv": [3.0, 1e-4]}))
    arguments = ("batch", "rigid_1m", str(logs), "-o", "r.csv", "--jobs", "1")
    assert run(*arguments, "--bounds", "M=5.5..", "--prior", "prior.json") == 0
    axis = symid.load_axis("rigid_1m")
    for row in read_rows(Path("r.csv")):
        log = symid.read_axis_log(axis, str(row["log"]))
        found = symid.identify(axis, log, bounds={"M": (5.5, None)}, prior={"Fv": (3.0, 1e-4)})
        assert (row["status"], row["message"]) == (found.status, found.message)
        assert row["M"] == pytest.approx(5.5)
        assert row["Fv"] == pytest.approx(3.0, abs=1e-3)
        assert row["status"] == "contradicted"


def test_knowledge_is_part_of_what_a_row_depends_on(logs: Path) -> None:
    first = identify_batch("rigid_1m", logs, jobs=1)
    bounded = identify_batch("rigid_1m", logs, jobs=1, settings=BatchSettings(bounds={"M": (5.5, None)}))
    assert {row["key"] for row in first.rows}.isdisjoint({row["key"] for row in bounded.rows})


def test_what_is_not_possible_is_refused(logs: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SettingError, match="'Mx' is not an unknown parameter: choose from Fs, Fv, M"):
        identify_batch("rigid_1m", logs, settings=BatchSettings(prior={"Mx": (1.0, 1.0)}))
    with pytest.raises(SettingError, match="not possible with method 'oe'"):
        BatchSettings(method="oe", bounds={"M": (0.0, None)})
    arguments = ("batch", "rigid_1m", str(logs), "-o", "r.csv")
    assert run(*arguments, "--fix", "Mx=1") == 2
    assert "--fix Mx is not known: choose from M, Fv, Fs" in capsys.readouterr().err
    assert run(*arguments, "--bounds", "M=5") == 2
    assert "LOW..HIGH" in capsys.readouterr().err


BELTED = """
from symid import Axis, Between, Body, CoulombFriction, Drive, Position, Spring, ViscousFriction

motor, load = Body("motor", mass="Mm"), Body("load", mass="Ml")
belt = Spring("belt", Between(first=motor, second=load), stiffness="K", damping="D")
friction = (ViscousFriction(motor, "Fv"), CoulombFriction(load, "Fs"))
sensors = (Position("q", motor, noise=1e-8), Position("x", load, noise=1e-8))
axis = Axis("belted", (motor, load, belt, *friction), Drive("F", motor, held=True), sensors)
"""


def test_sensors_that_allow_no_model_alone_do_not_stop_a_batch(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("belted.py").write_text(BELTED)
    axis = symid.load_axis("belted.py")
    true = {"Mm": 8.0, "Ml": 22.0, "K": 6e5, "D": 300.0, "Fv": 60.0, "Fs": 18.0}
    path = trapezoids([0.05] * 2, 0.3, acceleration=8.0, jerk=900.0, dwell=0.05, sampling_period=1e-3)
    write_log(simulate(axis, true, path, Cascade("q", 20.0, 800.0, 10.0)).log, Path("both.csv"))
    with pytest.raises(EliminationError, match="measure x too"):
        symid.derive(axis)
    (row,) = identify_batch("belted.py", "both.csv", jobs=1).rows
    assert row["measured"] == "q,x"
    assert row["Ml"] == pytest.approx(22.0, rel=0.02)
