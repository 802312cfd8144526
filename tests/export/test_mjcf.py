"""The exported MuJoCo model against the simulation: equal accelerations, and equal motion under the same force."""

from collections.abc import Mapping

import mujoco
import numpy as np
import pytest
from axes.case import PINION
from axes.catalogue import cases
from axes.effects import EFFECTS, values_of, with_effect
from axes.plant import random_motion
from axes.shipped import VALUES
from driven import acceleration, driven

from symid import Axis, load_axis
from symid.axis import Body
from symid.export import c_source, mjcf
from symid.simulation import plant_of
from symid.symbolic import derive

EXPRESSED = ("drag", "stiffness", "hardening", "backlash")
LOST = [name for name in EFFECTS if name not in EXPRESSED]


def relative(axis: Axis, bodies: tuple[str, ...], absolute: np.ndarray) -> np.ndarray:
    """Displacements, or their derivatives, in the coordinates of MuJoCo's joints."""
    by_name = dict(zip(bodies, absolute, strict=True))
    return np.array(
        [by_name[b.name] - (by_name[b.on.name] if _is_carried(b) else 0.0) for b in axis.free_bodies]
    )


def _is_carried(body: Body) -> bool:
    return isinstance(body.on, Body) and body.on.geared is None and body.on.turns == body.turns


def accelerations(
    axis: Axis, values: Mapping[str, float], x: np.ndarray, v: np.ndarray, force: float
) -> np.ndarray:
    """Of MuJoCo's joints, in the order of the free bodies."""
    model = mujoco.MjModel.from_xml_string(mjcf(axis, values).text)
    data = mujoco.MjData(model)
    bodies = plant_of(axis, values).bodies
    places = [model.joint(b.name).qposadr[0] for b in axis.free_bodies]
    data.qpos[places], data.qvel[places] = relative(axis, bodies, x), relative(axis, bodies, v)
    data.ctrl[0] = force / (axis.drive.gain or 1.0)
    mujoco.mj_forward(model, data)
    return data.qacc[places].copy()


@pytest.mark.parametrize("name", [n for n in cases() if n not in ("emps_asymmetric", "ripple_and_drag")])
def test_accelerations_are_those_of_the_simulation(name: str) -> None:
    case = cases()[name]
    plant = plant_of(case.declared, case.values)
    motion = random_motion(case.plant(), 3, 5, seed=11)
    change = (
        np.array([[1.0, 0.0], [-PINION, 1.0]]) if name == "rack_and_pinion" else np.eye(case.plant().bodies)
    )
    x, v = change @ motion.x[0], change @ motion.x[1]
    for k in range(5):
        force = float(motion.force[0][k])
        wanted = acceleration(plant, np.concatenate([x[:, k], v[:, k]]), force)
        wanted = relative(case.declared, plant.bodies, wanted)
        found = accelerations(case.declared, case.values, x[:, k], v[:, k], force)
        scale = float(np.max(np.abs(motion.x[2])))
        np.testing.assert_allclose(found, wanted, rtol=1e-6, atol=1e-6 * scale)


@pytest.mark.parametrize("name", EXPRESSED)
def test_effects_that_mujoco_knows_are_in_both(name: str) -> None:
    axis, values = with_effect(name), values_of(name)
    plant, draw = plant_of(axis, values), np.random.default_rng(2)
    for _ in range(20):
        x = 0.05 * draw.normal() + 5e-5 * draw.normal(size=len(plant.bodies))
        v = 0.3 + 0.1 * draw.normal(size=x.size)
        wanted = relative(axis, plant.bodies, acceleration(plant, np.concatenate([x, v]), 100.0))
        np.testing.assert_allclose(accelerations(axis, values, x, v, 100.0), wanted, rtol=1e-6, atol=1e-6)
    assert not any(name in loss for loss in mjcf(axis, values).losses if "Coulomb" not in loss)


@pytest.mark.parametrize("name", LOST)
def test_effects_that_mujoco_lacks_are_named(name: str) -> None:
    axis = with_effect(name)
    law = type(axis.laws[-1]).__name__
    exported = mjcf(axis, values_of(name))
    (first, *_) = [loss for loss in exported.losses if law in loss]
    assert f"Lost: {first}" in exported.text


def followed(
    axis: Axis, values: Mapping[str, float], forces: np.ndarray, period: float
) -> tuple[np.ndarray, np.ndarray]:
    """First reading under given forces, each held for a period: by the simulation and by MuJoCo."""
    plant, signal = plant_of(axis, values), axis.sensors[0].signal
    states = driven(axis, values, forces, period)[1:]
    model = mujoco.MjModel.from_xml_string(mjcf(axis, values).text)
    substeps = int(np.ceil(period / model.opt.timestep))
    model.opt.timestep = period / substeps
    data, theirs = mujoco.MjData(model), []
    for force in forces:
        data.ctrl[0] = force / (axis.drive.gain or 1.0)
        mujoco.mj_step(model, data, substeps)
        mujoco.mj_forward(model, data)
        theirs.append(float(data.sensor(signal).data[0]))
    return states[:, : len(plant.bodies)] @ plant.sensors[signal].row, np.array(theirs)


@pytest.mark.parametrize("name", list(VALUES))
def test_motion_under_a_given_force_is_that_of_the_simulation(name: str) -> None:
    axis, values = load_axis(name), dict(VALUES[name])
    if "Fvp" in values:
        assert any("viscous" in loss for loss in mjcf(axis, values).losses)
        values["Fvp"] = values["Fvn"]
    period, t = 1e-3, np.arange(1500) * 1e-3
    weight = sum(v for k, v in values.items() if k[0] in "MJ")
    friction = sum(values.get(k, 0.0) for k in ("Fs", "Fsm", "Fc"))
    forces = (2.0 * weight + 2 * friction) * np.sin(2 * np.pi * 2.0 * t) + 0.3 * weight * np.sin(
        2 * np.pi * 11 * t
    )
    ours, theirs = followed(axis, values, forces, period)
    assert np.max(np.abs(ours - theirs)) < 2e-3 * np.ptp(ours)


def test_what_signals_lose_is_reported_in_every_format() -> None:
    axis = (
        load_axis("motor_bench")
        .with_signal("iq", noise=0.1)
        .with_signal("qm", noise=1e-6, resolution=5e-6, delay=1e-3)
    )
    values = VALUES["motor_bench"]
    for exported in (mjcf(axis, values), c_source(derive(axis), values)):
        for signal in ("Pt", "iq", "qm"):
            assert any(loss.startswith(f"{signal}:") for loss in exported.losses), signal
    model = mujoco.MjModel.from_xml_string(mjcf(axis, values).text)
    assert model.sensor_delay[model.sensor("qm").id] == 1e-3
