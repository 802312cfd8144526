"""The exported URDF, read by MuJoCo: joints, masses, damping and friction, and what is reported as lost."""

import mujoco
import numpy as np
import pytest
from axes.shipped import VALUES
from driven import acceleration

from symid import load_axis
from symid.errors import SettingError
from symid.export import TEXT_TARGETS, urdf
from symid.simulation import plant_of


def read(name: str) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(urdf(load_axis(name), VALUES[name]).text)


@pytest.mark.parametrize("write", [target.write for target in TEXT_TARGETS.values()])
def test_no_format_holds_a_mass_that_no_machine_has(write) -> None:
    with pytest.raises(SettingError, match=r"of axis 'rigid_1m' (must not be negative|are not positive)"):
        write(load_axis("rigid_1m"), {"M": -5.0, "Fv": 1.0, "Fs": 1.0})


def test_a_slide_is_read_with_its_properties() -> None:
    model, values = read("rigid_1m"), VALUES["rigid_1m"]
    assert model.njnt == 1
    assert model.jnt_type[0] == mujoco.mjtJoint.mjJNT_SLIDE
    assert model.body("motor").mass[0] == pytest.approx(values["M"])
    assert model.dof_damping[0] == pytest.approx(values["Fv"])
    assert model.dof_frictionloss[0] == pytest.approx(values["Fs"])


def test_bodies_are_carried_as_declared_and_springs_are_named_as_lost() -> None:
    values = VALUES["direct_2m1s"]
    exported, model = urdf(load_axis("direct_2m1s"), values), read("direct_2m1s")
    assert model.body("motor").parentid[0] == model.body("structure").id
    assert model.body("structure").mass[0] == pytest.approx(values["Ms"])
    assert any(loss.startswith(f"stiffness {values['Ks']:.6g} of structure") for loss in exported.losses)
    assert all(f"Lost: {loss}" in exported.text for loss in exported.losses)


def test_it_is_accelerated_as_the_simulated_axis() -> None:
    axis, values = load_axis("rigid_1m"), VALUES["rigid_1m"]
    model = read("rigid_1m")
    data = mujoco.MjData(model)
    data.qvel[:], data.qfrc_applied[:] = 0.3, 700.0
    model.dof_frictionloss[:] = 0.0  # soft in MuJoCo
    mujoco.mj_forward(model, data)
    plant = plant_of(axis, values | {"Fs": 0.0})
    assert data.qacc == pytest.approx(acceleration(plant, np.array([0.0, 0.3]), 700.0), rel=1e-6)
