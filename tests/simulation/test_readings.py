"""What force sensors and scaled sensors read in a simulation, against equations written by hand and integrated."""

from dataclasses import replace

import numpy as np
import pytest
from axes.force_sensors import DRIVE, LOAD, MOTOR, SHAFT, VALUES, celled, integrated

from symid import ActuatorDelay, Force, Position, StiffnessNonlinearity
from symid.errors import SettingError
from symid.simulation import chirp, plant_of, simulate, tuned_cascade

REFERENCE = chirp(1.0, 20.0, 0.2, 0.002, sampling_period=1e-3)


def test_a_load_cell_reads_the_spring_and_its_damping() -> None:
    axis = celled((Position("qm", MOTOR), Position("ql", LOAD), Force("cell", SHAFT)))
    exact = axis.with_signal("F", noise=0.0)
    log = simulate(exact, VALUES, REFERENCE, tuned_cascade(plant_of(exact, VALUES), "qm")).log
    states = integrated(log["F"], log.sampling_period)
    cell = VALUES["K"] * (states[:, 1] - states[:, 0]) + VALUES["D"] * (states[:, 3] - states[:, 2])
    np.testing.assert_allclose(log["qm"], states[:, 0], atol=1e-12)
    np.testing.assert_allclose(log["cell"], cell, atol=1e-7 * np.ptp(cell))


K3 = 8e10


@pytest.mark.parametrize("delay", [0.0, 2.5e-3])
def test_a_load_cell_in_a_spring_that_stiffens(delay: float) -> None:
    plain = celled((Position("qm", MOTOR), Position("ql", LOAD), Force("cell", SHAFT, gain=2.0, delay=delay)))
    exact = plain.with_signal("F", noise=0.0).with_effect(StiffnessNonlinearity(SHAFT.at, "k3"))
    values = VALUES | {"k3": K3}
    controller = tuned_cascade(plant_of(exact, values), "qm")
    log = simulate(exact, values, REFERENCE, controller, steps=16).log
    states = integrated(log["F"], log.sampling_period, lambda d: K3 * d**3)
    d, rate = states[:, 1] - states[:, 0], states[:, 3] - states[:, 2]
    cubed = K3 * d**3
    cell = (VALUES["K"] * d + VALUES["D"] * rate + cubed) / 2.0
    assert np.abs(cubed).max() > 0.1 * np.ptp(cell)
    time = np.arange(len(cell)) * log.sampling_period
    late = np.interp(time - delay, time, cell)
    np.testing.assert_allclose(log["cell"], late, atol=(1e-4 if delay == 0 else 5e-3) * np.ptp(cell))


def test_a_controller_cannot_read_a_bent_spring() -> None:
    axis = celled((Position("qm", MOTOR), Force("cell", SHAFT)))
    axis = axis.with_effect(StiffnessNonlinearity(SHAFT.at, "k3"))
    loop = tuned_cascade(plant_of(axis, VALUES | {"k3": K3}), "qm")
    with pytest.raises(SettingError, match="reads 'cell', the force of a nonlinear spring"):
        simulate(axis, VALUES | {"k3": K3}, REFERENCE, replace(loop, signal="cell"))


def test_gain_and_offset_turn_a_quantity_into_a_signal() -> None:
    plain = celled((Position("qm", MOTOR), Position("ql", LOAD), Force("cell", SHAFT)))
    scaled = celled(
        (
            Position("qm", MOTOR),
            Position("ql", LOAD, gain="cq", offset="oq"),
            Force("cell", SHAFT, gain=2000.0, offset="of", unit="V"),
        )
    )
    values = VALUES | {"cq": 1.25, "oq": 0.003, "of": 5.0}
    controller = tuned_cascade(plant_of(plain, VALUES), "qm")
    first, second = (simulate(axis, values, REFERENCE, controller).log for axis in (plain, scaled))
    np.testing.assert_allclose(1.25 * second["ql"] + 0.003, first["ql"], atol=1e-14)
    np.testing.assert_allclose(2000.0 * second["cell"] + 5.0, first["cell"], atol=1e-9)


def test_a_transducer_reads_the_force_that_acts_and_not_the_one_that_is_sent() -> None:
    axis = celled((Position("qm", MOTOR), Force("fd", DRIVE))).with_signal("F", noise=0.0)
    late = axis.with_effect(ActuatorDelay(3e-3))
    log = simulate(late, VALUES, REFERENCE, tuned_cascade(plant_of(late, VALUES), "qm")).log
    sides = log["F"][1:-3] + log["F"][:-4]
    np.testing.assert_allclose(log["fd"][4:], sides / 2, atol=1e-9)


def test_a_controller_follows_a_scaled_reading() -> None:
    scaled = celled((Position("qm", MOTOR, gain=0.5, offset=0.01),)).with_signal("F", noise=0.0)
    controller = tuned_cascade(plant_of(scaled, VALUES), "qm")
    run = simulate(scaled, VALUES, REFERENCE, controller)
    np.testing.assert_allclose(0.5 * run.log["qm"] + 0.01, run.states[:, 0], atol=1e-14)
    assert run.log["qm"][0] == pytest.approx(-0.02, rel=1e-12)
    assert abs(run.log["qm"][-1]) < 0.01  # it has gone to where the scale reads the reference
