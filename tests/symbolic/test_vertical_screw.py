"""The weight of a table on a ball screw: geared to the motor, against the balance written by hand."""

from math import pi

import mujoco
import numpy as np
import pytest
from driven import acceleration

from symid import (
    Acceleration,
    Axis,
    Body,
    CoulombFriction,
    Drive,
    Geared,
    Position,
    ViscousFriction,
    Weight,
    axis_source,
    derive,
    identify,
)
from symid.codegen.generated_models import compiled
from symid.export import mjcf
from symid.simulation import Cascade, plant_of, simulate, trapezoids

LEAD, G = 0.01 / (2 * pi), 9.80665
SCREW = Body("screw", inertia="J")
TABLE = Body("table", mass="M", geared=Geared(to=SCREW, ratio=LEAD))
AXIS = Axis(
    "vertical_screw",
    (SCREW, TABLE, ViscousFriction(SCREW, "Fv"), CoulombFriction(SCREW, "Fs"), Weight(TABLE)),
    Drive("tau", SCREW, held=True, noise=2e-3),
    (Position("q", SCREW, noise=1e-6), Acceleration("dds", TABLE)),
)
TRUE = {"J": 1e-3, "M": 60.0, "Fv": 0.01, "Fs": 0.2}


def torque(a: np.ndarray, v: np.ndarray) -> np.ndarray:
    """(J + M r^2) a + Fv v + Fs sign(v) + M g r."""
    inertia = TRUE["J"] + TRUE["M"] * LEAD**2
    return np.asarray(inertia * a + TRUE["Fv"] * v + TRUE["Fs"] * np.sign(v) + TRUE["M"] * G * LEAD)


def test_the_model_is_the_balance_by_hand() -> None:
    draw = np.random.default_rng(1)
    v, a = draw.normal(size=(2, 30)) * 20
    model = compiled(derive(AXIS, ("q",)))
    W, y = model.sample({"tau": torque(a, v), "q": v, "q_d1": v, "q_d2": a})
    found = W[0] @ model.minimal_parameters(*TRUE.values())
    np.testing.assert_allclose(found, torque(a, v), rtol=1e-12)
    np.testing.assert_allclose(y[0], torque(a, v))


def test_the_simulation_and_mujoco_follow_it() -> None:
    plant = plant_of(AXIS, TRUE)
    model = mujoco.MjModel.from_xml_string(mjcf(AXIS, TRUE).text)
    data = mujoco.MjData(model)
    for v, tau in ((3.0, 2.0), (-40.0, 0.1), (25.0, -1.5)):
        a = (tau - torque(np.zeros(1), np.array([v]))[0]) / (TRUE["J"] + TRUE["M"] * LEAD**2)
        assert acceleration(plant, np.array([0.0, v]), tau) == pytest.approx([a], rel=1e-12)
        data.qvel[:], data.ctrl[0] = v, tau
        mujoco.mj_forward(model, data)
        assert data.qacc[0] == pytest.approx(a, rel=1e-6)


def test_the_weight_distinguishes_the_table_from_the_screw() -> None:
    """Without it only J + M r^2 is seen."""
    path = trapezoids([60.0, 10.0] * 3, 60.0, acceleration=600.0, jerk=2e4, dwell=0.1, sampling_period=1e-3)
    loop = Cascade("q", position_gain=20.0, velocity_gain=0.15, integral_gain=10.0)
    found = identify(AXIS, simulate(AXIS, TRUE, path, loop, seed=3).log, measured=["q"])
    for (name, value), std in zip(found.physical_parameters.items(), found.physical_deviations, strict=True):
        assert abs(value - TRUE[name]) < 4 * std + 0.01 * abs(TRUE[name]), name
    space: dict[str, object] = {}
    exec(axis_source(AXIS), space)
    assert space["axis"] == AXIS
