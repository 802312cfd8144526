"""Positions of drives that count turns are read as such, or asked for, never taken for rad."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from symid import Axis, Body, Drive, Position, ViscousFriction, load_axis
from symid.data.formats.registry import READERS
from symid.data.text_files.foreign import described_column, foreign_columns
from symid.identification.signals.guessed_mapping import guessed_mapping

ROTOR = Body("rotor", inertia="J")
AXIS = Axis("spindle", (ROTOR, ViscousFriction(ROTOR, "D")), Drive("T", ROTOR), (Position("angle", ROTOR),))


@pytest.mark.parametrize(
    ("position", "speed", "unit"),
    [("pos_estimate", "vel_estimate", "turn"), ("position", "vel [rpm]", "turn"), ("position", "vel", None)],
)
def test_turns_are_read_or_asked_for(tmp_path: Path, position: str, speed: str, unit: str | None) -> None:
    t = np.arange(2000) / 1000
    turns, rate = 0.4 * np.sin(9 * t), 3.6 * np.cos(9 * t)
    columns = t, turns, rate * (60 if "rpm" in speed else 1), np.cos(9 * t)
    file = tmp_path / "a.csv"
    head = f"t [s],{position},{speed},torque [N*m]"
    np.savetxt(file, np.column_stack(columns), delimiter=",", header=head, comments="")
    mapping = guessed_mapping(AXIS, foreign_columns(READERS[".csv"](file, None)))
    assert mapping.units.get("angle") == unit
    assert any("rad, deg or turn" in line for line in mapping.missing) == (unit is None)


def test_turns_of_a_slide_and_long_angles_are_asked_for(tmp_path: Path) -> None:
    t = np.arange(2000) / 1000
    file = tmp_path / "a.csv"
    columns = t, 30 * np.sin(9 * t), np.cos(9 * t), np.cos(9 * t)
    head = "t [s],axis0_pos_estimate,theta,torque [N*m]"
    np.savetxt(file, np.column_stack(columns), delimiter=",", header=head, comments="")
    found = foreign_columns(READERS[".csv"](file, None))
    slide = guessed_mapping(load_axis("rigid_1m"), found, named={"q": "axis0_pos_estimate"}, gain=1.0)
    assert any("turn, does not convert to m" in line for line in slide.missing)
    slide = guessed_mapping(
        load_axis("rigid_1m"), found, named={"q": "axis0_pos_estimate"}, units={"q": "5 mm"}
    )
    assert slide.units["q"] == "5 mm"
    assert not any("has no unit" in line for line in slide.missing)
    long = [replace(c, extent=(-30.0, 30.0), unit="mm") if c.header == "theta" else c for c in found]
    for columns, known in ((found, "rad"), (long, None)):
        assert guessed_mapping(AXIS, columns, named={"angle": "theta"}).units.get("angle") == known


def test_whole_numbers_are_si_where_the_column_is_called_as_the_force() -> None:
    values = np.round(90 * np.sin(np.arange(80.0)))
    for name, asked in (("F", False), ("Torque", True)):
        columns = described_column("t", 1e-3 * np.arange(80)), described_column(name, values)
        missing = guessed_mapping(load_axis("rigid_1m"), columns).missing
        assert any("F has no factor" in line for line in missing) == asked


def test_the_column_that_is_called_as_the_force_is_taken_whatever_else_its_name_suggests() -> None:
    """Volts are often v."""
    axis = Axis("spindle", (ROTOR,), Drive("v", ROTOR), (Position("angle", ROTOR),))
    t = np.arange(80.0)
    columns = [described_column(name, np.sin(t + k)) for k, name in enumerate(("a", "v", "angle [rad]"))]
    found = guessed_mapping(axis, [described_column("t", 1e-3 * t), *columns])
    assert found.columns["v"] == "v"
    assert "v is column 'v': its name is that of the signal; no unit, so SI is assumed" in found.guesses
