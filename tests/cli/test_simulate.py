"""`symid simulate` for every shipped axis, and its mistakes."""

import json
from pathlib import Path

import pytest

from symid.axis import axis_names, load_axis
from symid.cli import main

VALUES = {
    "rigid_1m": {"M": 100, "Fv": 80, "Fs": 40},
    "direct_2m1s": {"Ms": 1700, "Fvs": 24000, "Ks": 1.3e8, "Mm": 460, "Fvm": 104, "Fsm": 98},
    "ballscrew_2m1s": {"Mm": 80, "Fvm": 120, "Fsm": 50, "Kt": 6e6, "Ft": 700, "Ml": 200, "Fvl": 150},
    "direct_3m2s": {
        "Ms": 3899,
        "Fvs": 3949,
        "Ks": 1e9,
        "Mm": 362,
        "Fvm": 88,
        "Fsm": 146,
        "Kl": 4e7,
        "Fl": 900,
        "Ml": 60,
    },
    "emps": {"M": 95, "Fv": 203, "Fc": 20, "OF": -3},
    "emps_asymmetric": {"M": 95, "Fvp": 166, "Fcp": 20, "Fvn": 240, "Fcn": 21},
    "motor_bench": {"Jm": 0.0049, "Fvm": 0.02, "Kt": 555, "Ft": 0.009, "Pt": 0, "Jl": 0.0049, "Fvl": 0.1},
}


def run(*arguments: str) -> int:
    with pytest.raises(SystemExit) as stop:
        main(list(arguments))
    return int(stop.value.code or 0)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    for name, values in VALUES.items():
        Path(f"{name}.json").write_text(json.dumps(values))
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
