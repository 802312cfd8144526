"""Logs of a rigid and of an elastic machine under one controller, for tests of what a diagnosis writes."""

from dataclasses import replace

from symid import (
    Axis,
    Body,
    CoulombFriction,
    Drive,
    Log,
    Position,
    Spring,
    ViscousFriction,
)
from symid.axis import Between
from symid.simulation import Cascade, Trajectory, simulate, trapezoids

MOTOR, LOAD = Body("motor", mass="M"), Body("load", mass="Ml")
FRICTION = (ViscousFriction(MOTOR, "Fv"), CoulombFriction(MOTOR, "Fs"))
SENSORS = (Position("q", MOTOR, noise=1e-7),)
RIGID = Axis("rigid", (MOTOR, *FRICTION), Drive("F", MOTOR, noise=0.3), SENSORS)
COUPLING = Between(first=MOTOR, second=LOAD)
ELASTIC = Axis(
    "elastic",
    (*RIGID.elements, LOAD, Spring("coupling", COUPLING, "K", damping="C")),
    RIGID.drive,
    (*SENSORS, Position("ql", LOAD, noise=1e-7)),
)
VALUES = {"M": 40.0, "Fv": 120.0, "Fs": 12.0, "Ml": 25.0, "K": 6e5, "C": 300.0}
LOOP = Cascade("q", position_gain=20.0, velocity_gain=2500.0, integral_gain=4.0)
PERIOD = 1e-3


def path(seed: int) -> Trajectory:
    """Strokes of two lengths at several speeds."""
    levels, speeds = {1: ([0.12, 0.04], [0.06, 0.2, 0.4]), 2: ([0.15, 0.05], [0.08, 0.3])}[seed]
    return trapezoids(levels, speeds, acceleration=2.5, jerk=50.0, dwell=0.1, sampling_period=PERIOD)


def machine(axis: Axis, values: dict[str, float], seed: int) -> Log:
    """A log of an axis under `LOOP`."""
    run = simulate(axis, values, path(seed), LOOP, seed=seed)
    return replace(run.log, source=f"run {seed}")
