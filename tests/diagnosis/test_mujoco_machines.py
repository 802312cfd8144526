"""The machines of `benchmarks.diagnosis.mujoco_machines` obey the laws that they declare."""

import mujoco
import numpy as np
import pytest

from benchmarks.diagnosis.mujoco_machines import STEP, Machine


def pushed(machine: Machine, force: float, seconds: float = 0.5) -> np.ndarray:
    """Positions after a constant force on the motor."""
    model = mujoco.MjModel.from_xml_string(machine.xml)
    data = mujoco.MjData(model)
    data.ctrl[0] = force
    mujoco.mj_step(model, data, round(seconds / STEP))
    return np.array(data.qpos)


@pytest.mark.parametrize(("turns", "mass"), [(False, 2.0), (True, 0.05)])
def test_dry_friction_holds_or_takes_its_level_off(turns: bool, mass: float) -> None:
    machine = Machine(mass=mass, viscous=0.0, coulomb=1.5 * mass, turns=turns)
    assert pushed(machine, 5.0 * mass)[0] == pytest.approx(3.5 / 2 * 0.5**2, rel=2e-3)
    assert abs(pushed(machine, 1.0 * mass)[0]) < 1e-3


def test_a_pendulum_hangs_where_its_weight_balances_the_torque() -> None:
    machine = Machine(mass=0.5, viscous=3.0, coulomb=0.0, turns=True, weight=0.4)
    assert np.sin(pushed(machine, 1.5, 20.0)[0]) == pytest.approx(1.5 / (0.4 * 9.81), rel=1e-3)


def test_a_spring_with_play_pulls_beyond_it() -> None:
    machine = Machine(mass=2.0, viscous=0.0, coulomb=0.0, load=1.0, stiffness=1e4, damping=200.0, play=1e-3)
    motor, load = pushed(machine, 30.0, 1.0)
    assert motor - load == pytest.approx(5e-4 + 30.0 / 3 / 1e4, rel=1e-2)
    assert (2 * motor + load) / 3 == pytest.approx(30.0 / 3 / 2, rel=1e-3)  # the centre of mass
