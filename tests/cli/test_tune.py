"""`symid tune` for every shipped axis, its two ways, and its mistakes."""

import json
from pathlib import Path

import pytest
from command_line import run

from symid.axis import axis_names, load_axis
from symid.report.figures.colours import DARK, LIGHT

STATUSES = {"ok", "bound_not_reached", "bound_met_everywhere", "not_determined"}


pytestmark = pytest.mark.usefixtures("parameters")


def tuned(axis: str, *options: str) -> dict:
    parameters = ["--parameters", f"{axis}.json", "--json", "tuned.json"]
    assert run("tune", axis, *parameters, *options) == 0
    return json.loads(Path("tuned.json").read_text())


@pytest.mark.parametrize("axis", axis_names())
def test_every_shipped_axis_is_tuned(folder: Path, axis: str) -> None:
    found = tuned(axis, "--seconds", "4", "--rate", "10000")
    assert found["status"] == "ok", found["message"]
    assert found["cutoff"]["largest_error_percent"] == pytest.approx(0.01, rel=0.03)
    assert found["sampling"]["largest_error_percent"] <= 1.02
    assert found["sampling_hz"] > 2 * found["filter"]["cutoff_hz"]
    named = set(found["sampling"]["errors_percent"]) | set(found["left_out"])
    assert named >= load_axis(axis).physical_parameters.keys() - {"Pt"}


def test_table_and_figure(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    tuned("rigid_1m", "--seconds", "4", "--rate", "5000", "--plot", "tuning.svg", "--dark")
    printed = capsys.readouterr().out
    assert "sampling frequency [37]" in printed
    assert "without forces that jump at standstill: Fs" in printed
    drawn = (folder / "tuning.svg").read_text().lower()
    assert DARK.paper.lower() in drawn
    assert LIGHT.paper.lower() not in drawn


def test_what_no_motion_determines_has_a_dash(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Pinion and carriage: only J + r^2 M is determined."""
    Path("rack.py").write_text(
        "from symid import *\n"
        'pinion = Body("pinion", inertia="J")\n'
        'carriage = Body("carriage", mass="M", geared=Geared(to=pinion, ratio=0.04))\n'
        'axis = Axis("rack", (pinion, carriage, ViscousFriction(pinion, "Fv")), Drive("T", pinion), '
        '(Position("q", pinion),))\n'
    )
    Path("rack.json").write_text('{"J": 0.3, "M": 200.0, "Fv": 2.0}')
    assert run("tune", "rack.py", "--parameters", "rack.json", "--seconds", "4", "--rate", "5000") == 0
    printed = capsys.readouterr().out
    assert {line.split()[0]: line.split()[1] for line in printed.splitlines() if line[1:2] in "JM"} == {
        "J": "–",
        "M": "–",
    }


def test_trapezoids_and_acceleration_sensor(folder: Path) -> None:
    options = (
        "--trajectory",
        "trapezoids",
        "--measured",
        "q2,ddq1",
        "--rate",
        "10000",
        "--max-sampling-error",
        "5",
    )
    found = tuned("direct_2m1s", *options)
    assert found["measured"] == ["q2", "ddq1"]
    assert found["status"] in STATUSES


def test_total_error_from_a_log_and_from_given_noise(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    simulated = ["simulate", "rigid_1m", "--parameters", "rigid_1m.json", "-o", "run.csv", "--rate", "1000"]
    noise = ["--noise", "q=1e-7", "--noise", "F=2"]
    assert run(*simulated, *noise, "--travel", "0.05", "--dwell", "0.05") == 0
    found = tuned("rigid_1m", "--noise-from", "run.csv", "--held", "F", "--plot", "total.svg", "--dark")
    assert found["noise"]["F"] == pytest.approx(2.0, rel=0.5)
    assert found["status"] == "ok"
    assert 0 < found["total_error_percent"] < 2
    assert found["errors_percent"]["M"].keys() == {"systematic", "total"}
    assert DARK.paper.lower() in (folder / "total.svg").read_text().lower()
    assert "decimation" in capsys.readouterr().out
    given = tuned("rigid_1m", *noise, "--log-rate", "1000", "--seconds", "4", "--rate", "4000")
    assert given["noise"] == {"F": 2.0, "q": 1e-7}


@pytest.mark.parametrize(
    ("options", "shown"),
    [
        (["--max-sampling-error", "0"], "must be positive"),
        (["--noise", "q=1e-7"], "noise of F is not given"),
        (["--measured", "nothing"], "no sensor 'nothing'"),
        (["--plot", "tuning.bmp", "--seconds", "2", "--rate", "2000"], "of an unknown kind"),
        (["--band", "5"], "is not LOW,HIGH"),
    ],
)
def test_mistakes_are_one_line(
    folder: Path, capsys: pytest.CaptureFixture[str], options: list[str], shown: str
) -> None:
    arguments = ["tune", "rigid_1m", "--parameters", "rigid_1m.json", "--rate", "2000", "--seconds", "2"]
    assert run(*arguments, *options) == 2
    error = capsys.readouterr().err
    assert shown in error
    assert error.count("\n") == 1
