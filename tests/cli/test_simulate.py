"""`symid simulate` for every shipped axis, and its mistakes."""

import json
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from axes.shipped import VALUES
from command_line import run

from symid.axis import axis_names, load_axis
from symid.cli.options import parameter_file

pytestmark = pytest.mark.usefixtures("parameters")


def test_every_shipped_axis_has_values_here() -> None:
    assert set(axis_names()) == VALUES.keys()
    assert all(VALUES[name].keys() == load_axis(name).physical_parameters.keys() for name in VALUES)


@pytest.mark.parametrize("axis", VALUES)
@pytest.mark.parametrize("trajectory", ["trapezoids", "chirp"])
def test_every_shipped_axis_is_simulated_and_its_log_identified(
    folder: Path, axis: str, trajectory: str
) -> None:
    arguments = [
        "--parameters",
        f"{axis}.json",
        "--trajectory",
        trajectory,
        "--rate",
        "2000",
        "--seconds",
        "2",
    ]
    assert run("simulate", axis, *arguments, "--speed", "1", "-o", "run.parquet", "--json", "run.json") == 0
    record = json.loads((folder / "run.json").read_text())
    assert record["sampling_frequency_hz"] == pytest.approx(2000)
    force = load_axis(axis).drive.signal
    assert (
        run(
            "identify",
            axis,
            "run.parquet",
            "--held",
            force,
            "--nominal",
            f"{axis}.json",
            "--json",
            "found.json",
        )
        == 0
    )
    found = json.loads((folder / "found.json").read_text())
    assert found["residual"][force]["relative"] < 0.1


def test_a_log_leads_and_its_force_drives(folder: Path) -> None:
    common = ["rigid_1m", "--parameters", "rigid_1m.json"]
    assert run("simulate", *common, "--trajectory", "multisine", "--seconds", "2", "-o", "run.csv") == 0
    assert run("simulate", *common, "--trajectory", "run.csv", "-o", "follow.csv") == 0
    assert run("simulate", *common, "--open-loop", "run.csv", "-o", "open.csv") == 0
    first, again = ((folder / name).read_text().splitlines() for name in ("run.csv", "open.csv"))
    assert len(first) == len(again)


@pytest.mark.parametrize("seconds", ["10", "3.3"])
@pytest.mark.parametrize("trajectory", ["chirp", "multisine", "trapezoids"])
def test_the_reference_lasts_as_asked_and_its_reach_is_reported(
    folder: Path, trajectory: str, seconds: str, capsys: pytest.CaptureFixture[str]
) -> None:
    common = ["simulate", "rigid_1m", "--parameters", "rigid_1m.json", "--rate", "2000", "--travel", "0.2"]
    common += ["--trajectory", trajectory, "--seconds", seconds, "-o", "run.csv", "--overwrite"]
    assert run(*common) == 0
    printed = capsys.readouterr().out
    log = pl.read_csv(folder / "run.csv")
    assert log["t"][-1] - log["t"][0] == pytest.approx(float(seconds), abs=1.1 / 2000)
    reach = log["reference"].abs().max()
    if trajectory == "trapezoids":
        assert reach == pytest.approx(0.2, rel=1e-9)
        return
    assert f"travel {reach:.3g} of 0.2 m" in printed
    assert "acceleration is the limit" in printed
    acceleration = np.diff(log["reference"].to_numpy(), 2) * 2000**2
    assert np.abs(acceleration).max() == pytest.approx(5.0, rel=0.01)


def test_a_chirp_reaches_the_travel_that_its_limits_allow(folder: Path) -> None:
    common = ["simulate", "rigid_1m", "--parameters", "rigid_1m.json", "--rate", "2000", "--travel", "0.2"]
    loose = ["--trajectory", "chirp", "--speed", "9", "--acceleration", "900", "--band", "1,10"]
    reach, speed = {}, {}
    for quantity in ("position", "velocity", "acceleration"):
        file = f"{quantity}.csv"
        assert run(*common, *loose, "--amplitude-of", quantity, "-o", file) == 0
        reference = pl.read_csv(folder / file)["reference"].to_numpy()
        reach[quantity], speed[quantity] = np.abs(reference).max(), np.abs(np.diff(reference)).max() * 2000
    assert reach["velocity"] == pytest.approx(0.2, rel=1e-6)
    assert reach["acceleration"] == pytest.approx(0.2, rel=1e-6)
    assert speed["position"] == pytest.approx(9, rel=1e-3)  # the speed is the limit
    assert reach["position"] < 0.19


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("--trajectory circle", "not known"),
        ("--trajectory chirp --band 3", "LOW,HIGH"),
        ("--trajectory multisine --seconds 1e-9", "below half"),
        ("-o run.txt", ".parquet"),
        ("--controller-gain K=2", "Kpp"),
        ("--controller-gain Kpv=-1e9", "runs away"),
        ("--log-rate 3000", "multiple"),
        ("--noise z=1", "no signal 'z'"),
        ("--speed 0", "speed"),
        ("--delay q=1furlong", "furlong"),
        ("--parameters missing.json", "missing.json"),
        ("--parameters emps.json", "lacks Fs"),
    ],
)
def test_every_mistake_is_one_line_and_exit_2(
    folder: Path, arguments: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    before = sorted(folder.iterdir())
    common = ["simulate", "rigid_1m", "--parameters", "rigid_1m.json", "-o", "run.csv", "--rate", "2000"]
    assert run(*common, *arguments.split()) == 2
    shown = capsys.readouterr()
    assert (shown.out, shown.err.count("\n")) == ("", 1)
    assert words in shown.err
    assert sorted(folder.iterdir()) == before


def test_parameters_are_read_from_a_diagnosis_as_it_explains_them(folder: Path) -> None:
    explained = {"M": 5.0, "Fv": 3.0, "Fs": 2.0}
    entries = {
        name: {
            "nominal": 1.0,
            "reidentified": {"value": 2 * x, "std": 0.1},
            "explained": {"value": x, "std": 0.1},
        }
        for name, x in explained.items()
    }
    Path("diagnosis.json").write_text(
        json.dumps({"verdict": "effect", "parameters": entries}), encoding="utf-8"
    )
    assert parameter_file("diagnosis.json", load_axis("rigid_1m")) == explained
