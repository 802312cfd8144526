"""What is known of parameters, in a batch: rows are those of each log alone with the same knowledge."""

import json
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from command_line import run
from fleet_logs import TRUE

import symid
from symid.cli.simulate_command import write_log
from symid.errors import EliminationError, SettingError
from symid.fleet import BatchSettings, identify_batch
from symid.fleet.plan import fleet_axes
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


def test_nominal_values_need_not_hold_what_is_fixed(logs: Path) -> None:
    Path("nominal.json").write_text(json.dumps({name: TRUE[name] for name in ("Fv", "Fs")}))
    fixed = ("--fix", "M=5kg", "--nominal", "nominal.json", "--jobs", "1")
    assert run("batch", "rigid_1m", str(logs), "-o", "r.csv", *fixed) == 0


def test_a_set_of_sensors_that_was_not_generated_is_derived() -> None:
    axis = symid.load_axis("ballscrew_2m1s").with_known({"Ml": 100.0})
    (plan,) = fleet_axes(axis, BatchSettings())
    generated = {signals for signals, _ in plan.modules}
    assert ("qm", "ql") not in generated
    assert plan.model(("qm", "ql")).measured == ("qm", "ql")


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
    with pytest.raises(SettingError, match="ddof is not possible with method 'iv'"):
        BatchSettings(method="iv", ddof=3)
    arguments = ("batch", "rigid_1m", str(logs), "-o", "r.csv")
    assert run(*arguments, "--fix", "Mx=1") == 2
    assert "--fix Mx is not known: choose from M, Fv, Fs" in capsys.readouterr().err
    assert run(*arguments, "--bounds", "M=5") == 2
    assert "LOW..HIGH" in capsys.readouterr().err


LOADED = """
from symid import Axis, Body, CoulombFriction, Drive, Geared, Position, ViscousFriction

table = Body("table", mass="M")
load = Body("load", mass="Ml", geared=Geared(to=table, ratio=1.0))
friction = (ViscousFriction(table, "Fv"), CoulombFriction(table, "Fs"))
axis = Axis("loaded", (table, load, *friction), Drive("F", table), (Position("q", table),))
"""


def loaded_logs() -> None:
    """Runs of a table of 40 kg with 0, 5 and 20 kg on it, by hand."""
    Path("loaded.py").write_text(LOADED)
    t = np.arange(4000) / 1000
    q = 0.1 * np.sin(7 * t) + 0.02 * np.sin(17 * t)
    v, a = 0.7 * np.cos(7 * t) + 0.34 * np.cos(17 * t), -4.9 * np.sin(7 * t) - 5.78 * np.sin(17 * t)
    Path("runs").mkdir()
    for name, mass in (("a", 0.0), ("b", 5.0), ("c", 20.0)):
        noise = np.random.default_rng(int(mass)).standard_normal(t.size)
        force = (40.0 + mass) * a + 90.0 * v + 12.0 * np.sign(v) + noise
        pl.DataFrame({"t": t, "q": q, "F": force}).write_csv(f"runs/{name}.csv")


def test_each_log_has_a_payload_of_its_own(folder: Path) -> None:
    loaded_logs()
    Path("payloads.csv").write_text("\ufefflog;Ml [g]\na.csv;0\nruns/b.csv;5000,0\n\nc.csv;20000\n", "utf-8")
    batch = ("batch", "loaded.py", "runs", "-o", "r.parquet", "--known", "payloads.csv", "--json", "s.json")
    assert run(*batch, "--jobs", "1") == 0
    rows = read_rows(Path("r.parquet"))
    assert [row["known"] for row in rows] == ["Ml=0", "Ml=5", "Ml=20"]
    for row, payload in zip(rows, (0.0, 5.0, 20.0), strict=True):
        assert row["M"] == pytest.approx(40.0, rel=2e-3)
        alone = symid.identify("loaded.py", str(row["log"]), fixed={"Ml": payload})
        assert (row["M"], row["Fv_std"]) == (alone.physical_parameters["M"], alone.physical_deviations[1])
    keys = [row["key"] for row in rows]
    Path("payloads.csv").write_text("log,Ml\na.csv,0\nb.csv,5\nc.csv,21\n")
    assert run(*batch, "--jobs", "2") == 0
    again = read_rows(Path("r.parquet"))
    assert [row["key"] == key for row, key in zip(again, keys, strict=True)] == [True, True, False]
    assert again[2]["M"] == pytest.approx(39.0, rel=2e-3)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("log,Ml\na.csv,0\n", "known values of 2 of 3 logs are missing, first those of runs/b.csv"),
        ("name,Ml\na.csv,0\n", "has no column log"),
        ("log,Mx\na.csv,0\n", "Mx is not known: choose from M, Ml, Fv, Fs"),
        ("log,Ml\na.csv,0\na.csv,1\n", "give each log one row of 2 values"),
        ("log,Ml\na.csv,0\nb.csv,1\nc.csv,heavy\n", "must be a finite number"),
    ],
)
def test_payloads_that_are_missing_or_wrong_are_refused(
    table: str,
    words: str,
    folder: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    loaded_logs()
    Path("payloads.csv").write_text(table)
    assert run("batch", "loaded.py", "runs", "-o", "r.parquet", "--known", "payloads.csv") == 2
    assert words in capsys.readouterr().err
    with pytest.raises(SettingError, match="do not go with `joint`"):
        identify_batch(
            "loaded.py", "runs/a.csv", known={"a.csv": {"Ml": 0.0}}, settings=BatchSettings(joint=True)
        )


BELTED = """
from symid import Axis, Between, Body, CoulombFriction, Drive, Position, Spring, ViscousFriction

motor, load = Body("motor", mass="Mm"), Body("load", mass="Ml")
belt = Spring("belt", Between(first=motor, second=load), stiffness="K", damping="D")
friction = (ViscousFriction(motor, "Fv"), CoulombFriction(load, "Fs"))
sensors = (Position("q", motor, noise=1e-8), Position("x", load, noise=1e-8))
axis = Axis("belted", (motor, load, belt, *friction), Drive("F", motor, held=True), sensors)
"""


def test_sensors_that_allow_no_model_alone_do_not_stop_a_batch(folder: Path) -> None:
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
