"""`symid show` and `symid generate` from the command line."""

import json
import math
import os
import re
from pathlib import Path

import pytest
from axes.catalogue import cases

from symid.cli import main

AXIS_FILE = """
from symid import Axis, Body, Drive, Position, ViscousFriction
body = Body("body", mass="M")
axis = Axis("mine", (body, ViscousFriction(body, "{friction}")), Drive("F", body), (Position("q", body),))
"""


def run(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    """Exit code, standard output, standard error."""
    with pytest.raises(SystemExit) as left:
        main(list(arguments))
    out, err = capsys.readouterr()
    return int(left.value.code or 0), out, err


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with one axis of its own, called `mine`."""
    (tmp_path / "models").mkdir()
    declare(tmp_path, "Fv")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def declare(folder: Path, friction: str) -> None:
    (folder / "models" / "mine.py").write_text(AXIS_FILE.format(friction=friction), encoding="utf-8")


def test_show_writes_the_record_of_the_interface(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, "show", "direct_2m1s", "--json", "-")
    record = json.loads(out)
    assert (code, err) == (0, "")
    assert (record["axis"], record["measured"], record["output"]) == ("direct_2m1s", ["q2"], ["Fm"])
    columns = ["-Fm_d2", "-Fm_d1", "q2_d1", "sign(q2_d1)", "q2_d2", "q2_d3", "q2_d4"]
    assert record["regressor"] == [columns]
    assert record["minimal_parameters"]["X1"] == "(Mm + Ms)/Ks"
    assert list(record["minimal_parameters"]) == [f"X{i}" for i in range(1, 8)]
    assert record["inverse"]["Mm"] == "-X2*X3 + X5"
    assert record["identifiability"] == dict.fromkeys(["Ms", "Fvs", "Ks", "Mm", "Fvm", "Fsm"], "unique")
    assert record["assumptions"] == ["derivatives of sign(q2_d1) are taken as zero"]


def test_show_says_null_where_there_is_no_inverse_map(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = tmp_path / "mine.py"
    text = AXIS_FILE.format(friction="Fv").replace(
        "(body, V", '(body, Body("rider", mass="Mr", geared=Geared(to=body, ratio=1)), V'
    )
    path.write_text(text.replace("import Axis", "import Geared, Axis"), encoding="utf-8")
    _, out, _ = run(capsys, "show", str(path), "--json", "-")
    record = json.loads(out)
    assert record["inverse"] is None
    assert record["identifiability"] == {"M": "none", "Mr": "none", "Fv": "unique"}


def test_show_takes_sensors_in_any_order(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    target = tmp_path / "record.json"
    code, out, _ = run(capsys, "show", "direct_2m1s", "--measured", "ddq1,q2", "--json", str(target))
    record = json.loads(target.read_text(encoding="utf-8"))
    assert (code, record["measured"], record["output"]) == (0, ["q2", "ddq1"], ["Fm", "-Fm_d2"])
    assert "ddq1_d2" in out


@pytest.mark.parametrize("name", [name for name, case in cases().items() if case.shipped])
def test_show_prints_every_shipped_axis(capsys: pytest.CaptureFixture[str], name: str) -> None:
    code, out, err = run(capsys, "show", name)
    assert (code, err) == (0, "")
    for text in (name, "Equations of motion", "Minimal model y = D X", "Inverse map", "Identifiability"):
        assert text in out
    assert all(parameter in out for parameter in cases()[name].values)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("show", "direct_9m"), "there is no axis 'direct_9m' (did you mean 'direct_"),
        (("show", "direct_2m1s", "--measured", "q7"), "has no sensor 'q7': choose from q2, ddq1, ddq2"),
        (("show", "direct_2m1s", "--measured", "ddq1"), "CoulombFriction at 'motor'"),
        (("show",), "Missing argument"),
        (("idetify",), "No such command 'idetify' (did you mean 'identify'?)"),
        (("generate", "direct_9m"), "there is no axis 'direct_9m'"),
        (("show", "direct_2m1s", "--json", "no/such/folder/x.json"), "no/such/folder/x.json: No such file"),
    ],
)
def test_a_mistake_is_one_line_and_exit_code_2(
    capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...], message: str
) -> None:
    code, out, err = run(capsys, *arguments)
    assert (code, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1


@pytest.mark.parametrize("command", ["show", "generate"])
def test_help_has_an_example(capsys: pytest.CaptureFixture[str], command: str) -> None:
    code, out, _ = run(capsys, command, "--help")
    assert code == 0
    assert f"Example: symid {command} direct_2m1s" in out


def test_check_is_content_with_the_committed_modules(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, "generate", "--check")
    assert (code, err) == (0, "")
    count = int(out.split(" of ")[0])
    assert out == f"{count} of {count} files are current\n"
    assert count >= sum(len(case.declared.sensor_sets) for case in cases().values() if case.shipped)


def test_generate_writes_and_check_finds_what_is_stale(
    capsys: pytest.CaptureFixture[str], project: Path
) -> None:
    module = project / "generated" / "mine__q.py"
    assert run(capsys, "generate", "mine", "--check")[0] == 1
    assert not module.exists()
    code, out, _ = run(capsys, "generate", "mine")
    assert (code, "wrote mine__q.py" in out, module.is_file()) == (0, True, True)
    assert run(capsys, "generate", "mine", "--check")[0] == 0
    declare(project, "Fviscous")
    before = module.read_text(encoding="utf-8")
    code, out, _ = run(capsys, "generate", "mine", "--check")
    assert code == 1
    assert "--- mine__q.py (found)" in out
    assert '+PHYSICAL_PARAMETERS = ("M", "Fviscous")' in out
    assert module.read_text(encoding="utf-8") == before
    assert run(capsys, "generate", "mine")[0] == 0
    assert "Fviscous" in module.read_text(encoding="utf-8")


def test_check_reports_as_json(capsys: pytest.CaptureFixture[str], project: Path) -> None:
    code, out, _ = run(capsys, "generate", "mine", "--check", "--json", "-")
    assert (code, json.loads(out)) == (1, {"checked": 2, "stale": ["mine__q.py", "mine__dynamics.json"]})
    assert not (project / "generated").exists()


def test_modules_nobody_declares_are_found_by_check_and_removed(
    capsys: pytest.CaptureFixture[str], project: Path
) -> None:
    run(capsys, "generate", "mine")
    orphan = project / "generated" / "mine__q_old.py"
    orphan.write_text("import numpy as np\n", encoding="utf-8")
    code, out, _ = run(capsys, "generate", "mine", "--check")
    assert (code, "-import numpy as np" in out, orphan.exists()) == (1, True, True)
    code, out, _ = run(capsys, "generate", "mine")
    assert (code, "removed mine__q_old.py" in out, orphan.exists()) == (0, True, False)


def test_a_failing_disk_leaves_the_old_module_and_one_line(
    capsys: pytest.CaptureFixture[str], project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run(capsys, "generate", "mine")
    module = project / "generated" / "mine__q.py"
    before = module.read_text(encoding="utf-8")
    declare(project, "Fviscous")

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device", "mine__q.py")

    monkeypatch.setattr(os, "replace", full)
    code, _, err = run(capsys, "generate", "mine")
    assert (code, err) == (2, f"symid: {module}: No space left on device: free some space\n")
    assert module.read_text(encoding="utf-8") == before


def test_generate_keeps_modules_of_axis_files_beside_and_sets_asked_for(
    capsys: pytest.CaptureFixture[str], project: Path
) -> None:
    sensors = '(Position("q", body), Position("a", body, relative_to=GROUND))'
    declared = (project / "models" / "mine.py").read_text(encoding="utf-8")
    declared = declared.replace("import Axis", "import GROUND, Axis").replace(
        '(Position("q", body),)', sensors
    )
    (project / "models" / "mine.py").write_text(declared, encoding="utf-8")
    (project / "beside.py").write_text(declared.replace('"mine"', '"beside"'), encoding="utf-8")
    assert run(capsys, "generate", "beside.py")[0] == 0
    assert run(capsys, "generate", "mine", "--measured", "a")[0] == 0
    assert run(capsys, "generate")[0] == 0
    kept = {path.name for path in (project / "generated").iterdir()}
    assert {"beside__q.py", "mine__q.py", "mine__q_a.py", "mine__a.py"} <= kept
    code, out, _ = run(capsys, "generate", "--check")
    assert (code, "are current" in out) == (0, True)


def test_generate_writes_what_it_can_and_names_what_it_cannot(
    project: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Coulomb friction on a load that only one set of sensors sees."""
    text = """
from symid import Axis, Between, Body, CoulombFriction, Drive, Position, Spring
motor, load = Body("motor", mass="Mm"), Body("load", mass="Ml")
nut = Spring("nut", Between(first=motor, second=load), stiffness="K")
axis = Axis(
    "mine",
    (motor, load, nut, CoulombFriction(load, "Fs")),
    Drive("F", motor),
    (Position("qm", motor), Position("ql", load)),
)
"""
    (project / "models" / "mine.py").write_text(text, encoding="utf-8")
    code, out, err = run(capsys, "generate", "mine")
    assert code == 1
    assert "wrote mine__qm_ql.py" in out
    assert err.startswith("symid: mine__qm.py cannot be derived: ")
    assert "measure ql too" in err
    assert [path.name for path in (project / "generated").glob("*.py")] == ["mine__qm_ql.py"]
    code, out, _ = run(capsys, "generate", "mine", "--check", "--json", "-")
    assert (code, list(json.loads(out)["refused"])) == (1, ["mine__qm.py"])


def test_show_writes_long_fractions_as_decimals(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """Two motors on one belt: the square of half the radius of a pulley was a fraction of 65 digits."""
    path = tmp_path / "mine.py"
    text = """
from math import pi
from symid import *
a, b = Body("a", inertia="J"), Body("b", inertia="J")
half = 0.04 / pi / 2
x = Body("x", mass="M", geared=(Geared(to=a, ratio=half), Geared(to=b, ratio=half)))
y = Body("y", mass="m", geared=(Geared(to=a, ratio=half), Geared(to=b, ratio=-half)))
axis = Axis("mine", (a, b, x, y), (Drive("Ta", a), Drive("Tb", b)), (Position("qa", a), Position("qb", b)))
"""
    path.write_text(text, encoding="utf-8")
    code, out, err = run(capsys, "show", str(path))
    assert (code, err) == (0, "")
    assert "J + 4.05285e-5*M + 4.05285e-5*m" in out
    assert not re.search(r"\d{8}", out)
    record = json.loads(run(capsys, "show", str(path), "--json", "-")[1])
    exact = 0.003 + 10 * (0.04 / math.pi / 2) ** 2
    values = {"J": 0.003, "M": 3.0, "m": 7.0}
    assert eval(record["minimal_parameters"]["X1"], values) == pytest.approx(exact, rel=1e-15)
