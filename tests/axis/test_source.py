"""Axes written as axis files: what is loaded again is what was declared, in text that a formatter leaves alone."""

import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from axes.catalogue import cases
from axes.effects import EFFECTS, with_effect

from symid import (
    GROUND,
    Axis,
    Between,
    Body,
    Damper,
    Drive,
    Geared,
    Law,
    PendulumWeight,
    Position,
    Spring,
    StribeckFriction,
    Term,
    Velocity,
    ViscousFriction,
    Weight,
    axis_source,
    load_axis,
    write_axis,
)
from symid.axis import axis_names, axis_path
from symid.errors import SettingError, SymidError


def read_again(axis: Axis, folder: Path) -> Axis:
    file = folder / f"{axis.name}.py"
    assert write_axis(axis, file) == axis
    return load_axis(str(file))


@pytest.mark.parametrize("name", axis_names())
def test_shipped_axes_are_written_as_they_are(name: str, tmp_path: Path) -> None:
    axis = load_axis(name)
    again = read_again(axis, tmp_path)
    assert again == axis
    assert again.signature == axis.signature
    assert [s.noise for s in again.sensors] == [s.noise for s in axis.sensors]


@pytest.mark.parametrize("name", EFFECTS)
def test_axes_with_an_effect_are_written_as_they_are(name: str, tmp_path: Path) -> None:
    axis = with_effect(name)
    again = read_again(axis, tmp_path)
    assert again == axis
    assert again.signature == axis.signature


def of_own_laws(axis: Axis) -> bool:
    return any(not type(law).__module__.startswith("symid") for law in axis.laws)


@pytest.mark.parametrize("name", [name for name, case in cases().items() if not of_own_laws(case.declared)])
def test_all_kinds_of_axes_are_written_as_they_are(name: str, tmp_path: Path) -> None:
    axis = cases()[name].declared
    assert read_again(axis, tmp_path).signature == axis.signature


def everything() -> Axis:
    """Names that collide, bodies declared before what carries them, numbers of every kind, all options."""
    structure = Body("Body", mass="Ms")
    screw = Body("axis", inertia="Js", on=structure)
    table = Body("table", mass="Mt", geared=Geared(to=screw, ratio=np.float64(0.01) / 3))
    load = Body("load", mass="Ml")
    across = Between(first=screw, second=load, ratio=1e-3)
    return Axis(
        "everything",
        (
            table,
            load,
            screw,
            structure,
            Spring("guide", structure, stiffness="Kg"),
            Damper("rubber", across, damping="Fr"),
            Spring("nut", across, stiffness="Kn"),
            ViscousFriction(Between(first=GROUND, second=load, ratio=1.0), "Fvl"),
            Weight(load, -3),
            PendulumWeight(screw, "ml", 1.5),
            StribeckFriction(screw, "dF", velocity=np.float64(1) / 3),
        ),
        Drive("T", screw, gain=-2, command="i", held=True, noise=0.25, resolution=np.float64(1e-7)),
        (
            Position("angle", screw, noise=1e-9, resolution=1e-6),
            Velocity("speed", load, relative_to=structure, delay=1e-4),
        ),
    )


def test_every_field_is_written(tmp_path: Path) -> None:
    axis = everything()
    again = read_again(axis, tmp_path)
    assert again == axis
    assert again.signature == axis.signature
    text = axis_source(axis)
    assert 'Body_ = Body("Body", mass="Ms")' in text
    assert text.index("axis_ = ") < text.index("table = ")
    assert text.count("Between(") == 2
    assert "float64" not in text


def test_formatter_and_linter_leave_the_text_alone(tmp_path: Path) -> None:
    axes = [everything(), *map(load_axis, axis_names()), *map(with_effect, EFFECTS)]
    for number, axis in enumerate(axes):
        (tmp_path / f"a{number}.py").write_text(axis_source(axis, "An axis, " + "much " * 40 + "told."))
    for options in ([], ["--line-length", "110"]):
        for command in (["format", "--check"], ["check", "--select", "F,W,I,UP,D300"]):
            run = subprocess.run(
                [sys.executable, "-m", "ruff", *command, "--isolated", *options, str(tmp_path)],
                capture_output=True,
                text=True,
                check=False,
            )
            assert run.returncode == 0, run.stdout + run.stderr


def test_a_file_gives_its_name_to_the_axis_and_is_overwritten(tmp_path: Path) -> None:
    axis, file = load_axis("rigid_1m"), tmp_path / "mine.py"
    file.write_text("old")
    summary = 'It says """no""" \\ here.'
    assert write_axis(axis, file, summary) == replace(axis, name="mine") == load_axis(str(file))
    assert file.read_text().startswith("\"\"\"It says '''no''' / here.\"\"\"\n")


@pytest.mark.parametrize("name", ["2m.py", "a b.py", "axis.txt", "axis", "q_d1.py", ".py"])
def test_files_that_cannot_name_an_axis_are_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(SettingError, match=r"cannot name an axis: use NAME\.py"):
        write_axis(load_axis("rigid_1m"), tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_a_folder_that_does_not_exist_is_named_in_one_line(tmp_path: Path) -> None:
    with pytest.raises(SymidError, match=r"nowhere.*cannot be written: No such file") as refused:
        write_axis(load_axis("rigid_1m"), tmp_path / "nowhere" / "mine.py")
    assert "\n" not in str(refused.value)


@dataclass(frozen=True)
class OwnLaw(Law):
    """A law that symid does not know."""

    level: str

    def terms(self) -> tuple[Term, ...]:
        """One term."""
        return (Term(self.level, "sign(v)"),)


def test_a_law_of_the_user_s_own_is_refused() -> None:
    axis = load_axis("rigid_1m")
    with pytest.raises(SettingError, match="OwnLaw of axis 'rigid_1m' is not a class of symid"):
        axis_source(axis.with_effect(OwnLaw(axis.bodies[0], "dF")))


def test_the_path_of_an_axis_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    assert axis_path(tmp_path / "found.py") == tmp_path / "found.py"
    with pytest.raises(SettingError, match="without an ending such as _d2"):
        axis_path(tmp_path / "found_d2.py")
