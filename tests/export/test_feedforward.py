"""Feed-forward in C and Structured Text against forces written by hand."""

import ctypes
import math
import re
import shutil
import subprocess
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from axes.catalogue import cases, derived
from axes.shipped import VALUES, write_parameters
from blark.parse import parse_source_code
from command_line import run
from export.compiler import compiler

from symid import (
    ActuatorLag,
    Axis,
    Between,
    Body,
    CoulombFriction,
    Drive,
    PayloadChange,
    Position,
    PositionStiffness,
    PreslidingFriction,
    Spring,
    load_axis,
)
from symid.errors import SettingError
from symid.export import c_source, structured_text
from symid.export.feedforward import feedforward
from symid.symbolic import derive

G = 9.80665
BY_HAND = {
    "direct_2m1s": lambda p, q, v, a: p["Mm"] * a + p["Fvm"] * v + p["Fsm"] * np.sign(v),
    "ballscrew_2m1s": lambda p, q, v, a: (
        (p["Mm"] + p["Ml"]) * a + (p["Fvm"] + p["Fvl"]) * v + p["Fsm"] * np.sign(v)
    ),
    "emps": lambda p, q, v, a: p["M"] * a + p["Fv"] * v + p["Fc"] * np.sign(v) + p["OF"],
    "emps_asymmetric": lambda p, q, v, a: (
        p["M"] * a + (p["Fcp"] + p["Fvp"] * v if v > 0 else -p["Fcn"] + p["Fvn"] * v)
    ),
    "reduction_gear": lambda p, q, v, a: (
        (p["Jm"] + p["Mt"] / 25) * a + (p["Fvm"] + p["Fvt"] / 25) * v + (p["Fsm"] + p["Fst"] / 5) * np.sign(v)
    ),
    "vertical_2m1s": lambda p, q, v, a: (p["Mm"] + p["Ml"]) * (a + G) + p["Fvm"] * v + p["Fsm"] * np.sign(v),
    "flexible_pendulum": lambda p, q, v, a: (
        (p["Jm"] + p["Ja"] / 2500) * a
        + (p["Fvm"] + p["Fva"] / 2500) * v
        + p["ml"] * G * math.sin(q / 50) / 50
    ),
    "ripple_and_drag": lambda p, q, v, a: (
        p["Mm"] * a
        + p["c"] * v * abs(v)
        + p["As"] * math.sin(4 * math.pi * q)
        + p["Ac"] * math.cos(4 * math.pi * q)
    ),
}
MOTIONS = [(0.3, 0.2, 1.5), (-0.1, -0.4, -2.0), (1.7, -0.05, 0.5)]


def executed(text: str, **inputs: float) -> dict[str, float]:
    """Values of a block after one call, its statements read as those of Python."""
    declared = re.findall(r"^    (\w+) : LREAL(?: := ([-+\d.E]+))?;", text, re.MULTILINE)
    values = {name: float(value) if value else 0.0 for name, value in declared} | inputs
    body = text.partition("END_VAR\n\nIF")[2].partition("END_FUNCTION_BLOCK")[0]
    for st, python in (
        ("IF ", "if "),
        (" THEN", ":"),
        ("ELSE", "else:"),
        ("END_IF", ""),
        (";", ""),
        (":=", "="),
    ):
        body = body.replace(st, python)
    functions = {
        "ABS": abs,
        "SIN": math.sin,
        "COS": math.cos,
        "EXPT": pow,
        "SEL": lambda which, first, second: second if which else first,
    }
    exec("if" + body, functions, values)
    return values


@pytest.mark.parametrize("name", list(BY_HAND))
def test_the_block_gives_the_force_that_a_motion_needs(name: str) -> None:
    case = cases()[name]
    text = structured_text(case.declared, case.values).text
    assert parse_source_code(text) is not None  # a parser of TwinCAT's Structured Text
    for q, v, a in MOTIONS:
        found = executed(text, position=q, velocity=v, acceleration=a)
        wanted = BY_HAND[name](case.values, q, v, a)
        assert found["force"] == pytest.approx(wanted, rel=1e-12)
        resting = BY_HAND[name](case.values, q, v, 0.0) - executed(text, position=q, velocity=0.0)["force"]
        if name not in ("emps_asymmetric",):  # whose friction has a mean of both directions at rest
            assert found["friction"] == pytest.approx(resting, rel=1e-12)
        if (gain := case.declared.drive.factor) != 1.0:
            assert found["command"] == pytest.approx(wanted / gain, rel=1e-12)


