"""Friction in joints that depend on each other, beside the same friction declared in as few joints as there are."""

import numpy as np
import pytest

from symid import Axis, Body, CoulombFriction, Drive, Geared, Position, StribeckFriction, ViscousFriction
from symid.axis import Element
from symid.simulation import Trajectory, plant_of, simulate, trapezoids, tuned_cascade, tuned_cascades

RATIO = 0.02
PINION = Body("pinion", inertia=2.4e-3)
LEFT = Body("left", mass=8.0, geared=Geared(to=PINION, ratio=RATIO))
RIGHT = Body("right", mass=8.0, geared=Geared(to=PINION, ratio=-RATIO))
PATH = trapezoids([8.0, 3.0], [4.0, 20.0], acceleration=150.0, jerk=6e3, dwell=0.1, sampling_period=1e-3)


def rack(*laws: Element) -> Axis:
    elements = (PINION, LEFT, RIGHT, ViscousFriction(PINION, "Fv"), *laws)
    return Axis("twins", elements, Drive("T", PINION, held=True), (Position("q", PINION, noise=1e-5),))


def moved(axis: Axis, values: dict[str, float], path: Trajectory = PATH) -> dict[str, np.ndarray]:
    controller = tuned_cascade(plant_of(axis, values), "q", 8.0)
    return dict(simulate(axis, values, path, controller, seed=2).log.signals)


def test_two_racks_on_a_pinion_stick_and_slip_as_one() -> None:
    pair = rack(CoulombFriction(LEFT, "Fs"), CoulombFriction(RIGHT, "Fs2"))
    whole = rack(CoulombFriction(PINION, "Fp"))
    two = moved(pair, {"Fv": 0.05, "Fs": 30.0, "Fs2": 12.0})
    one = moved(whole, {"Fv": 0.05, "Fp": 42.0 * RATIO})
    assert np.ptp(two["q"]) > 5.0
    for name in ("q", "T"):
        assert np.allclose(two[name], one[name], rtol=0, atol=1e-9 * np.ptp(one[name]))


def test_a_law_behind_a_gear_has_the_speed_of_its_own_body() -> None:
    """dF sign(v) exp(-(v/w)^2) of a rack is that of its pinion with w over the ratio."""
    own = rack(
        CoulombFriction(PINION, "Fp"),
        CoulombFriction(LEFT, "Fs"),
        StribeckFriction(LEFT, "dF", velocity=0.02),
    )
    at_pinion = rack(CoulombFriction(PINION, "Fp"), StribeckFriction(PINION, "dFp", velocity=0.02 / RATIO))
    two = moved(own, {"Fv": 0.05, "Fp": 0.1, "Fs": 30.0, "dF": 8.0})
    one = moved(at_pinion, {"Fv": 0.05, "Fp": 0.1 + 30.0 * RATIO, "dFp": 8.0 * RATIO})
    assert np.allclose(two["T"], one["T"], rtol=0, atol=1e-6 * np.ptp(one["T"]))


def test_friction_of_two_carriages_and_of_the_turn_of_their_beam() -> None:
    """At rest three joints hold two bodies; both drives move alike, so that the beam does not turn."""
    left, right = Body("left", mass=30.0), Body("right", mass=30.0)
    gears = (Geared(to=left, ratio=-0.8), Geared(to=right, ratio=0.8))
    yaw = Body("yaw", inertia=12.0, geared=gears)
    elements = (left, right, yaw, CoulombFriction(left, "Fs"), CoulombFriction(right, "Fs"))
    drives = Drive("F1", left, held=True), Drive("F2", right, held=True)
    sensors = Position("q1", left), Position("q2", right)
    path = trapezoids([0.2], 0.5, acceleration=4.0, jerk=100.0, dwell=0.1, sampling_period=1e-3)
    values, logs = {"Fs": 20.0, "Fy": 5.0}, []
    for turning in ((CoulombFriction(yaw, "Fy"),), ()):
        axis = Axis("gantry", (*elements, *turning), drives, sensors)
        own = {name: values[name] for name in axis.physical_parameters}
        controllers = tuned_cascades(plant_of(axis, own), axis.controlled_signals, 8.0)
        logs.append(simulate(axis, own, path, controllers).log)
    assert np.ptp(logs[0]["q1"]) == pytest.approx(0.2, rel=0.05)
    for name in ("q1", "q2", "F1"):
        assert np.allclose(logs[0][name], logs[1][name], rtol=0, atol=1e-6 * np.ptp(logs[1][name]))
