"""`symid new`: what it writes loads at once, and is an axis like any other."""

from pathlib import Path

import pytest
from command_line import run

from symid import identify, load_axis, load_generated, simulate
from symid.simulation import plant_of, trapezoids, tuned_cascade

COMBINATIONS = {
    "one_body": ("--bodies 1", ["Mm", "Fvm", "Fsm"], 0),
    "two_bodies": ("", ["Ml"], 1),
    "screw": ("--encoder load", ["Ml"], 1),
    "bench": ("--rotary --encoder load --no-coulomb", ["Jm", "Jl"], 1),
    "paper": ("--structure --accelerometer structure", ["Ms", "Ks"], 1),
    "flexure": ("--bodies 1 --springs 1", ["Km"], 1),
    "large": ("--bodies 4 --springs 3 --structure --accelerometer load2 --encoder load", ["Ml2", "Kl2"], 3),
    "gantry": ("--drives 2", ["Mm", "Mm2", "Kc", "Cc"], 1),
    "beam": ("--drives 2 --bodies 4 --encoder load", ["Kl", "Kl_m2", "Kl2", "Fsm2"], 3),
}


@pytest.mark.parametrize("name", COMBINATIONS)
def test_what_is_written_loads_shows_and_generates(
    folder: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    options, parameters, springs = COMBINATIONS[name]
    assert run("new", name, *options.split()) == 0
    assert f"wrote models/{name}.py" in capsys.readouterr().out
    text = (folder / "models" / f"{name}.py").read_text(encoding="utf-8")
    assert text.count("Spring(") == springs
    assert text.count("    # ") >= 3
    axis = load_axis(name)
    assert set(parameters) <= set(axis.physical_parameters)
    sensors = ",".join(sensor.signal for sensor in axis.sensors)
    assert run("show", name, "--measured", sensors) == 0
    assert run("generate", name, "--measured", sensors) == 0
    assert run("generate", str(folder / "models" / f"{name}.py"), "--check", "--measured", sensors) == 0


def test_a_written_axis_is_identified_from_its_simulation(folder: Path) -> None:
    assert run("new", "mine.py", "--bodies", "1") == 0
    assert run("generate", "mine.py") == 0
    axis, true = load_axis("mine.py"), {"Mm": 40.0, "Fvm": 30.0, "Fsm": 12.0}
    reference = trapezoids([0.2], [0.1, 0.4], acceleration=4.0, jerk=200.0, dwell=0.1, sampling_period=1e-3)
    log = simulate(axis, true, reference, tuned_cascade(plant_of(axis, true), "q")).log
    found = identify(load_generated("mine.py", ("q",)), log).physical_parameters
    assert found["Mm"] == pytest.approx(40.0, rel=5e-3)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("new 2masses", "cannot name an axis"),
        ("new my-axis", "cannot name an axis"),
        ("new lambda", "cannot name an axis"),
        ("new rigid_1m", "comes with symid"),
        ("new mine --bodies 0", "at least 1"),
        ("new mine --bodies 1 --structure", "at least 2 with a structure"),
        ("new mine --bodies 3 --springs 1", "2 or 3 springs"),
        ("new mine --encoder table", "choose from motor, load"),
    ],
)
def test_mistakes_are_one_line_and_write_nothing(
    folder: Path, arguments: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(*arguments.split()) == 2
    err = capsys.readouterr().err
    assert words in err
    assert err.count("\n") == 1
    assert not list(folder.rglob("*.py"))


def test_nothing_is_overwritten(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "mine.py").write_text("axis = None\n", encoding="utf-8")
    assert run("new", "mine.py") == 2
    assert "exists" in capsys.readouterr().err
    assert (folder / "mine.py").read_text(encoding="utf-8") == "axis = None\n"