@pytest.mark.parametrize("name", list(BY_HAND))
def test_the_c_function_gives_the_force_that_a_motion_needs(name: str, tmp_path: Path) -> None:
    case = cases()[name]
    library = _built(c_source(derived(name, case.sensor_sets[0]), case.values).files, name, tmp_path)
    function = library[f"{name}_feedforward"]
    function.restype = ctypes.c_double
    parameters = np.array([float(value) for value in case.values.values()])
    for motion in MOTIONS:
        found = function(parameters.ctypes, *map(ctypes.c_double, motion))
        assert found == pytest.approx(BY_HAND[name](case.values, *motion), rel=1e-12)


def test_the_c_function_in_single_precision(tmp_path: Path) -> None:
    name = next(iter(BY_HAND))
    case = cases()[name]
    exported = c_source(derived(name, case.sensor_sets[0]), case.values)
    library = _built(exported.files, name, tmp_path, "-DSYMID_REAL=float")
    function = library[f"{name}_feedforward"]
    function.restype = ctypes.c_float
    parameters = np.array(list(case.values.values()), dtype=np.float32)
    for motion in MOTIONS:
        found = function(parameters.ctypes, *map(ctypes.c_float, motion))
        assert found == pytest.approx(BY_HAND[name](case.values, *motion), rel=1e-5, abs=1e-4)


