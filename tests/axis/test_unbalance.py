"""A weight at an unknown angle, beside an own integration of the pendulum."""

import math

import numpy as np
import pytest
import scipy

from symid import Axis, Body, Drive, Position, Unbalance, ViscousFriction, derive, identify, simulate
from symid.errors import DeclarationError
from symid.simulation import Cascade, trapezoids

TABLE = Body("table", inertia="J")
AXIS = Axis(
    "unbalanced",
    (TABLE, ViscousFriction(TABLE, "Fv"), Unbalance(TABLE, "Gs", "Gc")),
    Drive("T", TABLE, held=True),
    (Position("q", TABLE),),
)
MOMENT, PHASE = 20.0, 2.2  # N m, rad: the sine term is negative
TRUE = {"J": 2.0, "Fv": 1.5, "Gs": MOMENT * math.cos(PHASE), "Gc": MOMENT * math.sin(PHASE)}
PATH = trapezoids([4.0], 5.0, acceleration=30.0, jerk=900.0, dwell=0.1, sampling_period=1e-3)


def test_simulation_and_identification_are_those_of_a_pendulum() -> None:
    loop = Cascade("q", position_gain=15.0, velocity_gain=120.0, integral_gain=5.0)
    log = simulate(AXIS, TRUE, PATH, loop).log
    state, found = np.zeros(2), []
    for torque in log["T"]:
        found.append(state[0])

        def rate(_: float, x: np.ndarray, held: float = torque) -> list[float]:
            return [x[1], (held - 1.5 * x[1] - MOMENT * math.sin(x[0] + PHASE)) / 2.0]

        state = scipy.integrate.solve_ivp(rate, (0, 1e-3), state, method="RK45", rtol=1e-9, atol=1e-12).y[
            :, -1
        ]
    assert np.ptp(log["q"]) > 3.5
    assert np.allclose(log["q"], found, atol=1e-5)
    result = identify(AXIS, log, examine=False)
    assert result.physical_parameters == pytest.approx(TRUE, rel=0.01)


def test_the_regressor_is_linear_in_sine_and_cosine() -> None:
    assert [str(entry) for entry in derive(AXIS).minimal.regressor[0]] == ["q_d2", "q_d1", "cos(q)", "sin(q)"]
    assert {"Gs", "Gc"} <= set(AXIS.signed_parameters)
    assert str(AXIS.parameter_units["Gs"]) == "N*m"


def test_bodies_without_an_angle_of_their_own_are_refused() -> None:
    slide, arm = Body("slide", mass="M"), Body("arm", inertia="Ja", on=TABLE)
    for body, statement in (
        (slide, "use Weight where it slides"),
        (arm, "relative to 'table', which turns too"),
    ):
        with pytest.raises(DeclarationError, match=statement):
            AXIS.with_effect(body, Unbalance(body, "A", "B"))
