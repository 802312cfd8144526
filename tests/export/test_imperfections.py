"""What acts beyond the equations of motion, exported: compiled or loaded, and moved as the simulation moves it."""

from dataclasses import replace
from pathlib import Path

import fmpy
import mujoco
import numpy as np
import pytest
from axes.shipped import VALUES
from export.compiler import Compiled, with_run

from symid import (
    ActuatorDelay,
    ActuatorLag,
    Axis,
    Drive,
    EncoderRipple,
    ForceConstantRipple,
    ForceLimit,
    FrictionDrift,
    FrictionTrend,
    GainAsymmetry,
    GainNonlinearity,
    LoadDependentFriction,
    PayloadChange,
    PeriodicForce,
    PreslidingFriction,
    load_axis,
)
from symid.axis import Imperfection, drive_imperfections, imperfections
from symid.export import c_source, mjcf, write_fmu
from symid.export.dynamics import symbolic_dynamics
from symid.simulation import OpenLoop, Trajectory, simulate
from symid.symbolic import derive

AXIS, RIGID = load_axis("rigid_1m"), {"M": 5.0, "Fv": 40.0, "Fs": 6.0}
MOTOR = AXIS.bodies[0]
SCREW, LOAD = load_axis("ballscrew_2m1s"), load_axis("ballscrew_2m1s").free_bodies[1]
PERIOD, STEP = 1e-3, 2e-5
TIME = PERIOD * np.arange(700)
FORCE = 40.0 * np.sin(2 * np.pi * 3.0 * TIME) + 12.0 * np.sin(2 * np.pi * 7.0 * TIME)

ELEMENTS: dict[str, tuple[Imperfection, ...]] = {
    "delay": (ActuatorDelay(0.0034),),
    "lag": (ActuatorLag(0.004),),
    "two_lags": (ActuatorLag(0.004), ActuatorLag(0.004)),
    "limit": (ForceLimit(25.0),),
    "bend": (GainNonlinearity(0.004, power=2),),
    "cubic_bend": (GainNonlinearity(1e-4, power=3),),
    "asymmetry": (GainAsymmetry(0.1),),
    "drive": (ActuatorDelay(0.002), ActuatorLag(0.003), ForceLimit(30.0), GainAsymmetry(0.1)),
    "ripple": (EncoderRipple("q", 2e-4, 1e-4, pitch=0.01),),
    "periodic": (PeriodicForce(MOTOR, 5.0, -3.0, frequency=11.0),),
    "drift": (FrictionDrift(MOTOR, 4.0, 15.0, time_constant=0.4),),
    "trend": (FrictionTrend(MOTOR, 5.0, 20.0),),
    "force_constant": (ForceConstantRipple(0.2, -0.1, pitch=0.01),),
    "load": (LoadDependentFriction(MOTOR, 0.2),),
    "payload": (PayloadChange(MOTOR, 3.0, time=0.3),),
    "presliding": (PreslidingFriction(MOTOR, 4.0, reach=1e-3),),
    "presliding_of_all": (PreslidingFriction(MOTOR, 60.0, reach=2e-4),),
    "load_and_lag": (LoadDependentFriction(MOTOR, 0.2), ActuatorLag(0.004)),
    "two_payloads": (PayloadChange(MOTOR, 3.0, time=0.3), PayloadChange(MOTOR, -2.0, time=0.5)),
}
FIRST_ORDER = 2e-4
"""Error, relative to the travel, of steps of 20 us without any imperfection."""
IN_MUJOCO = ("delay", "lag", "limit")


def axis_with(name: str) -> Axis:
    """The rigid axis with imperfections."""
    return AXIS.with_effect(*ELEMENTS[name])


def simulated(
    axis: Axis, values: dict[str, float] = RIGID, force: np.ndarray = FORCE
) -> dict[str, np.ndarray]:
    """Readings under a given force by the simulation."""
    none = np.zeros(force.size)
    rest = Trajectory(none, none, none, PERIOD, "rest")
    return dict(simulate(axis, values, rest, OpenLoop(force), steps=4).log.signals)


def compiled(axis: Axis, folder: Path, values: dict[str, float] = RIGID) -> Compiled:
    """The axis in C, with any warning an error."""
    return Compiled.of(with_run(c_source(derive(axis), values), axis.name), axis.name, folder)


