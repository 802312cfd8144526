"""Springs in series with a massless node, beside series stiffness by hand and an own integration."""

from dataclasses import replace

import numpy as np
import pytest
import scipy

from symid import (
    Axis,
    Between,
    Body,
    CoulombFriction,
    Damper,
    Drive,
    PeriodicForce,
    Position,
    Spring,
    ViscousFriction,
    derive,
    diagnose,
    identify,
)
from symid.axis import Element
from symid.codegen.generated_models import compiled
from symid.errors import SettingError
from symid.report.figures.schematic import draw_schematic
from symid.simulation import Cascade, plant_of, simulate, trapezoids

MOTOR, NODE, LOAD = Body("motor", mass="Mm"), Body("node", mass=0.0), Body("load", mass="Ml")
SCREW = Spring("screw", Between(first=MOTOR, second=NODE), stiffness="K1")
NUT = Spring("nut", Between(first=NODE, second=LOAD), stiffness="K2")
TRUE = {"Mm": 10.0, "Fv": 50.0, "K1": 1e5, "K2": 2e5, "Ml": 20.0}
SERIES = 1e5 * 2e5 / 3e5
PATH = trapezoids([0.2, 0.1], 0.4, acceleration=4.0, jerk=100.0, dwell=0.1, sampling_period=1e-3)
LOOP = Cascade("qm", position_gain=20.0, velocity_gain=800.0, integral_gain=5.0)


def axis_with(*elements: Element) -> Axis:
    sensors = (Position("qm", MOTOR), Position("qn", NODE), Position("ql", LOAD))
    own = (MOTOR, NODE, LOAD, ViscousFriction(MOTOR, "Fv"), SCREW, NUT, *elements)
    return Axis("series", own, Drive("F", MOTOR, held=True), sensors)


def damped(mass: float) -> Axis:
    """A node of a mass between springs, in oil."""
    node = Body("node", mass=mass)
    springs = (
        Spring("screw", Between(first=MOTOR, second=node), stiffness="K1"),
        Spring("nut", Between(first=node, second=LOAD), stiffness="K2"),
    )
    own = (MOTOR, node, LOAD, ViscousFriction(MOTOR, "Fv"), *springs, Damper("oil", node, damping="D"))
    return Axis("damped", own, Drive("F", MOTOR, held=True), (Position("qm", MOTOR), Position("ql", LOAD)))


def test_the_plant_has_the_series_stiffness() -> None:
    plant = plant_of(axis_with(), TRUE)
    assert plant.bodies == ("motor", "load")
    assert np.allclose(plant.mass, np.diag([10.0, 20.0]))
    assert np.allclose(plant.stiffness, SERIES * np.array([[1, -1], [-1, 1]]))
    assert np.allclose(plant.sensors["qn"].row, [1 / 3, 2 / 3])  # K1 x_m + K2 x_l over K1 + K2


def test_the_simulated_motion_is_that_of_an_own_integration() -> None:
    log = simulate(axis_with(), TRUE, PATH, LOOP).log
    # state xm, xl, vm, vl and the force that is held for a sample
    A = np.zeros((5, 5))
    A[:2, 2:4] = np.eye(2)
    A[2, [0, 1, 2, 4]] = -SERIES / 10, SERIES / 10, -50.0 / 10, 1 / 10
    A[3, [0, 1]] = SERIES / 20, -SERIES / 20
    step = scipy.linalg.expm(A * log.sampling_period)
    state, found = np.zeros(5), []
    for force in log["F"]:
        found.append(state[:2])
        state = step @ np.append(state[:4], force)
    motor, load = np.array(found).T
    assert np.ptp(load) > 0.1
    assert np.allclose(log["ql"], load, atol=1e-9)
    assert np.allclose(log["qn"], (motor + 2 * load) / 3, atol=1e-9)


def test_an_imperfection_beside_a_node_is_that_of_the_axis_with_one_spring() -> None:
    one = Spring("screw", Between(first=MOTOR, second=LOAD), stiffness=SERIES)
    ripple = PeriodicForce(MOTOR, 20.0, 0.0, 5.0)
    elements = MOTOR, LOAD, ViscousFriction(MOTOR, "Fv"), one, ripple
    single = replace(axis_with(), elements=elements, sensors=(Position("qm", MOTOR), Position("ql", LOAD)))
    two = simulate(axis_with(ripple), TRUE, PATH, LOOP).log
    wanted = simulate(single, TRUE, PATH, LOOP).log
    assert np.allclose(two["F"], wanted["F"], atol=1e-6)
    assert np.allclose(two["ql"], wanted["ql"], atol=1e-10)
    assert np.ptp(two["F"] - simulate(axis_with(), TRUE, PATH, LOOP).log["F"]) > 5.0


