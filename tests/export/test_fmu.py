"""The exported unit, run by FMPy, against the simulation."""

import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from axes.catalogue import cases, derived
from axes.shipped import VALUES, write_parameters
from command_line import run
from driven import driven
from export.exported_unit import run_unit
from fmpy.validation import validate_fmu

from symid import load_axis
from symid.errors import SettingError
from symid.export import write_fmu
from symid.export.fmu import FmiVersion
from symid.simulation import plant_of
from symid.symbolic import derive

PERIOD = 1e-3


@pytest.mark.parametrize(("name", "fmi"), [*((name, 2) for name in VALUES), ("direct_2m1s", 3), ("emps", 3)])
def test_a_unit_moves_as_the_simulation_does(name: str, fmi: FmiVersion, tmp_path: Path) -> None:
    axis, values = load_axis(name), VALUES[name]
    file = tmp_path / f"{name}.fmu"
    losses = write_fmu(derive(axis), values, file, fmi)
    assert any("linux64" in loss or "darwin64" in loss for loss in losses)
    assert validate_fmu(str(file)) == []
    assert fmpy.read_model_description(str(file)).fmiVersion == f"{fmi}.0"
    plant = plant_of(axis, values)
    t = PERIOD * np.arange(400)
    size = 0.5 * float(np.trace(plant.mass)) + 2 * sum(law.limits(0.0)[1] for law in plant.laws)
    force = np.where(t < 0.25, size * np.sin(2 * np.pi * 6 * t), 0.0)
    drive = axis.drive.command or axis.drive.signal
    signal = axis.sensors[0].signal
    found = run_unit(file, {drive: force / (axis.drive.gain or 1.0)}, signal, PERIOD)
    states = driven(axis, values, force, PERIOD)[1:]
    wanted = states[:, : len(plant.bodies)] @ plant.sensors[signal].row
    assert np.max(np.abs(found - wanted)) < 1e-3 * np.ptp(wanted)


@pytest.mark.parametrize("fmi", [2, 3])
def test_parameters_can_be_set_and_a_held_axis_rests(fmi: FmiVersion, tmp_path: Path) -> None:
    case = cases()["vertical_2m1s"]
    file = tmp_path / "vertical.fmu"
    write_fmu(derived("vertical_2m1s", case.sensor_sets[0]), case.values, file, fmi)
    weight = -float(np.sum(plant_of(case.declared, case.values).constant))
    found = fmpy.simulate_fmu(
        str(file),
        stop_time=0.5,
        output_interval=0.01,
        start_values={"Fsm": 2 * weight, "F": 0.0},
        output=["qm"],
        fmi_type="CoSimulation",
    )
    assert np.ptp(found["qm"]) < 1e-12, "friction of twice the weight holds the motor"
    falling = fmpy.simulate_fmu(str(file), stop_time=0.5, output=["qm"], start_values={"F": 0.0})
    assert falling["qm"][-1] < -0.1


def test_variables_have_units_and_descriptions(tmp_path: Path) -> None:
    file = tmp_path / "bench.fmu"
    write_fmu(derive(load_axis("motor_bench")), VALUES["motor_bench"], file)
    assert validate_fmu(str(file)) == []
    description = fmpy.read_model_description(str(file))
    found = {v.name: v.unit for v in description.modelVariables}
    assert (found["iq"], found["Jm"], found["internal_step"]) == ("A", "A*s^2/rad", "s")
    assert all(v.description for v in description.modelVariables)
    base = {unit.name: unit.baseUnit for unit in description.unitDefinitions}["A*s^2/rad"]
    assert (base.A, base.s, base.rad, base.kg) == (1, 2, -1, 0)


def test_a_binary_for_windows_is_cross_compiled(tmp_path: Path) -> None:
    """Compiled and exporting the interface; no Windows runs it here."""
    pytest.importorskip("ziglang", reason="pip install ziglang (100 MB) to cross-compile")
    file = tmp_path / "a.fmu"
    losses = write_fmu(derive(load_axis("rigid_1m")), VALUES["rigid_1m"], file)
    assert any("linux64 and win64" in loss or "darwin64 and win64" in loss for loss in losses)
    with zipfile.ZipFile(file) as unit:
        library = unit.read("binaries/win64/rigid_1m.dll")
    header = int.from_bytes(library[0x3C:0x40], "little")
    assert library[:2] == b"MZ"
    assert library[header : header + 6] == b"PE\0\0\x64\x86"  # for x86-64
    for name in (b"fmi2Instantiate", b"fmi2DoStep", b"fmi2GetReal", b"fmi2SetReal"):
        assert name + b"\0" in library


def test_the_unit_holds_its_sources(tmp_path: Path) -> None:
    file = tmp_path / "a.fmu"
    write_fmu(derive(load_axis("rigid_1m")), VALUES["rigid_1m"], file)
    held = set(zipfile.ZipFile(file).namelist())
    assert {
        "modelDescription.xml",
        "sources/rigid_1m.c",
        "sources/rigid_1m.h",
        "sources/rigid_1m_fmu.c",
    } <= held


def test_without_a_compiler_it_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(SettingError, match="compiler"):
        write_fmu(derive(load_axis("rigid_1m")), VALUES["rigid_1m"], tmp_path / "a.fmu")


def test_the_command_writes_a_unit(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_parameters(folder)
    arguments = ("export", "rigid_1m", "--parameters", "rigid_1m.json", "--to", "fmu")
    assert run(*arguments, "-o", "newer.fmu", "--fmi", "3") == 0
    assert fmpy.read_model_description("newer.fmu").fmiVersion == "3.0"
    assert run(*arguments, "-o", "axis.fmu") == 0
    assert fmpy.read_model_description("axis.fmu").fmiVersion == "2.0"
    assert "wrote axis.fmu" in capsys.readouterr().out
    assert zipfile.is_zipfile("axis.fmu")
    assert run(*arguments) == 2
    assert "-o FILE.fmu" in capsys.readouterr().err
