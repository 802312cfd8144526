"""Forward dynamics in the folder of generated modules: used without sympy while they are those of the declaration."""

import subprocess
import sys
from pathlib import Path

import pytest

from symid import load_axis
from symid.codegen.generation.dynamics_record import dynamics_record
from symid.codegen.generation.generate import generate
from symid.codegen.store import dynamics_text, stored_dynamics
from symid.errors import SymidError
from symid.simulation import plant_of
from symid.simulation.plants.dynamics_terms import LawTerm, Polynomial

AXIS = """
from symid import Axis, Body, CoulombFriction, Drive, Position

body = Body("body", mass="M")
axis = Axis("mine", (body, CoulombFriction(body, "Fs")), Drive("F", body), (Position("q", body),))
"""


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The forward dynamics of an axis in a file of its own."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "models").mkdir()
    (tmp_path / "models" / "mine.py").write_text(AXIS, encoding="utf-8")
    generate(["mine"])
    return tmp_path / "generated" / "mine__dynamics.json"


def test_a_shipped_axis_is_simulated_without_sympy(tmp_path: Path) -> None:
    (tmp_path / "P.json").write_text('{"M": 5, "Fv": 3, "Fs": 2}', encoding="utf-8")
    code = (
        "import sys; from symid.cli import main\n"
        "try: main('simulate rigid_1m --parameters P.json -o log.csv --rate 1000'.split())\n"
        "finally: print('sympy' in sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert done.stdout.endswith("False\n")
    assert (tmp_path / "log.csv").is_file()


def test_what_is_stored_is_what_is_derived(file: Path) -> None:
    axis = load_axis("mine")
    found = stored_dynamics(axis)
    assert found is not None
    assert {name: found[name] for name in dynamics_record(axis)} == dynamics_record(axis)
    assert plant_of(axis, {"M": 2.0, "Fs": 3.0}).laws[0].limits(0.0) == (-3.0, 3.0)


def test_a_file_that_was_edited_or_is_of_another_declaration_is_not_used(file: Path) -> None:
    axis, text = load_axis("mine"), file.read_text(encoding="utf-8")
    for damaged in (text.replace("1.0", "2.0"), text[:-20], "[]", ""):
        file.write_text(damaged, encoding="utf-8")
        assert stored_dynamics(axis) is None
        assert plant_of(axis, {"M": 2.0, "Fs": 3.0}).mass.tolist() == [[2.0]]
    file.write_text(text, encoding="utf-8")
    assert stored_dynamics(axis) is not None
    (file.parent.parent / "models" / "mine.py").write_text(AXIS.replace('"Fs"', '"Fc"'), encoding="utf-8")
    assert stored_dynamics(load_axis("mine")) is None


@pytest.mark.parametrize("code", ["__import__('os')", "np.load('f')", "w*v", "np.sign(v).real", "[v]"])
def test_no_code_but_that_of_the_law_language_is_run(file: Path, code: str) -> None:
    with pytest.raises(SymidError, match="is not of the law language"):
        LawTerm.of(Polynomial(((1.0, ()),)), code)


def test_the_text_says_whose_it_is() -> None:
    axis = load_axis("rigid_1m")
    assert "Forward dynamics of axis rigid_1m. Generated" in dynamics_text(axis, dynamics_record(axis))