def by_c(axis: Axis, folder: Path, values: dict[str, float] = RIGID, force: np.ndarray = FORCE) -> np.ndarray:
    """Readings by the compiled functions at the samples, of shape (sensors, samples)."""
    code, sizes = compiled(axis, folder, values), (symbolic_dynamics(axis).n_states, len(axis.sensors))
    rest = np.zeros(sizes[0])
    first = code.function("sensors", rest, rest, shape=(sizes[1],))
    _, readings = code.run(values, force[:-1], PERIOD, STEP, sizes)
    return np.vstack([first, readings]).T


def by_unit(axis: Axis, folder: Path, given: np.ndarray = FORCE) -> np.ndarray:
    """First reading at the samples by FMPy."""
    file = folder / f"{axis.name}.fmu"
    losses = write_fmu(derive(axis), RIGID, file)
    assert not any("left out" in loss for loss in losses)
    inputs = np.rec.fromarrays([TIME, given], names="time,F")
    description = fmpy.read_model_description(str(file))
    unit = fmpy.fmi2.FMU2Slave(
        guid=description.guid,
        unzipDirectory=fmpy.extract(str(file)),
        modelIdentifier=axis.name,
        instanceName="axis",
    )
    places = {v.name: v.valueReference for v in description.modelVariables}
    unit.instantiate()
    unit.setupExperiment(startTime=0.0)
    unit.enterInitializationMode()
    unit.exitInitializationMode()
    found = []
    for t, force in zip(inputs["time"], inputs["F"], strict=True):
        found.append(unit.getReal([places["q"]])[0])
        unit.setReal([places["F"]], [float(force)])
        unit.doStep(currentCommunicationPoint=float(t), communicationStepSize=PERIOD)
    unit.terminate()
    unit.freeInstance()
    return np.array(found)


def test_every_imperfection_is_tried() -> None:
    modules = imperfections, drive_imperfections
    declared = {getattr(module, name) for module in modules for name in module.__all__}
    concrete = {kind for kind in declared if not kind.__subclasses__()}
    assert concrete == {type(element) for elements in ELEMENTS.values() for element in elements}


@pytest.mark.parametrize("name", ["lag", "two_lags", "drive"])
def test_lags_begin_where_the_first_force_holds_them(name: str, tmp_path: Path) -> None:
    """They began at zero: a hoist fell for as long as its drive lags before the force that holds it was there."""
    steady = FORCE + 20.0
    wanted = simulated(axis_with(name), force=steady)["q"]
    found = by_unit(axis_with(name), tmp_path, steady)
    assert np.abs(found - wanted).max() < 2 * FIRST_ORDER * np.ptp(wanted)


def test_load_is_a_force_where_the_signal_is_a_current(tmp_path: Path) -> None:
    driven = replace(axis_with("load"), drive=replace(AXIS.only_drive, gain="Kf", unit="A"))
    (found,) = by_c(driven, tmp_path, RIGID | {"Kf": 20.0}, FORCE / 20.0)
    wanted = simulated(axis_with("load"))["q"]
    assert np.abs(found - wanted).max() < FIRST_ORDER * np.ptp(wanted)


@pytest.mark.parametrize("name", ELEMENTS)
def test_c_moves_as_the_simulation_does(name: str, tmp_path: Path) -> None:
    axis = axis_with(name)
    wanted, plain = simulated(axis)["q"], simulated(AXIS)["q"]
    (found,) = by_c(axis, tmp_path)
    assert np.abs(found - wanted).max() < max(
        0.02 * np.abs(wanted - plain).max(), FIRST_ORDER * np.ptp(wanted)
    )
    assert np.abs(found - wanted).max() < 1e-3 * np.ptp(wanted)
    assert not any("left out" in loss for loss in c_source(derive(axis), RIGID).losses)


@pytest.mark.parametrize("name", ["delay", "drive", "ripple", "drift", "payload", "presliding"])
def test_a_unit_moves_as_the_simulation_does(name: str, tmp_path: Path) -> None:
    axis = axis_with(name)
    wanted, plain = simulated(axis)["q"], simulated(AXIS)["q"]
    error = np.abs(by_unit(axis, tmp_path) - wanted).max()
    assert error < max(0.02 * np.abs(wanted - plain).max(), FIRST_ORDER * np.ptp(wanted))


