"""Nonlinear laws that an axis declares in a spring whose deflection no sensor reads, beside scipy's integration."""

import numpy as np
import pytest
import scipy

from symid import (
    Axis,
    Backlash,
    Between,
    Body,
    Drive,
    Position,
    Spring,
    StiffnessNonlinearity,
    ViscousFriction,
)
from symid.arrays import FloatArray
from symid.axis import Law
from symid.data import Log
from symid.diagnosis.fitting.state import first_state, with_effects
from symid.diagnosis.prediction.record import record_of
from symid.simulation import forward_dynamics

VALUES = {"Mm": 18.0, "Ml": 31.0, "K": 4.2e5, "D": 160.0, "Fm": 35.0, "Fl": 22.0}
GAP = 60e-6
MOTOR, LOAD = Body("motor", mass="Mm"), Body("load", mass="Ml")
BELT = Between(first=MOTOR, second=LOAD)
RATES = 2 * np.pi * np.array([0.4, 1.3, 3.1, 7.7])
SIZES = np.array([0.05, 0.02, 0.006, 0.0012])
TIME = np.arange(4000) * 1e-3


def motor(t: FloatArray, order: int) -> FloatArray:
    """The motor's motion, or a derivative of it."""
    return np.asarray(np.real((1j * RATES) ** order * np.exp(1j * np.multiply.outer(t, RATES) - 1j)) @ SIZES)


def log_of(spring: FloatArray | float, cubic: float, gap: float) -> Log:
    """Position and force of the motor, whose load follows through a spring with a cubic part and play."""

    def belt(t: FloatArray, load: FloatArray) -> FloatArray:
        d, rate = load[0] - motor(t, 0), load[1] - motor(t, 1)
        clear = d - np.clip(d, -gap / 2, gap / 2)
        return np.asarray(spring * clear + cubic * d**3 + VALUES["D"] * rate)

    def rates(t: FloatArray, load: FloatArray) -> FloatArray:
        return np.array([load[1], (-belt(t, load) - VALUES["Fl"] * load[1]) / VALUES["Ml"]])

    start = [motor(TIME[:1], k)[0] for k in (0, 1)]
    load = scipy.integrate.solve_ivp(
        rates, (0, TIME[-1]), start, t_eval=TIME, rtol=1e-8, atol=1e-11, max_step=1e-3
    ).y
    force = VALUES["Mm"] * motor(TIME, 2) + VALUES["Fm"] * motor(TIME, 1) - belt(TIME, load)
    return Log("by hand", 0.0, 1e-3, {"q": motor(TIME, 0), "F": force})


@pytest.mark.parametrize(
    ("law", "log", "value"),
    [
        (Backlash(BELT, "Kb", gap=GAP), (VALUES["K"], 0.0, GAP), {"Kb": VALUES["K"]}),
        (StiffnessNonlinearity(BELT, "k3"), (VALUES["K"], 3e12, 0.0), {"k3": 3e12}),
    ],
)
def test_a_declared_law_of_a_hidden_spring_leaves_no_gap(
    law: Law, log: tuple[float, float, float], value: dict[str, float]
) -> None:
    spring = Spring("belt", BELT, stiffness="K", damping="D")
    elements = (MOTOR, LOAD, spring, law, ViscousFriction(MOTOR, "Fm"), ViscousFriction(LOAD, "Fl"))
    axis = Axis("slop", elements, Drive("F", MOTOR), (Position("q", MOTOR),))
    record = record_of(forward_dynamics(axis), log_of(*log), motion_hz=120.0)
    state, weighting = first_state(record, VALUES | value)
    for _ in range(4):
        state = with_effects(state, weighting, ())
    middle = (record.fine_time > 0.6) & (record.fine_time < 3.4)
    error, force = record.fine(state.errors[0])[middle], record.fine(record.measured[0])[middle]
    assert np.sqrt(np.mean(error**2)) < 0.01 * np.sqrt(np.mean(force**2))
