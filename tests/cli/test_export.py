"""`symid export`: what is written, and what is reported as lost."""

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest
from axes.shipped import VALUES
from command_line import run
from export.compiler import STRICT, compiler
from hand_made import rigid_log

from symid.cli.simulate_command import write_log

PARAMETERS = ("--parameters", "rigid_1m.json")


pytestmark = pytest.mark.usefixtures("parameters")


@pytest.mark.parametrize("axis", list(VALUES))
def test_source_and_header_compile_in_two_files_and_as_one_text(
    axis: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("export", axis, "--parameters", f"{axis}.json", "--to", "c", "-o", "drive.c") == 0
    assert "wrote drive.c" in capsys.readouterr().out
    assert run("export", axis, "--parameters", f"{axis}.json", "--to", "c") == 0
    (folder / "one.c").write_text(capsys.readouterr().out)
    for file in ("drive.c", "one.c"):
        subprocess.run([compiler(), *STRICT, "-c", file], check=True)


@pytest.mark.usefixtures("folder")
def test_losses_are_on_standard_error_and_in_the_record(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("export", "rigid_1m", *PARAMETERS, "--to", "mjcf", "-o", "a.xml", "--json", "-") == 0
    out, err = capsys.readouterr()
    record = json.loads(out)
    assert record["files"] == ["a.xml"]
    assert [f"lost: {loss}" for loss in record["losses"]] == err.splitlines()
    assert "creeps" in record["losses"][0]


@pytest.mark.usefixtures("folder")
def test_what_was_identified_keeps_its_covariance(capsys: pytest.CaptureFixture[str]) -> None:
    write_log(rigid_log(), Path("run.csv"))
    assert run("identify", "rigid_1m", "run.csv", "--json", "found.json") == 0
    found = json.loads(Path("found.json").read_text())
    capsys.readouterr()
    assert run("export", "rigid_1m", "--parameters", "found.json", "--to", "json") == 0
    record = json.loads(capsys.readouterr().out)
    physical = record["physical"]
    assert physical["names"] == ["M", "Fv", "Fs"]
    assert physical["units"] == ["kg", "N*s/m", "N"]
    assert physical["values"] == [found["physical"][name]["value"] for name in physical["names"]]
    wanted = [found["physical"][name]["std_corrected"] for name in physical["names"]]
    np.testing.assert_allclose(physical["std"], wanted, rtol=1e-9)
    covariance, correlation = (np.array(physical[name]) for name in ("covariance", "correlation"))
    np.testing.assert_allclose(correlation * np.outer(wanted, wanted), covariance, rtol=1e-9)
    assert -1 < correlation[1, 2] < -0.3  # viscous and Coulomb friction share the force


@pytest.mark.usefixtures("folder")
def test_plain_values_have_no_covariance(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("export", "direct_2m1s", "--parameters", "direct_2m1s.json", "--to", "json") == 0
    record = json.loads(capsys.readouterr().out)
    assert record["physical"]["std"] is None
    place = record["minimal"]["units"].index("s^2")
    assert record["minimal"]["values"][place] == pytest.approx((1700 + 460) / 1.3e8)


@pytest.mark.parametrize(
    ("arguments", "printed"),
    [
        (("export", "rigid_1m", "--to", "c"), "--parameters"),
        (("export", "rigid_1m", *PARAMETERS, "--to", "vhdl"), "'mjcf'"),
        (("export", "direct_2m1s", *PARAMETERS, "--to", "c"), "lacks Ms"),
        (("export", "rigid_1m", *PARAMETERS, "--to", "c", "-o", "nowhere/a.c"), "nowhere"),
    ],
)
@pytest.mark.usefixtures("folder")
def test_a_mistake_is_one_line(
    arguments: tuple[str, ...], printed: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(*arguments) == 2
    error = capsys.readouterr().err
    assert printed in error
    assert error.count("\n") == 1


@pytest.mark.parametrize("to", ["c", "fmu", "json", "mjcf", "st", "urdf"])
@pytest.mark.parametrize(
    ("wrong", "printed"),
    [({"Ks": -1e9}, "Ks -1e+09 of"), ({"Fsm": -98}, "Fsm -98 of"), ({"Mm": 0}, "not positive")],
)
def test_values_that_no_machine_has_are_not_exported(
    to: str, wrong: dict[str, float], printed: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "P.json").write_text(json.dumps({**VALUES["direct_2m1s"], **wrong}))
    assert run("export", "direct_2m1s", "--parameters", "P.json", "--to", to, "-o", f"a.{to}") == 2
    assert printed in capsys.readouterr().err
    assert not (folder / f"a.{to}").exists()


@pytest.mark.usefixtures("folder")
def test_what_a_diagnosis_found_is_exported(capsys: pytest.CaptureFixture[str]) -> None:
    write_log(rigid_log(lambda t, q, v, a, path: 300 * v * abs(v), seconds=5.0), Path("run.csv"))
    assert run("diagnose", "rigid_1m", "run.csv", "--write-axis", "explained.py") == 0
    values = json.loads(Path("explained.json").read_text())
    drag = values["motor_c"]
    assert drag == pytest.approx(300, rel=0.1)
    capsys.readouterr()
    arguments = ("export", "explained.py", "--parameters", "explained.json")
    for target, suffix in (("c", ".c"), ("mjcf", ".xml"), ("fmu", ".fmu")):
        assert run(*arguments, "--to", target, "-o", f"explained{suffix}") == 0
    assert "v_motor_*fabs(v_motor_)" in Path("explained.c").read_text()
    assert f'damping="{values["Fv"]!r} {drag!r}"' in Path("explained.xml").read_text()


HIDDEN = """
from symid import Axis, Between, Body, CoulombFriction, Drive, Position, Spring

motor, load = Body("motor", mass="Mm"), Body("load", mass="Ml")
belt = Spring("belt", Between(first=motor, second=load), stiffness="K")
sensors = (Position("q", motor), Position("x", load))
axis = Axis("belted", (motor, load, belt, CoulombFriction(load, "Fs")), Drive("F", motor), sensors)
"""


def test_an_axis_that_no_regressor_holds_is_exported_without_one(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "belted.py").write_text(HIDDEN)
    (folder / "p.json").write_text(json.dumps({"Mm": 8.0, "Ml": 22.0, "K": 6e5, "Fs": 18.0}))
    arguments = ("export", "belted.py", "--parameters", "p.json")
    assert run(*arguments, "--to", "c", "-o", "belted.c") == 0
    subprocess.run([compiler(), *STRICT, "-c", "belted.c"], check=True)
    assert "measure x too, leave the law out" in capsys.readouterr().err
    assert "belted_regressor" not in (folder / "belted.h").read_text()
    assert run(*arguments, "--to", "fmu", "-o", "belted.fmu") == 0
    assert run(*arguments, "--to", "c", "--measured", "q,x", "-o", "belted.c") == 0
    assert "belted_regressor" in (folder / "belted.h").read_text()
    subprocess.run([compiler(), *STRICT, "-c", "belted.c"], check=True)