def test_the_equations_hold_for_the_response_by_hand() -> None:
    model = compiled(derive(axis_with(), ("qm",)))
    X = model.minimal_parameters(*(TRUE[name] for name in model.physical_units))
    s = 25j
    Z = np.array([[10 * s**2 + 50 * s + SERIES, -SERIES], [-SERIES, 20 * s**2 + SERIES]])
    x = np.linalg.solve(Z, [1.0, 0.0])
    t = np.linspace(0, 0.2, 5)
    flat = {}
    for name in model.signals:
        base, _, order = name.partition("_d")
        flat[name] = (s ** int(order or 0) * {"F": 1.0, "qm": x[0]}[base] * np.exp(s * t)).real
    W, y = model.sample(flat)
    assert np.allclose(W[0] @ X, y[0], rtol=0, atol=1e-9 * np.abs(W[0] * X).sum(axis=1).max())


def test_a_sensor_at_the_node_distinguishes_the_springs() -> None:
    axis = axis_with()
    log = simulate(axis, TRUE, PATH, LOOP).log
    found = identify(axis, log, examine=False)
    assert found.physical_parameters == pytest.approx(TRUE, rel=0.02)
    alone = identify(axis, log, measured=("qm", "ql"))
    assert alone.status == "no_physical_parameters"
    assert alone.minimal_parameters["X1"] == pytest.approx(SERIES, rel=0.01)
    assert identify(axis, log, measured=("qm", "ql"), fixed={"K2": 2e5}).physical_parameters[
        "K1"
    ] == pytest.approx(1e5, rel=0.02)


def test_a_diagnosis_sees_springs_in_series_as_one() -> None:
    path = trapezoids([0.2, 0.1, 0.3], 0.4, acceleration=4.0, jerk=100.0, dwell=0.1, sampling_period=1e-3)
    noisy = axis_with().with_signal("F", noise=0.3).with_signal("qm", noise=1e-7)
    grown = noisy.with_effect(CoulombFriction(MOTOR, "Fs"))
    log = simulate(grown, TRUE | {"Fs": 12.0}, path, LOOP).log
    log = replace(log, signals={name: log[name] for name in ("F", "qm")})
    screw = Spring("screw", Between(first=MOTOR, second=LOAD), stiffness="K")
    elements = MOTOR, LOAD, ViscousFriction(MOTOR, "Fv"), screw
    one = replace(axis_with(), elements=elements, sensors=(Position("qm", MOTOR),))
    off = {name: 1.1 * value for name, value in TRUE.items()}
    rigid = {"Mm": off["Mm"], "Ml": off["Ml"], "Fv": off["Fv"], "K": 1.1 * SERIES}
    two, single = diagnose(axis_with(), log, nominal=off), diagnose(one, log, nominal=rigid)
    for found in (two, single):
        assert [(e.effect, e.at) for e in found.effects] == [("coulomb_friction", "motor")]
        assert found.effects[0].parameters["Fs"].value == pytest.approx(12.0, rel=0.02)
        assert found.gap.explained.rms < 0.1 * found.gap.reidentified.rms
    k = {change.name: change.explained for change in two.parameters}
    (stiffness,) = (change.explained for change in single.parameters if change.name == "K")
    assert k["K1"] * k["K2"] / (k["K1"] + k["K2"]) == pytest.approx(stiffness, rel=0.03)


@pytest.mark.parametrize("damping", [2.0, 150.0, 2e4])
def test_a_damped_node_moves_as_by_an_own_integration(damping: float) -> None:
    """Springs with dampers: the node relaxes in 7 us, 0.5 ms and 67 ms."""
    values = TRUE | {"D": damping}
    log = simulate(damped(0.0), values, PATH, LOOP).log
    # Without mass the node has no velocity as a state: D x_n(1) = K1 (x_m - x_n) + K2 (x_l - x_n).
    A = np.zeros((6, 6))
    A[[0, 1], [3, 4]] = 1.0
    A[2, :3] = np.array([1e5, 2e5, -3e5]) / damping
    A[3, [0, 2, 3, 5]] = -1e4, 1e4, -5.0, 0.1
    A[4, [1, 2]] = -1e4, 1e4
    step, state, found = scipy.linalg.expm(A * log.sampling_period), np.zeros(5), []
    for force in log["F"]:
        found.append(state[1])
        state = (step @ np.append(state, force))[:5]
    assert np.ptp(found) > 0.05
    assert np.allclose(log["ql"], found, atol=5e-7)
    series = np.sqrt(SERIES / 10 + SERIES / 20) / (2 * np.pi)
    assert plant_of(damped(0.0), values).natural_frequencies == pytest.approx([series])


def test_what_a_node_cannot_carry_is_refused() -> None:
    with pytest.raises(SettingError, match="bodies node without mass carry more than springs"):
        plant_of(axis_with(CoulombFriction(NODE, "Fs")), TRUE | {"Fs": 3.0})
    with pytest.raises(SettingError, match="acts on body 'node', which has no mass"):
        simulate(axis_with(PeriodicForce(NODE, 1.0, 0.0, 5.0)), TRUE, PATH, LOOP)
    draw_schematic(axis_with())
