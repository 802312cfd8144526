"""Starts of a maximum-likelihood search: behind a ball screw, and where no log can determine the parameters."""

from math import pi

import pytest

import symid
from symid import Axis, Between, Body, Drive, Geared, Log, Position, Spring, ViscousFriction
from symid.simulation import chirp, plant_of, simulate, tuned_cascade

RATIO = 0.01 / (2 * pi)
SCREW = Body("screw", inertia="J")
DRIVE = Drive("T", SCREW, held=True)
FRICTION = ViscousFriction(SCREW, "Fv")
ANGLE = Position("q", SCREW, noise=1e-6)


def logged(axis: Axis, values: dict[str, float]) -> Log:
    reference = chirp(0.5, 40.0, 2.0, 20.0, sampling_period=5e-4, quantity="velocity")
    return simulate(axis, values, reference, tuned_cascade(plant_of(axis, values), "q"), seed=1).log


def test_a_mass_behind_a_ball_screw_begins_at_that_of_least_squares() -> None:
    table = Body("table", mass="M")
    nut = Spring("nut", Between(first=SCREW, second=table, ratio=RATIO), stiffness="K", damping="D")
    slip = Position("d", table, relative_to=SCREW, ratio=RATIO, noise=1e-8)
    axis = Axis("screwed", (SCREW, FRICTION, table, nut), DRIVE, (ANGLE, slip))
    values = {"J": 8e-4, "Fv": 0.02, "M": 60.0, "K": 1.2e6, "D": 400.0}
    found = symid.identify(axis, logged(axis, values), method="oe")
    assert found.status == "ok", found.message
    assert found.physical_parameters == pytest.approx(values, rel=0.01)


def test_parameters_that_no_motion_determines_are_named() -> None:
    table = Body("table", mass="M", geared=Geared(to=SCREW, ratio=RATIO))
    axis = Axis("rigid_screw", (SCREW, FRICTION, table), DRIVE, (ANGLE,))
    found = symid.identify(axis, logged(axis, {"J": 8e-4, "Fv": 0.02, "M": 60.0}), method="oe")
    assert found.status == "undetermined"
    assert "do not determine J, M, however the axis moves: give one with `fixed`" in found.message
