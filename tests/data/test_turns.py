"""Positions of drives that count turns are read as such, or asked for, never taken for rad."""

from pathlib import Path

import numpy as np
import pytest

from symid import Axis, Body, Drive, Position, ViscousFriction
from symid.data.formats.registry import READERS
from symid.data.text_files.foreign import foreign_columns
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
