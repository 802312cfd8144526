"""`symid excite` of a hoist: its load rests in its rope at first, and all sensors with noise identify it."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from command_line import run

from symid import (
    Axis,
    Between,
    Body,
    CoulombFriction,
    Drive,
    Position,
    Spring,
    ViscousFriction,
    Weight,
    write_axis,
)

DRUM, LOAD = Body("drum", inertia="J"), Body("load", mass="M")
ROPE = Spring("rope", Between(first=DRUM, second=LOAD, ratio=0.1), stiffness="K", damping="C")
HOIST = Axis(
    "hoist",
    (DRUM, ViscousFriction(DRUM, "Fv"), CoulombFriction(DRUM, "Fs"), LOAD, Weight(LOAD), ROPE),
    Drive("T", DRUM, held=True, noise=0.05),
    (Position("q", DRUM, noise=1e-6), Position("z", LOAD, noise=1e-7)),
)
TRUE = {"J": 0.02, "Fv": 0.4, "Fs": 1.5, "M": 20.0, "K": 2e4, "C": 80.0}
RUN = "--rate 1000 --seconds 1.5 --seeds 0 --runs 4 --bandwidth 5"
LIMITS = "--limits travel=2,speed=2,acceleration=20,force=50"


def test_the_axis_hangs_in_its_rope_before_the_first_move(folder: Path) -> None:
    """A load that falls from relaxed springs would pull the drum more than any reference: M g r / (J + M r^2)."""
    write_axis(HOIST, "hoist.py")
    Path("P.json").write_text(json.dumps(TRUE))
    command = f"excite hoist.py --parameters P.json --fix M=20kg {RUN} {LIMITS} -o r.csv --json r.json"
    assert run(*command.split()) == 0
    record = json.loads(Path("r.json").read_text())
    designed = record["expected"]["designed"]
    assert record["measured"] == ["q", "z"]  # those whose noise is known
    assert set(designed["relative"]) == set(TRUE) - {"M"}
    assert designed["reached"]["acceleration"] <= 20.0 < 20.0 * 9.80665 * 0.1 / (TRUE["J"] + 20.0 * 0.01)
    play = "simulate hoist.py --parameters P.json --trajectory r.csv --rate 1000 --bandwidth 5 --start equilibrium"
    assert run(*play.split(), "-o", "run.csv") == 0
    log = pd.read_csv("run.csv")
    assert np.ptp(log["q"]) == pytest.approx(designed["reached"]["travel"], rel=1e-3)
    assert np.abs(log["T"]).max() == pytest.approx(designed["reached"]["force"], abs=0.3)
