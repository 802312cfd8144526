"""Axis files: by name, by path, from the working folder, and everything that can be wrong with one."""

from pathlib import Path

import pytest

from symid.axis import axis_file, axis_names, load_axis
from symid.errors import DeclarationError, SymidError

SOUND = """
from symid import Axis, Body, Drive, Position
body = Body("body", mass="M")
axis = Axis("{name}", (body,), Drive("F", body), (Position("q", body),))
"""

SHIPPED = {
    "ballscrew_2m1s",
    "direct_2m1s",
    "direct_3m2s",
    "emps",
    "emps_asymmetric",
    "motor_bench",
    "rigid_1m",
}


def written(folder: Path, name: str, text: str) -> Path:
    path = folder / f"{name}.py"
    path.write_text(text, encoding="utf-8")
    return path


def test_all_shipped_axes_load_under_their_names() -> None:
    assert set(axis_names()) >= SHIPPED
    assert [load_axis(name).name for name in sorted(SHIPPED)] == sorted(SHIPPED)


def test_shipped_axes_are_what_the_interface_promises() -> None:
    parameters = {name: set(load_axis(name).physical_parameters) for name in SHIPPED}
    assert parameters["rigid_1m"] == {"M", "Fv", "Fs"}
    assert parameters["direct_2m1s"] == {"Ms", "Fvs", "Ks", "Mm", "Fvm", "Fsm"}
    assert parameters["ballscrew_2m1s"] == {"Mm", "Fvm", "Fsm", "Kt", "Ft", "Ml", "Fvl"}
    assert parameters["direct_3m2s"] == {"Ms", "Fvs", "Ks", "Mm", "Fvm", "Fsm", "Kl", "Fl", "Ml"}
    assert parameters["emps"] == {"M", "Fv", "Fc", "OF"}
    sensors = {name: [sensor.signal for sensor in load_axis(name).sensors] for name in SHIPPED}
    assert sensors["rigid_1m"] == ["q"]
    assert sensors["direct_2m1s"] == ["q2", "ddq1", "ddq2"]
    assert sensors["ballscrew_2m1s"] == ["qm", "ql"]
    assert sensors["direct_3m2s"] == ["q2", "ddq1", "ddql"]
    emps = load_axis("emps").drive
    assert (emps.signal, emps.command, emps.gain) == ("F", "vir", 35.15065188248547)


def test_an_axis_loads_from_a_path(tmp_path: Path) -> None:
    path = written(tmp_path, "mine", SOUND.format(name="mine"))
    assert load_axis(str(path)).name == "mine"


def test_the_working_folder_s_models_come_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "models").mkdir()
    own = written(tmp_path / "models", "rigid_1m", SOUND.format(name="rigid_1m"))
    written(tmp_path / "models", "mine", SOUND.format(name="mine"))
    monkeypatch.chdir(tmp_path)
    assert axis_file("rigid_1m") == own.resolve()
    assert list(load_axis("rigid_1m").physical_parameters) == ["M"]
    assert "mine" in axis_names()
    assert load_axis("direct_2m1s").name == "direct_2m1s"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("axis = (", "axis file mine.py cannot be run: SyntaxError"),
        ("raise ValueError('no')", "axis file mine.py cannot be run: ValueError: no"),
        ("import no_such_module", "axis file mine.py cannot be run: ModuleNotFoundError"),
        ("x = 1", "axis file mine.py defines no axis: end it with axis = Axis(...)"),
        ("axis = 'mine'", "axis file mine.py defines no axis"),
        (SOUND.format(name="other"), "axis file mine.py declares the axis 'other': give both the same name"),
    ],
)
def test_a_file_that_declares_no_sound_axis_is_refused_in_one_line(
    tmp_path: Path, text: str, message: str
) -> None:
    path = written(tmp_path, "mine", text)
    with pytest.raises(SymidError) as refused:
        load_axis(str(path))
    assert message in str(refused.value)
    assert "\n" not in str(refused.value)


def test_faults_of_a_declaration_in_a_file_stay_all_reported(tmp_path: Path) -> None:
    text = SOUND.format(name="mine").replace('mass="M"', 'mass="F"').replace('"q"', '"t"')
    with pytest.raises(DeclarationError) as refused:
        load_axis(str(written(tmp_path, "mine", text)))
    assert len(refused.value.faults) == 2


def test_a_missing_axis_is_refused_with_those_that_exist() -> None:
    with pytest.raises(
        SymidError,
        match=r"there is no axis 'direct_9m' \(did you mean 'direct_.*'\?\): choose from .*direct_2m1s",
    ):
        load_axis("direct_9m")
    with pytest.raises(SymidError, match=r"there is no axis file 'nowhere/a\.py'"):
        load_axis("nowhere/a.py")