def _built(files: Mapping[str, str], name: str, folder: Path, *options: str) -> ctypes.CDLL:
    for suffix, text in files.items():
        (folder / f"{name}{suffix}").write_text(text)
    strict = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC")
    command = [compiler(), *strict, *options, f"{name}.c", "-lm", "-o", "axis.so"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return ctypes.CDLL(str(folder / "axis.so"))


def test_cpp_calls_what_c_has_compiled(tmp_path: Path) -> None:
    axis = load_axis("rigid_1m")
    _built(c_source(derive(axis), VALUES["rigid_1m"], "rigid_1m").files, "rigid_1m", tmp_path)
    (tmp_path / "main.cpp").write_text(
        '#include "rigid_1m.h"\n#include <cstdio>\n'
        'int main() { std::printf("%.17g", rigid_1m_feedforward(&rigid_1m_values, 0.0, 0.5, 2.0)); }\n'
    )
    cpp = next((path for one in ("c++", "g++", "clang++") if (path := shutil.which(one))), None)
    assert cpp, "no C++ compiler on the path: install one (apt-get install g++)"
    command = [cpp, "-Wall", "-Werror", "main.cpp", "./axis.so", "-o", "main"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    printed = subprocess.run(
        [tmp_path / "main"], check=True, capture_output=True, text=True, cwd=tmp_path
    ).stdout
    p = VALUES["rigid_1m"]
    assert float(printed) == pytest.approx(2.0 * p["M"] + 0.5 * p["Fv"] + p["Fs"], rel=1e-12)


def test_friction_is_a_line_at_rest_and_words_of_the_language_are_free() -> None:
    text = structured_text(load_axis("emps"), VALUES["emps"]).text
    p = VALUES["emps"]
    assert "OF_p : LREAL" in text
    half = executed(text, velocity=5e-5)
    assert half["friction"] == pytest.approx(0.5 * p["Fc"] + 5e-5 * p["Fv"])
    assert executed(text, velocity=-0.1, rest_speed=0.0)["friction"] == pytest.approx(
        -p["Fc"] - 0.1 * p["Fv"]
    )


def test_parameters_may_have_the_names_of_the_block_and_of_standard_functions() -> None:
    motor, load = Body("motor", mass="force"), Body("load", mass="Max")
    belt = Spring("belt", Between(first=motor, second=load), stiffness="direction")
    sliding = CoulombFriction(motor, "friction")
    axis = Axis("named", (motor, sliding, belt, load), Drive("F", motor), (Position("q", motor),))
    text = structured_text(axis, {"force": 3.0, "Max": 4.0, "direction": 1e6, "friction": 2.0}).text
    assert executed(text, velocity=-0.1, acceleration=0.5)["force"] == pytest.approx(7.0 * 0.5 - 2.0)
    assert "Max_p : LREAL" in text


def test_an_axis_without_a_motion_of_its_own_is_refused() -> None:
    case = cases()["chain_2m2s_1"]
    with pytest.raises(SettingError, match="0 motions in which no spring deflects"):
        structured_text(case.declared, case.values)


def test_a_force_of_the_position_moves_along_where_a_spring_may_not_deflect() -> None:
    """A stage with a cable chain on an isolated base, and a scanner with a torsion bar: both were refused."""
    base = Body("base", mass="Mb")
    stage = Body("stage", mass="Ms", on=base)
    isolator, chain = Spring("isolator", base, stiffness="Kb"), PositionStiffness(stage, "kc")
    isolated = Axis("isolated", (base, stage, isolator, chain), Drive("F", stage), (Position("q", stage),))
    found = structured_text(isolated, {"Mb": 900.0, "Ms": 22.0, "Kb": 4e5, "kc": 60.0}).text
    moved = {"position": 0.2, "velocity": 0.5, "acceleration": 3.0}
    assert executed(found, **moved)["force"] == pytest.approx(22.0 * 3.0 + 60.0 * 0.2, rel=1e-12)
    rotor, mirror = Body("rotor", inertia="Jr"), Body("mirror", inertia="Jm")
    shaft = Spring("shaft", Between(first=rotor, second=mirror), stiffness="K")
    elements = (rotor, mirror, PositionStiffness(rotor, "kb"), shaft)
    scanner = Axis("scanner", elements, Drive("T", rotor), (Position("phi", rotor),))
    found = structured_text(scanner, {"Jr": 1.5e-7, "Jm": 1e-7, "kb": 0.047, "K": 60.0}).text
    assert executed(found, **moved)["force"] == pytest.approx(2.5e-7 * 3.0 + 0.047 * 0.2, rel=1e-12)


def test_the_command_writes_a_block(folder: Path) -> None:
    write_parameters(folder)
    for _ in range(2):  # its own kind is replaced
        assert run("export", "rigid_1m", "--parameters", "rigid_1m.json", "--to", "st", "-o", "axis.st") == 0
    assert "FUNCTION_BLOCK FB_rigid_1m_Feedforward" in Path("axis.st").read_text()
    Path("own.st").write_text("FUNCTION_BLOCK own\nEND_FUNCTION_BLOCK\n")
    assert run("export", "rigid_1m", "--parameters", "rigid_1m.json", "--to", "st", "-o", "own.st") == 2


def test_imperfections_are_left_out_of_the_block_which_says_so() -> None:
    plain = load_axis("rigid_1m")
    (body,) = plain.bodies
    values = {"M": 95.0, "Fv": 200.0, "Fs": 20.0}
    presliding, lag = PreslidingFriction(body, 12.0, reach=3e-4), ActuatorLag(2e-3)
    exported = structured_text(plain.with_effect(presliding, lag, PayloadChange(body, 3.0, time=2.0)), values)
    assert parse_source_code(exported.text).exception is None
    q, v, a = MOTIONS[0]
    found = executed(exported.text, position=q, velocity=v, acceleration=a)
    assert found["force"] == pytest.approx(95.0 * a + 200.0 * v + 20.0)
    assert [loss.partition(":")[0] for loss in exported.losses] == [
        "PreslidingFriction",
        "ActuatorLag",
        "PayloadChange",
    ]
    for element in (presliding, lag):
        assert element.formula.split()[0] in exported.text


def test_a_long_chain_moves_as_one_mass() -> None:
    """Springs of symbols between eight bodies, where a search for zeros took long."""
    bodies = [Body(f"b{i}", mass=f"m{i}") for i in range(8)]
    springs = (
        Spring(f"s{i}", Between(first=bodies[max(i - 2, 0)], second=bodies[i]), stiffness=f"K{i}")
        for i in range(1, 8)
    )
    axis = Axis("chain", (*bodies, *springs), Drive("F", bodies[0]), (Position("q", bodies[0]),))
    total = sum(sp.Symbol(f"m{i}") for i in range(8))
    assert sp.expand(feedforward(axis).force - total * sp.Symbol("acceleration_")) == 0
