"""Friction of a hidden load in one direction is named there, not at the motor that shows the same constant force."""

import numpy as np
import pytest

from symid import CoulombFriction, Log, OffsetForce, load_axis
from symid.diagnosis import LIBRARY, diagnose
from symid.diagnosis.fitting.state import first_state
from symid.diagnosis.prediction.data import Recording, data_of
from symid.diagnosis.prediction.joined_logs import joined
from symid.diagnosis.selection.priors import is_of_new_friction
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade

SCREW = load_axis("ballscrew_2m1s").with_signal("qm", noise=3e-8).with_signal("Fm", noise=1.0)
VALUES = {"Mm": 124.0, "Fvm": 71.0, "Fsm": 36.0, "Kt": 6.9e6, "Ft": 620.0, "Ml": 135.0, "Fvl": 180.0}


def test_a_load_with_friction_in_one_direction() -> None:
    (load,) = (body for body in SCREW.bodies if body.name == "load")
    machine = SCREW.with_effect(CoulombFriction(load, "Fsl"), OffsetForce(load, "F0"))
    path = trapezoids([0.2, 0.1, 0.3], 0.6, acceleration=4.0, jerk=200.0, dwell=0.1, sampling_period=1e-3)
    loop = tuned_cascade(plant_of(SCREW, VALUES), "qm")
    log = simulate(machine, VALUES | {"Fsl": 20.0, "F0": 20.0}, path, loop, seed=1).log
    names = ("asymmetric_friction", "offset_force", "coulomb_friction", "stribeck_friction")
    found = diagnose(SCREW, log, nominal=VALUES, library=[own for own in LIBRARY if own.name in names])
    assert {(own.effect, own.at) for own in found.effects} == {
        ("asymmetric_friction", "load"),
        ("coulomb_friction", "load"),
    }
    level = next(own for own in found.effects if own.effect == "coulomb_friction").parameters["Fs"]
    assert level.value == pytest.approx(20.0, rel=0.05)

    # The same constant force at the motor is less probable because friction was found at the load, which declares none.
    state, _ = first_state(data_of(SCREW, (joined([log]), None), Recording({}, True)).record, VALUES)
    others = {("coulomb_friction", "load"), ("stribeck_friction", "motor")}
    assert is_of_new_friction(state.prediction, ("asymmetric_friction", "load"), others)
    assert not is_of_new_friction(state.prediction, ("asymmetric_friction", "motor"), others)
    assert not is_of_new_friction(state.prediction, ("offset_force", "load"), others)


def swaying(seed: int) -> Log:
    """A body that sways both ways, a little more one way, under a constant force and a drag."""
    t, hertz = 1e-3 * np.arange(8000), (1 + 0.1 * seed) * np.array([0.37, 0.61, 1.13])
    rates, speeds = 2 * np.pi * hertz, np.array([0.3, 0.25, 0.15])
    angles = np.outer(rates, t) + np.arange(3)[:, None]
    v, a = 0.1 + speeds @ np.sin(angles), (speeds * rates) @ np.cos(angles)
    q = 0.1 * t - (speeds / rates) @ np.cos(angles)
    force = 100.0 * a + 150.0 * v + 5.0 * np.sign(v) + 700.0 * v * np.abs(v) - 300.0
    noise = np.random.default_rng(seed).standard_normal((2, t.size))
    return Log.from_arrays({"q": q + 1e-7 * noise[0], "F": force + noise[1]}, sampling_period=1e-3)


def test_a_constant_force_beside_a_drag_that_makes_friction_negative() -> None:
    """It was refused as the friction is negative without the drag, though a constant force cancels none of it."""
    nominal = {"M": 100.0, "Fv": 150.0, "Fs": 5.0}
    found = diagnose("rigid_1m", swaying(1), validation=swaying(2), nominal=nominal)
    assert {own.effect for own in found.effects} == {"offset_force", "quadratic_drag"}
    assert found.parameters[2].explained == pytest.approx(5.0, abs=1.0)
