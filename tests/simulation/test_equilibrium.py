"""A start at rest in equilibrium, beside deflections and holding forces by hand."""

import json
from pathlib import Path

import numpy as np
import polars as pl
import pytest
import scipy
from command_line import run

from symid import (
    ActuatorLag,
    Axis,
    Between,
    Body,
    CoulombFriction,
    Damper,
    Drive,
    Geared,
    PendulumWeight,
    Position,
    Spring,
    StiffnessNonlinearity,
    ViscousFriction,
    Weight,
    write_axis,
)
from symid.errors import SettingError
from symid.simulation import Cascade, Controller, OpenLoop, Trajectory, plant_of, simulate, steps
from symid.simulation.plants.equilibrium import equilibrium

G, PERIOD = 9.80665, 1e-3
MOTOR, LOAD = Body("motor", mass="Mm"), Body("load", mass="Ml")
SPRING = Between(first=MOTOR, second=LOAD)
HOIST = Axis(
    "hoist",
    (
        *(MOTOR, Weight(MOTOR), ViscousFriction(MOTOR, "Fv"), CoulombFriction(MOTOR, "Fs")),
        *(LOAD, Weight(LOAD), Spring("rope", SPRING, stiffness="K", damping="D")),
    ),
    Drive("F", MOTOR, held=True),
    (Position("q", MOTOR), Position("ql", LOAD)),
)
TRUE = {"Mm": 12.0, "Ml": 30.0, "K": 2e4, "D": 80.0, "Fv": 20.0, "Fs": 5.0}
LOOP = Cascade("q", position_gain=10.0, velocity_gain=900.0, integral_gain=4.0)


def still(at: float = 0.0, samples: int = 400) -> Trajectory:
    return steps([at], samples * PERIOD, sampling_period=PERIOD)


def test_the_load_hangs_by_its_weight_and_nothing_moves() -> None:
    log = simulate(HOIST, TRUE, still(), LOOP, start="equilibrium").log
    assert np.allclose(log["F"], 42.0 * G, rtol=1e-9)
    assert np.allclose(log["ql"], -30.0 * G / 2e4, rtol=1e-9)
    falls = simulate(HOIST, TRUE, still(), LOOP).log
    assert np.ptp(falls["q"]) > 1e-3


def test_an_open_loop_begins_with_the_stretched_rope() -> None:
    force = OpenLoop(np.full(400, 42.0 * G))
    log = simulate(HOIST, TRUE, still(), force, start="equilibrium").log
    assert np.ptp(log["ql"]) < 1e-12
    assert np.ptp(simulate(HOIST, TRUE, still(), force).log["ql"]) > 1e-3


def test_a_lagging_drive_holds_too() -> None:
    late = HOIST.with_effect(ActuatorLag(5e-3))
    log = simulate(late, TRUE, still(), LOOP, start="equilibrium").log
    assert np.ptp(log["q"]) < 1e-12


def test_nonlinear_laws_are_in_the_balance() -> None:
    """A stiffening rope: K d + k3 d^3 is the weight of the load; the root by another method."""
    stiff = HOIST.with_effect(StiffnessNonlinearity(SPRING, "k3"))
    state, force = equilibrium(plant_of(stiff, TRUE | {"k3": 1e9}), {"q": 0.1})
    deflection = scipy.optimize.brentq(lambda d: 2e4 * d + 1e9 * d**3 + 30.0 * G, -0.1, 0.0)
    assert state == pytest.approx([0.1, 0.1 + deflection, 0.0, 0.0], rel=1e-9)
    assert force == pytest.approx([42.0 * G])


def test_a_pendulum_is_held_at_its_angle() -> None:
    arm = Body("arm", inertia="J")
    axis = Axis("arm", (arm, PendulumWeight(arm, "ml")), Drive("T", arm), (Position("q", arm),))
    _, torque = equilibrium(plant_of(axis, {"J": 1.0, "ml": 0.7}), {"q": 0.4})
    assert torque == pytest.approx([0.7 * G * np.sin(0.4)])


def test_a_screw_holds_the_weight_of_its_table() -> None:
    screw = Body("screw", inertia="J")
    table = Body("table", mass="M", geared=Geared(to=screw, ratio=1.6e-3))
    axis = Axis("screw", (screw, table, Weight(table)), Drive("T", screw), (Position("q", screw),))
    _, torque = equilibrium(plant_of(axis, {"J": 1e-3, "M": 80.0}), {"q": 0.0})
    assert torque == pytest.approx([1.6e-3 * 80.0 * G])


def test_what_nothing_holds_is_named() -> None:
    hook = Body("hook", mass="Mh")
    loose = HOIST.with_effect(
        hook, Weight(hook), Damper("oil", Between(first=MOTOR, second=hook), damping="Do")
    )
    with pytest.raises(SettingError, match="neither springs nor drives hold hook"):
        simulate(loose, TRUE | {"Mh": 2.0, "Do": 9.0}, still(), LOOP, start="equilibrium")

    class Own(Controller):
        def force(self, command, measured, state, period):
            return 0.0, state

    with pytest.raises(SettingError, match="Own does not say how it holds"):
        simulate(HOIST, TRUE, still(), Own(), start="equilibrium")


def test_the_command_begins_in_equilibrium(folder: Path) -> None:
    write_axis(HOIST, "hoist.py")
    Path("P.json").write_text(json.dumps(TRUE))
    line = "simulate hoist.py --parameters P.json --rate 1000 --seconds 1 --trajectory chirp --travel 0.05"
    assert run(*line.split(), "--start", "equilibrium", "-o", "run.csv") == 0
    held = pl.read_csv("run.csv")
    assert held["F"][0] == pytest.approx(42.0 * G, rel=1e-6)
