"""Coulomb friction at a load that no sensor sees: found by simulating the closed loop, beside the truth."""

import numpy as np
import pytest

from symid import Axis, Between, Body, CoulombFriction, Drive, Position, Spring, ViscousFriction, derive
from symid.errors import EliminationError
from symid.output_error import identify_output_error
from symid.output_error.hidden_laws import models_of
from symid.simulation import Cascade, ClosedLoop, plant_of, simulate, trapezoids, tuned_cascade

MOTOR, LOAD = Body("motor", mass="Mm"), Body("load", mass="Ml")
SHAFT = Spring("shaft", Between(first=MOTOR, second=LOAD), stiffness="K", damping="D")
LAWS = (ViscousFriction(MOTOR, "Fv"), CoulombFriction(MOTOR, "Fs"), CoulombFriction(LOAD, "Fl"))
AXIS = Axis(
    "hidden_friction",
    (MOTOR, LOAD, *LAWS, SHAFT),
    Drive("F", MOTOR, held=True, noise=0.05),
    (Position("qm", MOTOR, noise=1e-7),),
)
TRUE = {"Mm": 10.0, "Ml": 20.0, "Fv": 50.0, "Fs": 5.0, "Fl": 30.0, "K": 2e4, "D": 100.0}
LOOP = Cascade("qm", position_gain=10.0, velocity_gain=600.0, integral_gain=5.0)


def test_the_load_slips_where_the_motor_does_not() -> None:
    with pytest.raises(EliminationError, match="cannot be eliminated"):
        derive(AXIS, ("qm",))
    path = trapezoids([0.2, 0.1], 0.3, acceleration=4.0, jerk=200.0, dwell=0.05, sampling_period=4e-3)
    log = simulate(AXIS, TRUE, path, LOOP, seed=3).log
    near = {name: 1.1 * value for name, value in TRUE.items()}
    found = identify_output_error(AXIS, ("qm",), log, loop=ClosedLoop(AXIS, LOOP, 250.0), nominal=near)
    assert found.fit is not None
    for (name, value), deviation in zip(
        found.physical_parameters.items(), found.physical_deviations, strict=True
    ):
        assert abs(value - TRUE[name]) < max(4 * deviation, 2e-3 * TRUE[name]), name
        assert deviation < 0.05 * TRUE[name], name
    assert found.minimal_parameters["Fl"] == found.physical_parameters["Fl"]


def test_names_and_maps_are_those_of_the_axis_without_the_hidden_law() -> None:
    whole, visible = models_of(AXIS, ("qm",))
    assert list(whole.physical_units) == list(TRUE)
    assert "Fl" not in visible.physical_units
    X = whole.minimal_parameters(*TRUE.values())
    # by hand: rigid mass and viscous friction of the chain at low frequencies, and the hidden friction last
    by_name = dict(zip(whole.minimal_units, X, strict=True))
    assert by_name["X5"] == pytest.approx(30.0 + 100.0 * 50.0 / 2e4)
    assert X[-1] == 30.0
    assert np.array_equal(X[:-1], visible.minimal_parameters(*(v for n, v in TRUE.items() if n != "Fl")))
    seen = models_of(AXIS.without(LAWS[2]), ("qm",))
    assert seen.whole is seen.visible


def test_without_the_controller_it_is_no_ok() -> None:
    """Predictions from the force do not know whether the load sticks: both masses come out exchanged."""
    elements = (MOTOR, LOAD, ViscousFriction(MOTOR, "Fv"), CoulombFriction(LOAD, "Fl"), SHAFT)
    sensors = (Position("qm", MOTOR, noise=1e-7),)
    axis = Axis("hidden_load", elements, Drive("F", MOTOR, held=True, noise=0.3), sensors)
    values = {"Mm": 10.0, "Ml": 20.0, "Fv": 50.0, "Fl": 8.0, "K": 2e5, "D": 100.0}
    path = trapezoids(
        [0.18, 0.06], [0.15, 0.5], acceleration=4.0, jerk=160.0, dwell=0.15, sampling_period=1e-3
    )
    loop = tuned_cascade(plant_of(axis, values), "qm", 10.0)
    log = simulate(axis, values, path, loop, seed=3).log
    near = {name: 1.2 * value for name, value in values.items()}
    found = identify_output_error(axis, ("qm",), log, nominal=near)
    assert found.status == "poor_fit"
    assert "give `controller`" in found.message
