"""No command overwrites what it reads, or what it did not write."""

import json
import os
import shutil
from importlib import import_module
from pathlib import Path

import pytest
from command_line import run

from symid.axis import loading

P = {"M": 95.0, "Fv": 200.0, "Fs": 20.0}
TROUBLE = "which this command reads|exists|holds no results|is a folder|are one file"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with parameters and two short recordings."""
    monkeypatch.chdir(tmp_path)
    Path("P.json").write_text(json.dumps(P), encoding="utf-8")
    rows = "".join(f"{0.001 * i},{(i % 200 - 100) ** 2 * 1e-5},{i % 7}\n" for i in range(3000))
    for name in ("in.csv", "other.csv"):
        Path(name).write_text("t,q,F\n" + rows, encoding="utf-8")
    Path("notes.html").write_text("my notes", encoding="utf-8")
    Path("mine.py").write_text("# by hand\n", encoding="utf-8")
    Path("mine.xml").write_text('<robot name="mine"/>', encoding="utf-8")
    Path("picture.png").write_text("t,q,F\n", encoding="utf-8")
    Path("hard.json").hardlink_to("P.json")
    Path("log.json").write_text(json.dumps({"t": [0.0, 0.1], "q": [1.0, 2.0]}), encoding="utf-8")
    Path("mapping.json").write_text(json.dumps({"columns": {"t": "t"}, "guesses": []}), encoding="utf-8")
    Path("derived.json").write_text(
        json.dumps({"axis": "a", "measured": ["q"], "regressor": []}), encoding="utf-8"
    )
    Path("broken.json").write_text("{", encoding="utf-8")
    return tmp_path


@pytest.mark.parametrize(
    "arguments",
    [
        "identify rigid_1m in.csv --json in.csv",
        "identify rigid_1m in.csv --json other.csv",
        "identify rigid_1m in.csv --nominal P.json --json P.json",
        "identify rigid_1m in.csv --json P.json",
        "identify rigid_1m in.csv --json log.json",
        "identify rigid_1m in.csv --json derived.json",
        "identify rigid_1m in.csv --json mapping.json",
        "identify rigid_1m in.csv --json broken.json",
        "diagnose rigid_1m in.csv --write-axis P.py",
        "import in.csv --axis rigid_1m -o log.json",
        "identify rigid_1m in.csv --nominal P.json --json hard.json",
        "identify rigid_1m in.csv --plot picture.png",
        "import in.csv --axis rigid_1m -o in.csv",
        "import in.csv --axis rigid_1m --json in.csv",
        "diagnose rigid_1m in.csv --next-experiment in.csv",
        "diagnose rigid_1m in.csv --next-experiment other.csv",
        "diagnose rigid_1m in.csv --report notes.html",
        "diagnose rigid_1m in.csv --write-axis mine.py",
        "diagnose rigid_1m in.csv --nominal P.json --write-axis P.py",
        "diagnose rigid_1m in.csv --json r.json --report r.json",
        "batch rigid_1m in.csv -o in.csv",
        "batch rigid_1m in.csv -o r.parquet -o other.csv",
        "batch rigid_1m in.csv -o r.parquet --json in.csv",
        "batch rigid_1m in.csv -o r.parquet --report notes.html",
        "simulate rigid_1m --parameters P.json -o in.csv",
        "simulate rigid_1m --parameters P.json -o run.csv --json P.json",
        "simulate rigid_1m --parameters P.json --trajectory in.csv -o in.csv --overwrite",
        "export rigid_1m --parameters P.json --to c -o P.json",
        "export rigid_1m --parameters P.json --to json -o P.json",
        "export rigid_1m --parameters P.json --to c -o mine.py",
        "export rigid_1m --parameters P.json --to mjcf -o mine.xml",
        "export rigid_1m --parameters P.json --to urdf -o mine.xml",
        "show rigid_1m --json in.csv",
        "show mine.py --json mine.py",
        "new axis --json in.csv",
        "demo --report in.csv",
    ],
)
def test_nothing_is_overwritten(arguments: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    assert run(*arguments.split()) == 2
    printed = capsys.readouterr().err
    assert any(words in printed for words in TROUBLE.split("|")), printed
    assert printed.count("\n") == 1
    assert {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()} == before


def test_results_are_written_again(folder: Path) -> None:
    for _ in range(2):
        assert run("show", "rigid_1m", "--json", "r.json", "--plot", "r.svg") == 0
        for target in ("c", "mjcf", "urdf", "st", "fmu"):
            assert (
                run("export", "rigid_1m", "--parameters", "P.json", "--to", target, "-o", f"r.{target}") == 0
            )
        assert run("import", "in.csv", "--axis", "rigid_1m", "-o", "map.json", "--plot", "in.pdf") == 0
    assert {"r.json", "r.svg", "r.c", "r.h", "map.json", "in.pdf"} < {path.name for path in folder.iterdir()}


def test_a_simulation_is_replaced_on_request(folder: Path) -> None:
    simulate = ["simulate", "rigid_1m", "--parameters", "P.json", "--rate", "500", "-o", "run.csv"]
    assert [run(*simulate), run(*simulate), run(*simulate, "--overwrite")] == [0, 2, 0]


def test_devices_are_written_to(folder: Path) -> None:
    assert run("show", "rigid_1m", "--json", os.devnull) == 0
    assert not Path(os.devnull).is_file()


def test_generate_beside_a_folder_of_models_leaves_the_installation_alone(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """An axis of models/ that bears a shipped name shadows it; the modules of the shipped one stay."""
    installed = folder / "site" / "symid"
    source = loading.shipped_folder("models").parent
    for name in ("models", "generated"):
        shutil.copytree(source / name, installed / "shipped" / name)
    monkeypatch.setattr(loading, "_PACKAGE", installed)
    for name in ("rigid_1m", "emps"):
        (folder / "models").mkdir(exist_ok=True)
        shutil.copy(source / "models" / f"{name}.py", folder / "models")
    before = {path: path.read_bytes() for path in installed.rglob("*.py")}
    # the package shows the function of the same name
    generation = import_module("symid.codegen.generation.generate")
    monkeypatch.setattr(generation, "axis_names", lambda: ("rigid_1m", "emps", "emps_asymmetric"))
    assert run("generate") == 0
    assert {path: path.read_bytes() for path in installed.rglob("*.py")} == before
    assert sorted(path.name for path in (folder / "generated").iterdir()) == [
        f"{name}__{what}" for name in ("emps", "rigid_1m") for what in ("dynamics.json", "q.py")
    ]
    assert "removed" not in capsys.readouterr().out


def test_a_file_by_hand_among_the_modules_is_kept_beside(folder: Path) -> None:
    assert run("new", "own", "--bodies", "1") == 0
    assert run("generate", "own") == 0
    Path("generated/own__notes.py").write_text("mine = 1\n", encoding="utf-8")
    assert run("generate", "own") == 0
    assert Path("generated/own__notes.py.before").read_text(encoding="utf-8") == "mine = 1\n"
