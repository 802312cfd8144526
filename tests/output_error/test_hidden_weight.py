"""Weight of unknown phase on an arm behind an elastic gear, of which only the motor's encoder is read."""

import pytest

from symid import Axis, Between, Body, Drive, Log, Position, Preparation, Spring, Unbalance, ViscousFriction
from symid.output_error.error_model import ErrorModel
from symid.output_error.hidden_laws import models_of
from symid.output_error.rough_starts import rigid_start
from symid.simulation import Cascade, forward_dynamics, simulate, trapezoids

MOTOR, ARM = Body("motor", inertia="Jm"), Body("arm", inertia="Ja")
GEAR = Spring("gear", Between(first=MOTOR, second=ARM, ratio=1 / 52.7), stiffness="K", damping="D")
LAWS = (ViscousFriction(MOTOR, "Fv"), Unbalance(ARM, "Gs", "Gc"))
AXIS = Axis(
    "hidden_weight",
    (MOTOR, ARM, *LAWS, GEAR),
    Drive("T", MOTOR, held=True, noise=2e-3),
    (Position("qm", MOTOR, noise=3e-5),),
)
TRUE = {"Jm": 3.1e-4, "Ja": 2.7, "Fv": 4e-3, "Gs": 61.0, "Gc": -23.0, "K": 1.2e4, "D": 21.0}


@pytest.fixture(scope="module")
def log() -> Log:
    path = trapezoids([60.0], 80.0, acceleration=900.0, jerk=4e4, dwell=0.05, sampling_period=4e-3)
    loop = Cascade("qm", position_gain=15.0, velocity_gain=0.05, integral_gain=8.0)
    return simulate(AXIS, TRUE, path, loop, start="equilibrium", seed=1).log


def test_a_rough_start_knows_what_a_gear_makes_of_a_mass(log: Log) -> None:
    """The inertia of the arm is 9000 times that of the motor, and the load on the drive that of both."""
    rough = rigid_start(models_of(AXIS, ("qm",)).whole, forward_dynamics(AXIS), [log])
    for name in ("Jm", "Ja"):
        assert 0.1 < rough[name] / TRUE[name] < 10.0, name


def test_a_rough_start_is_made_beside_a_node_without_mass(log: Log) -> None:
    node = Body("node", inertia=0.0)
    springs = (
        Spring("shaft", Between(first=MOTOR, second=node), stiffness="Ks"),
        Spring("gear", Between(first=node, second=ARM, ratio=1 / 52.7), stiffness="K"),
    )
    axis = Axis(
        "noded", (MOTOR, node, ARM, ViscousFriction(MOTOR, "Fv"), *springs), AXIS.drives, AXIS.sensors
    )
    rough = rigid_start(models_of(axis, ("qm",)).whole, forward_dynamics(axis), [log])
    assert 1e3 < rough["Ja"] / rough["Jm"] < 1e4
    assert rough["K"] > 0.0 < rough["Ks"]


def test_a_hidden_arm_moves_with_the_motor_from_the_first_trial_on(log: Log) -> None:
    near = {name: value * (1.15 if i % 2 else 0.85) for i, (name, value) in enumerate(TRUE.items())}
    compared = ErrorModel(models_of(AXIS, ("qm",)).whole, forward_dynamics(AXIS), Preparation(), "held")
    fit = compared.fit([log], [near])
    assert fit is not None
    assert fit.search.has_converged
    found = fit.search.parameters
    for name in ("Jm", "Ja", "Gs", "Gc", "K"):
        assert found[name] == pytest.approx(TRUE[name], rel=0.01), name