def test_the_derivative_is_that_of_the_equations_by_hand(tmp_path: Path) -> None:
    axis = AXIS.with_effect(
        GainAsymmetry(0.1),
        ActuatorLag(0.05),
        PreslidingFriction(MOTOR, 4.0, reach=1e-3),
        FrictionTrend(MOTOR, 5.0, 20.0),
        PayloadChange(MOTOR, 3.0, time=0.3),
    )
    code = compiled(axis, tmp_path)
    for t, mass in ((0.2, 5.0), (0.4, 8.0)):
        v, f, z = 0.3, 17.0, 0.5
        state = np.array([0.1, v, f, z, t])
        found = code.function("derivative", code.parameters(RIGID), state, -50.0, shape=(5,))
        friction = 40.0 * v + 6.0 + 4.0 * (z - 1.0) + t * (5.0 + 20.0 * v)
        sent = -50.0 - 0.1 * 50.0
        by_hand = [v, (f - friction) / mass, (sent - f) / 0.05, (v - v * z) / 1e-3, 1.0]
        np.testing.assert_allclose(found, by_hand, rtol=1e-12)


def test_readings_are_late_in_steps_and_rippled(tmp_path: Path) -> None:
    axis = SCREW.with_signal("ql", 0.0, resolution=2e-6, delay=0.0023).with_effect(
        EncoderRipple("qm", 3e-5, -2e-5, pitch=0.004),
        FrictionDrift(LOAD, 20.0, 0.0, time_constant=0.2),
        ActuatorDelay(0.0012),
    )
    values = {"Mm": 80.0, "Fvm": 120.0, "Fsm": 50.0, "Kt": 6e6, "Ft": 7000.0, "Ml": 200.0, "Fvl": 150.0}
    force = 20 * FORCE
    wanted, found = simulated(axis, values, force), by_c(axis, tmp_path, values, force)
    for i, signal in enumerate(("qm", "ql")):
        step = 2e-6 if signal == "ql" else 0.0
        assert np.abs(found[i] - wanted[signal]).max() < 1e-3 * np.ptp(wanted[signal]) + step
    in_steps = found[1] / 2e-6
    np.testing.assert_allclose(in_steps, np.round(in_steps), atol=1e-6)


@pytest.mark.parametrize("name", ELEMENTS)
def test_mujoco_has_delay_limit_and_lag_and_says_what_it_lacks(name: str) -> None:
    axis = axis_with(name)
    exported = mjcf(axis, RIGID)
    model = mujoco.MjModel.from_xml_string(exported.text)
    lost = {loss.split(":")[0] for loss in exported.losses if "MuJoCo has" in loss}
    kept = (ActuatorDelay, ForceLimit) if name == "two_lags" else (ActuatorDelay, ForceLimit, ActuatorLag)
    assert lost == {type(e).__name__ for e in ELEMENTS[name] if not isinstance(e, kept)}
    if name not in IN_MUJOCO:
        return
    steps, data, found = round(PERIOD / model.opt.timestep), mujoco.MjData(model), []
    for force in FORCE:
        found.append(float(data.sensor("q").data[0]))
        data.ctrl[0] = force
        mujoco.mj_step(model, data, steps)
        mujoco.mj_forward(model, data)
    wanted, plain = simulated(axis)["q"], simulated(AXIS)["q"]
    assert np.abs(np.array(found) - wanted).max() < 0.1 * np.abs(wanted - plain).max()


def test_a_limit_of_the_force_is_one_of_the_command_in_mujoco() -> None:
    axis = load_axis("emps").with_effect(ForceLimit(35.15065188248547), ActuatorLag(2e-3))
    model = mujoco.MjModel.from_xml_string(mjcf(axis, VALUES["emps"]).text)
    np.testing.assert_allclose(model.actuator_ctrlrange[0], [-1.0, 1.0])
    assert model.actuator_dynprm[0, 0] == 2e-3


def test_a_ripple_of_an_unknown_force_constant_scales_with_it(tmp_path: Path) -> None:
    driven = replace(AXIS, drive=Drive("i", MOTOR, gain="Kt", unit="A"))
    axis, current = driven.with_effect(ForceConstantRipple(0.2, -0.1, pitch=0.01)), FORCE / 12.5
    (found,) = by_c(axis, tmp_path, RIGID | {"Kt": 12.5}, current)
    wanted = simulated(axis_with("force_constant"))["q"]
    assert simulated(axis, RIGID | {"Kt": 12.5}, current)["q"] == pytest.approx(wanted)
    assert np.abs(found - wanted).max() < 1e-3 * np.ptp(wanted)
