"""`symid simulate` for every shipped axis, and its mistakes."""

import json
from pathlib import Path

import pytest
from axes.shipped import VALUES, write_parameters
from command_line import run

from symid.axis import axis_names, load_axis


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    write_parameters(tmp_path)
    return tmp_path


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


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("--trajectory circle", "not known"),
        ("--trajectory chirp --band 3", "LOW,HIGH"),
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
